"""Which settings each stage reads.

The workflow passes a stage just these, as JSON, and lists them as parameters of its rule: so a
changed setting re-runs the stages that read it and no other.
"""

from typing import TypeVar

from egad._util.parameters import ParameterGroup
from egad.grasps.parameters import LabelParameters
from egad.map_elites.parameters import EvolutionParameters  # noqa: F401 (found by its name)
from egad.measures.parameters import (
    MeasureParameters,
    SizeEffectParameters,  # noqa: F401 (found by its name)
)
from egad.perception.parameters import RenderParameters  # noqa: F401 (found by its name)
from egad.pipeline.config import (
    Acronym,
    Axes,
    Bundle,
    DexNet,
    Diversity,
    Engraving,
    Gripper,
    Material,
    Postprocess,
    PrintCheck,
    PrintExport,
    Quality,
    Render,
    Rescale,
    Robust,
    SelectEval,
    Settings,
    Shape,
    Similarity,
    Space,
    Training,
    TrainingSet,
    Trials,
)
from egad.sim.parameters import (
    LabelTrialParameters,  # noqa: F401 (found by its name)
    TrialParameters,  # noqa: F401 (found by its name)
)


class StageSettings(ParameterGroup):
    """The sections that one stage reads; `gripper`, `camera`, `policy` are entries of tables."""


class Merge(StageSettings):
    """The islands of an epoch become one archive."""

    space: Space
    similarity: Similarity


class MeasureMeshes(MeasureParameters):
    """Any meshes: repaired, measured, and placed in the space."""

    postprocess: Postprocess
    material: Material
    space: Space


class LocateMeshes(MeasureMeshes):
    """The same among the objects of an archive."""

    shape: Shape


class PostprocessSolids(MeasureParameters):
    """Repair, mass properties and measures of the objects of a shard."""

    postprocess: Postprocess
    material: Material
    shape: Shape


class Collect(StageSettings):
    """Cells, labels and diversities of a whole dataset."""

    space: Space
    similarity: Similarity


class RescaleMeshes(StageSettings):
    """Scaling to a gripper."""

    gripper: Gripper
    rescale: Rescale


class ViewMesh(LabelParameters):
    """Labelled grasps of any mesh, scaled first."""

    rescale: Rescale


class EvalSelection(StageSettings):
    """The evaluation set."""

    seed: int
    space: Space
    similarity: Similarity
    select_eval: SelectEval
    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck


class PrintFiles(StageSettings):
    """Files for printers."""

    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck
    print_export: PrintExport
    engraving: Engraving


class DataSheets(StageSettings):
    """The datasheet of an evaluation set."""

    select_eval: SelectEval
    print_export: PrintExport


class SimulationBundle(StageSettings):
    """Files for simulators."""

    material: Material
    bundle: Bundle


class DexNetObjects(StageSettings):
    """Objects of a Dex-Net database: distance fields, stable poses, masses."""

    material: Material
    dexnet: DexNet


class DexNetDatabase(StageSettings):
    """A Dex-Net database: the grasps, and how they were rated."""

    gripper: Gripper
    quality: Quality
    robust: Robust


class AcronymFiles(StageSettings):
    """ACRONYM files."""

    gripper: Gripper
    quality: Quality
    acronym: Acronym


class TrainNetwork(StageSettings):
    """Training of a grasp network."""

    seed: int
    training: Training


class ImageLayouts(StageSettings):
    """The same laid out as other datasets."""

    gripper: Gripper


class DiversityReport(StageSettings):
    """Networks that learnt from different objects side by side."""

    diversity: Diversity
    training_sets: dict[str, TrainingSet]  # those that are compared
    render: Render
    training: Training
    trials: Trials
    select_eval: SelectEval
    axes: Axes


class Compare(StageSettings):
    """Datasets side by side."""

    space: Space
    axes: Axes


S = TypeVar("S", bound=ParameterGroup)


def select(
    settings: Settings, stage: type[S], gripper: str | None = None, policy: str | None = None
) -> S:
    """The part of a configuration that a stage reads.

    Args:
        settings: The whole configuration.
        stage: One of the classes above.
        gripper: Name of the gripper, for stages that read one.
        policy: Name of the grasp detector, for the stage that tries one.
    """
    names = [name for name in stage.model_fields if name not in ("gripper", "camera", "policy")]
    values = {name: getattr(settings, name) for name in names}
    if issubclass(stage, MeasureParameters) and settings.difficulty.metric == "plain":
        values["robust"] = None
    if "training_sets" in values:
        values["training_sets"] = {
            name: settings.training_sets[name] for name in settings.diversity.sets
        }
    if "gripper" in stage.model_fields:
        own = _narrowest(settings) if stage is EvalSelection else settings.difficulty.gripper
        values["gripper"] = settings.grippers[gripper or own]
    if "camera" in stage.model_fields:
        values["camera"] = settings.cameras[settings.render.camera]
    if "policy" in stage.model_fields:
        values["policy"] = settings.policies[policy or settings.targets.policies[0]]
    return stage(**values)


def _narrowest(settings: Settings) -> str:
    """The gripper that the evaluation set must be printable for."""
    named = settings.select_eval.gripper
    return named or min(settings.grippers, key=lambda name: settings.grippers[name].opening)
