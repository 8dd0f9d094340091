"""Which settings a stage reads, and how they are taken from a configuration.

The class of a stage stands in its module, or is one of the library. The workflow passes a stage
just these settings, as JSON, and lists them as parameters of its rule: so a changed setting re-runs
the stages that read it and no other. Here are those that several modules read.
"""

from typing import TypeVar

from egad._util.parameters import ParameterGroup
from egad.grasps import LabelParameters
from egad.measures import MeasureParameters
from egad.pipeline.config import (
    Material,
    Postprocess,
    Rescale,
    Settings,
    Shape,
    Space,
    Training,
    TrainingSet,
    TrainingStudy,
    Trials,
)


class StageSettings(ParameterGroup):
    """The sections that one stage reads; `gripper`, `camera` and the like are entries of tables."""


class MeasureMeshes(MeasureParameters):
    """Any meshes: repaired, measured, and placed in the space."""

    postprocess: Postprocess
    material: Material
    space: Space


class LocateMeshes(MeasureMeshes):
    """The same among the objects of an archive."""

    shape: Shape


class ViewMesh(LabelParameters):
    """Labelled grasps of any mesh, scaled first."""

    rescale: Rescale


class TrainingStudyReport(StageSettings):
    """Networks that learnt from different objects side by side."""

    training_study: TrainingStudy
    training_sets: dict[str, TrainingSet]  # those that are compared, and those they show images of
    training: Training
    trials: Trials


S = TypeVar("S", bound=ParameterGroup)


def select(
    settings: Settings, stage: type[S], gripper: str | None = None, detector: str | None = None
) -> S:
    """The part of a configuration that a stage reads.

    Args:
        settings: The whole configuration.
        stage: The class of the settings that the stage reads.
        gripper: Name of the gripper, for stages that read one.
        detector: Name of the grasp detector, for the stage that tries one.
    """
    entries = ("gripper", "map_gripper", "camera", "detector")
    names = [name for name in stage.model_fields if name not in entries]
    values = {name: getattr(settings, name) for name in names}
    if issubclass(stage, MeasureParameters) and settings.difficulty.metric == "nominal":
        values["robust"] = None
    if "training_sets" in values:
        sets = settings.training_sets
        used = [[name, *sets[name].images] for name in settings.training_study.sets]
        values["training_sets"] = {name: sets[name] for names in used for name in names}
    if "gripper" in stage.model_fields:
        chooses = "select_eval" in values
        own = _narrowest(settings) if chooses else settings.difficulty.gripper
        values["gripper"] = settings.grippers[gripper or own]
    if "map_gripper" in stage.model_fields:
        values["map_gripper"] = settings.grippers[settings.difficulty.gripper]
    if "camera" in stage.model_fields:
        values["camera"] = settings.cameras[settings.render.camera]
    if "detector" in stage.model_fields:
        values["detector"] = settings.detectors[detector or settings.targets.detectors[0]]
    return stage(**values)


def _narrowest(settings: Settings) -> str:
    """The gripper that the evaluation set must be printable for."""
    named = settings.select_eval.gripper
    return named or min(settings.grippers, key=lambda name: settings.grippers[name].opening)
