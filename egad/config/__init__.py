"""Every setting of the pipeline, as pydantic models.

The models are the only source of names, defaults, bounds and meanings: `check` says what is wrong
with a configuration, `manual` lists them all in `config/README.md`.
Lengths are metres, masses kilograms, densities kg/m3, forces newtons, angles degrees.
"""

from egad._util.parameters import Axis, Name, Parameters, Range, ScaleRule
from egad.config.sections import (
    DatasetSection,
    Postprocess,
    Release,
    Schedule,
    Targets,
)
from egad.config.settings import Settings
from egad.cppn import Envelope, Hole, KeepSolid, Limits, Neat, Region, Shape, Symmetry
from egad.detectors import DETECTORS, DetectorConfig
from egad.evalset import Bundle, Engraving, PrintCheck, PrintExport, SelectEval
from egad.exchange import Acronym, DexNet
from egad.geometry import Material, Rescale
from egad.grasps import GraspLabel, Quality, Robust, Sampling
from egad.grippers import GRIPPERS, Gripper
from egad.learning import Training, VgnTraining
from egad.map_elites import Evolution
from egad.measures import Complexity, CustomMeasures, Graspability, MeasureSpace, SizeEffect
from egad.perception import CAMERAS, Camera, ImageNoise, Render
from egad.reeb import Similarity
from egad.scenes import TrainingScenes
from egad.sim import LabelAgreement, Lifting, NaiveGrasp, SimulatedLabel, TrialProtocol

__all__ = [
    "CAMERAS",
    "DETECTORS",
    "GRIPPERS",
    "Acronym",
    "Axis",
    "Bundle",
    "Camera",
    "Complexity",
    "CustomMeasures",
    "DatasetSection",
    "DetectorConfig",
    "DexNet",
    "Engraving",
    "Envelope",
    "Evolution",
    "GraspLabel",
    "Graspability",
    "Gripper",
    "Hole",
    "ImageNoise",
    "KeepSolid",
    "LabelAgreement",
    "Lifting",
    "Limits",
    "Material",
    "MeasureSpace",
    "NaiveGrasp",
    "Name",
    "Neat",
    "Parameters",
    "Postprocess",
    "PrintCheck",
    "PrintExport",
    "Quality",
    "Range",
    "Region",
    "Release",
    "Render",
    "Rescale",
    "Robust",
    "Sampling",
    "ScaleRule",
    "Schedule",
    "SelectEval",
    "Settings",
    "Shape",
    "Similarity",
    "SimulatedLabel",
    "SizeEffect",
    "Symmetry",
    "Targets",
    "Training",
    "TrainingScenes",
    "TrialProtocol",
    "VgnTraining",
]
