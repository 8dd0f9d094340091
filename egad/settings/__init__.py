"""Every setting of the pipeline, as pydantic models.

The models are the only source of names, defaults, bounds and meanings. `egad.config_files`
generates `config/*.yaml` and the JSON schema from them, and turns validation errors into sentences.
Lengths are metres, masses kilograms, densities kg/m3, forces newtons, angles degrees.
"""

from egad.settings.base import Axis, Name, Range, ScaleRule, Section
from egad.settings.datasets import Dataset, Targets
from egad.settings.diversity import TRAINING_SETS, Diversity, TrainingSet
from egad.settings.evolution import Evolution, Neat, Schedule
from egad.settings.exchange import Acronym, DexNet
from egad.settings.grasps import GraspLabel, Quality, Robust, Sampling, SizeEffect
from egad.settings.grippers import GRIPPERS, Gripper
from egad.settings.images import CAMERAS, Camera, ImageNoise, Render
from egad.settings.measures import Axes, Complexity, Difficulty, Similarity, Space
from egad.settings.objects import (
    Bundle,
    Engraving,
    Material,
    Postprocess,
    PrintCheck,
    PrintExport,
    Rescale,
    SelectEval,
)
from egad.settings.shapes import Envelope, Hole, Limits, Part, Region, Shape, Symmetry
from egad.settings.training import Training
from egad.settings.trials import POLICIES, Agreement, Lifting, Policy, Trials
from egad.settings.whole import Settings

__all__ = [
    "CAMERAS",
    "GRIPPERS",
    "POLICIES",
    "TRAINING_SETS",
    "Acronym",
    "Agreement",
    "Axes",
    "Axis",
    "Bundle",
    "Camera",
    "Complexity",
    "Dataset",
    "DexNet",
    "Difficulty",
    "Diversity",
    "Engraving",
    "Envelope",
    "Evolution",
    "GraspLabel",
    "Gripper",
    "Hole",
    "ImageNoise",
    "Lifting",
    "Limits",
    "Material",
    "Name",
    "Neat",
    "Part",
    "Policy",
    "Postprocess",
    "PrintCheck",
    "PrintExport",
    "Quality",
    "Range",
    "Region",
    "Render",
    "Rescale",
    "Robust",
    "Sampling",
    "ScaleRule",
    "Schedule",
    "Section",
    "SelectEval",
    "Settings",
    "Shape",
    "Similarity",
    "SizeEffect",
    "Space",
    "Symmetry",
    "Targets",
    "Training",
    "TrainingSet",
    "Trials",
]
