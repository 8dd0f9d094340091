"""The sections of the configuration that each stage reads.

A rule passes its stage these settings alone, as a parameter, so a changed setting re-runs the
stages that read it and no others.
"""

from typing import TypeVar

from egad._util.parameters import ParameterGroup
from egad.bench import ClutterParameters, NaiveGraspParameters, TrialParameters
from egad.bench.failures import FailureParameters
from egad.config.sections import Postprocess, Release
from egad.config.settings import Settings
from egad.detectors import DetectorConfig
from egad.evalset import Engraving, PrintCheck, PrintExport, SelectEval
from egad.evolution import EvolutionParameters, Shape
from egad.exchange import DexNet
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import LabelParameters, Quality
from egad.grippers import Gripper
from egad.learning import Training, VgnTraining
from egad.learning.images import RenderParameters
from egad.learning.scenes import SceneParameters
from egad.measures import MeasureParameters, MeasureSpace, SizeEffectParameters, space_of
from egad.measures.reeb import Similarity
from egad.sim import Lifting, SimulatedLabel, SimulatedLabelParameters


class MeasureMeshes(MeasureParameters):
    """Any meshes: repaired, measured, and placed in the space."""

    postprocess: Postprocess
    material: Material
    space: MeasureSpace


class ViewMesh(LabelParameters):
    """Labelled grasps of any mesh, scaled first."""

    rescale: Rescale


class GraspabilityOfGripper(MeasureParameters):
    """Measures of objects for one gripper."""

    postprocess: Postprocess


class PostprocessSolids(MeasureParameters):
    """Repair, mass properties and measures of the objects of a shard."""

    postprocess: Postprocess
    material: Material
    shape: Shape


class CellsAndDiversities(ParameterGroup):
    """The cells of objects, and how much their shapes differ."""

    space: MeasureSpace
    similarity: Similarity


class EvalSelection(ParameterGroup):
    """The evaluation set."""

    seed: int
    space: MeasureSpace
    similarity: Similarity
    select_eval: SelectEval
    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck


class RescaleMeshes(ParameterGroup):
    """Scaling to a gripper."""

    gripper: Gripper
    rescale: Rescale


class PrintFiles(ParameterGroup):
    """Files for printers."""

    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck
    print_export: PrintExport
    engraving: Engraving


class SimulationBundle(ParameterGroup):
    """Objects for simulators: their convex parts, mass and friction."""

    material: Material
    bundle: Bundle


class SimulatedTrials(TrialParameters):
    """Simulated trials of a grasp detector."""

    detector: DetectorConfig


class ClearedTables(ClutterParameters):
    """Rounds of clearing a table with a grasp detector."""

    detector: DetectorConfig


class DetectorFailures(FailureParameters):
    """Search for failures of a grasp detector."""

    detector: DetectorConfig


class SimulatedLabels(SimulatedLabelParameters):
    """Simulated labels of the grasps of a gripper."""

    material: Material


class NaiveGrasps(NaiveGraspParameters):
    """Naive grasps of objects with a gripper."""

    material: Material


class RenderImages(RenderParameters):
    """Depth images of objects at rest; some need a simulation."""

    material: Material
    trials: Lifting
    simulated_label: SimulatedLabel

    @property
    def labels(self) -> SimulatedLabelParameters:
        """What simulated labels depend on."""
        names = SimulatedLabelParameters.model_fields
        return SimulatedLabelParameters(**{name: getattr(self, name) for name in names})


class MakeScenes(SceneParameters):
    """Labelled scenes of the objects of a dataset."""

    material: Material


class DataSheets(ParameterGroup):
    """The datasheet of an evaluation set."""

    select_eval: SelectEval
    print_export: PrintExport


class Gallery(EvolutionParameters):
    """The gallery: how genomes become shapes, the space, and the gripper of the release."""

    map_gripper: Gripper  # the one that graspability is for
    release: Release


class DexNetObjects(ParameterGroup):
    """Objects of a Dex-Net database: distance fields, stable poses, masses."""

    material: Material
    dexnet: DexNet


class TrainNetwork(ParameterGroup):
    """Training of a grasp network on images."""

    seed: int
    training: Training


class TrainOnScenes(ParameterGroup):
    """Training of a grasp network on labelled scenes."""

    seed: int
    training_vgn: VgnTraining
    gripper: Gripper


class ReleaseTables(ParameterGroup):
    """Tables of a release."""

    seed: int
    release: Release


class ReleaseCard(ParameterGroup):
    """What the card of a release says."""

    release: Release
    material: Material
    quality: Quality


S = TypeVar("S", bound=ParameterGroup)


def select(
    settings: Settings, stage: type[S], gripper: str | None = None, detector: str | None = None
) -> S:
    """The part of a configuration that a stage, a class of settings, reads.

    Some stages read one gripper, and one tries a grasp detector.
    """
    entries = ("gripper", "map_gripper", "camera", "detector", "density", "labels", "breeding")
    names = [name for name in stage.model_fields if name not in entries]
    values = {name: getattr(settings, name) for name in names}
    if "gripper" in stage.model_fields:
        chooses = "select_eval" in values
        own = _narrowest(settings) if chooses else settings.graspability.gripper
        values["gripper"] = settings.grippers[gripper or own]
        lifts = values["gripper"].kind.lifts
        # settings that change nothing are left out: stages would run again for them
        robust = issubclass(stage, MeasureParameters) and settings.graspability.metric == "robust"
        if issubclass(stage, MeasureParameters | SizeEffectParameters) and not (lifts or robust):
            values["robust"] = None
        if "density" in stage.model_fields:
            values["density"] = settings.material.density if lifts else Material().density
        if "space" in stage.model_fields:
            # cells of an evaluation set are those of the map, whatever it is printed for
            values["space"] = (
                settings.space if chooses else space_of(values["gripper"], settings.space)
            )
    if "map_gripper" in stage.model_fields:
        values["map_gripper"] = settings.grippers[settings.graspability.gripper]
    if "camera" in stage.model_fields:
        values["camera"] = settings.cameras[settings.render.camera]
    if "labels" in stage.model_fields:
        values["labels"] = select(settings, LabelParameters, gripper)
    if "breeding" in stage.model_fields:
        values["breeding"] = select(settings, EvolutionParameters)
    if "detector" in stage.model_fields:
        values["detector"] = settings.detectors[detector or settings.targets.detectors[0]]
    return stage(**values)


def _narrowest(settings: Settings) -> str:
    """The gripper that the evaluation set must be printable for."""
    named = settings.select_eval.gripper
    return named or min(settings.grippers, key=lambda name: settings.grippers[name].opening)
