"""The configuration of the study of scenes: sets, networks, tests."""

import json
from collections.abc import Mapping
from itertools import chain
from typing import Any, NamedTuple

from pydantic import Field, ValidationError

from egad._util.parameters import Fraction, Name, Parameters, UserPath
from egad.bench import NAMED_PROTOCOLS, SceneCameras
from egad.errors import UserError
from egad_workflow.check import check
from egad_workflow.settings import Settings

FOLDER = "results/scene_study"
PAIRS = (("evolved", "primitives"), ("tuned-evolved", "tuned-primitives"))  # ours and its rival
PUBLISHED = ("vgn", "vgn-low")


class SceneSet(Parameters):
    """What networks are trained on."""

    dataset: Name = Field(description="dataset of the scenes")
    scenes: int | None = Field(None, ge=1, description="most training scenes; nothing: all")
    networks: int | None = Field(None, ge=1, description="networks; nothing: as for all sets")
    start: UserPath | None = Field(None, description="weights to begin with; nothing: random ones")
    examples: int | None = Field(
        None, ge=1, description="training examples; nothing: as in `egad.training`"
    )


class TestCameras(Parameters):
    """A condition of the tests."""

    rounds: int = Field(ge=1, description="rounds of each kind of scene and noise")
    cameras: SceneCameras = SceneCameras()


class ScenePlan(Parameters):
    """What is compared."""

    sets: dict[Name, SceneSet]
    networks: int = Field(ge=1, description="networks trained on each set")
    threshold: Fraction = Field(description="least quality of the grasps that they propose")
    references: list[Name]
    tests: list[Name] = Field(description="datasets whose evaluation sets are cleared")
    cameras: dict[Name, TestCameras]


class SceneStudy(NamedTuple):
    """The whole configuration.

    Attributes:
        plan: What is compared.
        settings: Settings of the workflow, with the networks among the detectors.
    """

    plan: ScenePlan
    settings: Settings

    @property
    def workflow_config(self) -> dict[str, Any]:
        """The configuration of the workflow, as a file has it; defaults are left out."""
        values: dict[str, Any] = json.loads(self.settings.model_dump_json(exclude_unset=True))
        return values

    @property
    def detectors(self) -> list[str]:
        """All that are tested: networks first."""
        return [*networks_of(self.plan), *self.plan.references]


def study_of(config: Mapping[str, Any]) -> SceneStudy:
    """The study of a configuration.

    Raises:
        UserError: Something is wrong with it.
    """
    values = dict(config)
    workflow = dict(values.pop("egad", {}))
    try:
        plan = ScenePlan.model_validate(values, strict=False)
    except ValidationError as error:
        raise UserError(str(error)) from error
    networks = {
        name: {
            "detector": "vgn",
            "weights": f"{FOLDER}/networks/{training_set}/{seed}/weights.safetensors",
            "threshold": plan.threshold,
        }
        for name, (training_set, seed) in networks_of(plan).items()
    }
    workflow["detectors"] = {**workflow.get("detectors", {}), **networks}
    settings = check(workflow)
    datasets = [*plan.tests, *(each.dataset for each in plan.sets.values())]
    wrong = sorted({*datasets} - {*settings.datasets}) + sorted(
        {*plan.references} - {*settings.detectors}
    )
    if wrong:
        raise UserError(f"not defined: {', '.join(wrong)}")
    if needed := {*chain(*PAIRS), *PUBLISHED} - {*plan.sets, *plan.references}:
        raise UserError(f"the goals compare these, too: {', '.join(sorted(needed))}")
    if "six" not in plan.cameras:
        raise UserError("the goals are about the cameras `six`")
    if not settings.scenes.hold_out:
        raise UserError("egad.scenes.hold_out is false: networks would be trained on the tests")
    return SceneStudy(plan, settings)


def networks_of(plan: ScenePlan) -> dict[str, tuple[str, int]]:
    """Set and number of each network, by its name as a detector."""
    return {
        f"{name}-{seed}": (name, seed)
        for name, each in plan.sets.items()
        for seed in range(each.networks or plan.networks)
    }


def training_scenes(study: SceneStudy) -> dict[str, int]:
    """How many scenes the networks of each set are trained on, if all could be made."""
    scenes = study.settings.scenes
    whole = scenes.scenes - sum(round(p * scenes.scenes) for p in (scenes.validation, scenes.test))
    return {name: min(each.scenes or whole, whole) for name, each in study.plan.sets.items()}


def training_settings(study: SceneStudy, training_set: str, seed: int) -> Settings:
    """The settings of a training."""
    chosen, usual = study.plan.sets[training_set], study.settings.training
    update = {"scenes": chosen.scenes, "examples": chosen.examples or usual.examples}
    training = usual.model_copy(update=update)
    return study.settings.model_copy(
        update={"seed": study.settings.seed + seed, "training": training}
    )


def condition_settings(study: SceneStudy, cameras: str) -> Settings:
    """The settings of the tables that are cleared."""
    condition = study.plan.cameras[cameras]
    protocol = NAMED_PROTOCOLS["egad"].model_copy(update={"cameras": condition.cameras})
    clutter = study.settings.clutter.model_copy(
        update={"rounds": condition.rounds, "protocol": protocol}
    )
    return study.settings.model_copy(update={"clutter": clutter})
