"""The configuration of the study: which networks are compared, and how they are made and tested.

`python studies/training/study.py FILE` prints the settings of the workflow for a
configuration of the study, with its networks among the grasp detectors.
"""

import json
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeVar

import yaml
from pydantic import ConfigDict, Field, GetCoreSchemaHandler, ValidationError, model_validator
from typing_extensions import TypedDict

from egad._util.parameters import Name, ParameterGroup, Parameters, UserPath
from egad.bench import TrialProtocol
from egad.detectors import STEREO, DetectorConfig, ImageNoise
from egad.errors import UserError
from egad.learning import Training
from egad.learning.images import Render
from egad_workflow.check import check
from egad_workflow.config_files import read_values
from egad_workflow.references import unknown_names
from egad_workflow.settings import Settings

FOLDER = Path("results/training_study")
SET_SECTIONS = ("render", "image_noise", "training")  # those that a training set may change
P = TypeVar("P", bound=Parameters)


@dataclass(frozen=True)
class SomeOf:
    """Marks a table of some settings of a section: `Annotated[dict[str, Any], SomeOf(Section)]`.

    Each is checked as in the section; others are not allowed.

    Attributes:
        section: The section.
    """

    section: type[Parameters]

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> Mapping[str, object]:
        del source
        fields: dict[str, Any] = {
            name: Annotated[
                (field.annotation, *field.metadata, Field(description=field.description))
            ]
            for name, field in self.section.model_fields.items()
        }
        typed_dict: Any = TypedDict  # type checkers do not know keys set at run time
        table = typed_dict(f"SomeOf{self.section.__name__}", fields, total=False)
        table.__pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)
        return handler.generate_schema(table)


class TrainingSet(Parameters):
    """What networks are trained on, and how; or existing weights."""

    dataset: Name | None = Field(None, description="dataset of the objects that are rendered")
    images: list[Name] = Field(
        [],
        description="instead of `dataset`: training sets whose images are used, one of them with "
        "other settings of `training`, or several mixed",
    )
    weights: UserPath | None = Field(
        None, description="instead of `dataset`: file of existing weights; no network is trained"
    )
    seeds: int | None = Field(
        None, ge=1, le=100, description="networks trained on this set; nothing: as for all sets"
    )
    render: Annotated[dict[str, Any], SomeOf(Render)] = Field(
        {}, description="settings of the section `render` that are different for this set"
    )
    image_noise: Annotated[dict[str, Any], SomeOf(ImageNoise)] = Field(
        {}, description="settings of the section `image_noise` that are different for this set"
    )
    training: Annotated[dict[str, Any], SomeOf(Training)] = Field(
        {}, description="settings of the section `training` that are different for this set"
    )

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Self:
        sources = [name for name in ("dataset", "images", "weights") if getattr(self, name)]
        if len(sources) != 1:
            raise ValueError("a training set needs one of `dataset`, `images` and `weights`")
        refused = {
            "images": ("render", "image_noise"),
            "weights": (*SET_SECTIONS, "seeds"),
        }
        if given := [key for key in refused.get(sources[0], ()) if getattr(self, key)]:
            raise ValueError(f"a training set with `{sources[0]}` takes no `{given[0]}`")
        return self


class Plan(Parameters):
    """Comparison of networks trained on different object sets: README.md."""

    sets: list[Name] = Field(min_length=1, description="training sets to compare")
    seeds: int = Field(
        2, ge=1, le=100, description="networks trained on each set, with different random seeds"
    )
    tests: list[Name] = Field(
        min_length=1, description="datasets on whose evaluation sets the networks are tested"
    )
    noise: list[Literal["none", "stereo"]] = Field(
        ["none"],
        min_length=1,
        description="noise of depth images in the tests; stereo: as with trials.depth_noise: 0.1",
    )
    clutter: list[Literal["packed", "pile"]] = Field(
        [], description="scenes of several objects in which the networks are tested, too"
    )
    rounds: int = Field(20, ge=1, description="rounds of each of these scenes with each noise")
    references: list[Name] = Field(
        [], description="grasp detectors of the workflow to compare with the networks"
    )
    comparisons: list[tuple[Name, Name]] = Field(
        [],
        description="pairs of sets or references whose difference is tested, with Holm's "
        "correction for all pairs and all tests with single objects; everything else is "
        "exploratory",
    )
    object_curve: list[Name] = Field(
        [], description="sets of a learning curve over the number of objects"
    )
    image_curve: list[Name] = Field(
        [], description="sets of a learning curve over the number of images"
    )
    training_sets: dict[Name, TrainingSet] = Field(
        min_length=1, description="all training sets, by name"
    )

    @property
    def curves(self) -> dict[str, list[Name]]:
        """Training sets of each learning curve, by its x axis: objects or images."""
        return {"objects": self.object_curve, "images": self.image_curve}

    def image_sets(self, name: str) -> list[str]:
        """The training sets whose images a set consists of: itself, if it has a dataset."""
        chosen = self.training_sets[name]
        return [name] if chosen.dataset else chosen.images

    @property
    def networks(self) -> list["Network"]:
        """The networks of the sets that are compared; one for a set of given weights."""
        sets = {name: self.training_sets[name] for name in self.sets}
        counts = {
            name: 1 if each.weights else each.seeds or self.seeds for name, each in sets.items()
        }
        return [Network(name, seed) for name, count in counts.items() for seed in range(count)]

    @property
    def trained(self) -> list["Network"]:
        """Those networks that are trained here."""
        return [each for each in self.networks if not self.training_sets[each.training_set].weights]


class Network(NamedTuple):
    """A network of the study.

    Attributes:
        training_set: What it was trained on.
        seed: Number of its training, from 0; 0 for given weights.
    """

    training_set: str
    seed: int

    @property
    def name(self) -> str:
        """Its name as a grasp detector."""
        return f"{self.training_set}-{self.seed}"

    @property
    def folder(self) -> str:
        """Where it is trained, in the folder of networks."""
        return f"{self.training_set}/{self.seed}"


class Study(NamedTuple):
    """The whole configuration.

    Attributes:
        plan: What is compared.
        settings: Settings of the workflow, with the networks among the grasp detectors.
    """

    plan: Plan
    settings: Settings

    @property
    def gripper(self) -> str:
        """The gripper of the study: the first target."""
        return self.settings.targets.grippers[0]

    @property
    def workflow_config(self) -> dict[str, Any]:
        """The configuration of the workflow, as a file has it; defaults are left out."""
        values: dict[str, Any] = json.loads(self.settings.model_dump_json(exclude_unset=True))
        return values


class PageSettings(ParameterGroup):
    """What the page about the study reads."""

    plan: Plan  # with the training sets that are compared, and those that they show images of
    training: Training
    trials: TrialProtocol


def read_study(path: Path) -> Study:
    """The study that a configuration file describes.

    Raises:
        UserError: Something is wrong; the text has a line for each problem.
    """
    return study_of(read_values(path))


def study_of(config: Mapping[str, Any]) -> Study:
    """The study that a configuration describes.

    Args:
        config: The keys of `Plan`, and `egad`, the settings of the workflow.

    Raises:
        UserError: Something is wrong; the text has a line for each problem.
    """
    values = dict(config)
    problems: list[str] = []
    settings, plan = Settings(), None
    try:
        settings = check(values.pop("egad", {}))
    except UserError as error:
        problems += [f"egad.{line}" for line in str(error).split("\n")]
    try:
        # JSON, as lists are tuples there; strict, as a number in quotes is a mistake
        plan = Plan.model_validate_json(json.dumps(values, default=str), strict=True)
    except ValidationError as error:
        problems += [_sentence(each) for each in error.errors(include_url=False)]
    if plan and not problems:
        problems = _wrong_names(plan, settings)
    if problems or not plan:
        raise UserError("\n".join(problems))
    return Study(plan, _with_networks(settings, plan))


def _sentence(problem: Mapping[str, Any]) -> str:
    """The line that describes an error of pydantic."""
    error = problem.get("ctx", {}).get("error")
    return f"{'.'.join(map(str, problem['loc']))}: {error or problem['msg']}"


def _wrong_names(plan: Plan, settings: Settings) -> list[str]:
    """Unknown names, and settings of training sets that do not go together.

    Training sets that are not used may name a missing dataset.
    """
    sets, datasets = plan.training_sets, settings.datasets
    used = [name for name in plan.sets if name in sets]
    images = dict.fromkeys(name for key in used for name in sets[key].images if name in sets)
    own = {name: each for name, each in sets.items() if each.dataset}
    compared = dict.fromkeys([*plan.sets, *plan.references])
    trained = {name: sets[name] for name in used if not sets[name].weights}
    used_names: list[tuple[str, Iterable[str], Mapping[str, object]]] = [
        ("sets", plan.sets, sets),
        ("tests", plan.tests, datasets),
        ("references", plan.references, settings.detectors),
        ("object_curve", plan.object_curve, trained),
        ("image_curve", plan.image_curve, trained),
        *(("comparisons", pair, compared) for pair in plan.comparisons),
        *((f"training_sets.{name}.images", sets[name].images, own) for name in used),
    ]
    problems = [line for each in used_names for line in unknown_names(*each)]
    twice = sorted({*plan.sets} & {*plan.references})
    problems += [f"references: {name!r} is a training set, too" for name in twice]
    for name in dict.fromkeys([*used, *images]):
        problems += _problems_of_set(name, plan, settings)
    if FOLDER.name in datasets:
        problems.append(f"egad.datasets.{FOLDER.name}: that is the folder of the study; rename it")
    if not problems:
        problems = [
            f"egad.detectors.{network.name}: that is what a network of the training set "
            f"{network.training_set} is called; rename one of them"
            for network in plan.networks
            if network.name in settings.detectors
        ]
    return problems


def _problems_of_set(name: str, plan: Plan, settings: Settings) -> list[str]:
    """What is wrong with a training set, apart from its images."""
    chosen, path = plan.training_sets[name], f"training_sets.{name}"
    dataset = [chosen.dataset] if chosen.dataset else []
    camera = [chosen.render["camera"]] if "camera" in chosen.render else []
    problems = [
        *unknown_names(f"{path}.dataset", dataset, settings.datasets),
        *unknown_names(f"{path}.render.camera", camera, settings.cameras),
    ]
    for key in SET_SECTIONS:
        try:
            changed(getattr(settings, key), getattr(chosen, key))
        except ValidationError as error:
            problems += [f"{path}.{key}: {each['ctx']['error']}" for each in error.errors()]
    positive = chosen.training.get("positive", settings.training.positive)
    shown = [name for name in (chosen.images or [name]) if name in plan.training_sets]
    simulated = [
        plan.training_sets[name].render.get("simulate", settings.render.simulate) for name in shown
    ]
    if positive == "simulated" and not chosen.weights and not all(simulated):
        problems.append(
            f"{path}.training.positive: simulated needs images with render.simulate: true"
        )
    return problems


def changed(section: P, changes: Mapping[str, Any]) -> P:
    """A section with some settings changed.

    Raises:
        ValidationError: They do not go together.
    """
    return type(section)(**{**section.model_dump(), **changes})


def _with_networks(settings: Settings, plan: Plan) -> Settings:
    """The same with the networks among the grasp detectors, so that they are tried like others."""
    detectors = dict(settings.detectors)
    for network in plan.networks:
        given = plan.training_sets[network.training_set].weights
        trained = (FOLDER / "networks" / network.folder / "weights.safetensors").as_posix()
        detectors[network.name] = DetectorConfig(detector="ggcnn", weights=given or trained)
    return settings.model_copy(update={"detectors": detectors})


def settings_for(study: Study, network: Network) -> Settings:
    """The settings that the images of a training set and a network are made with.

    The images of all sets have the same seed; networks of a set differ in the seed of training.
    """
    plan, settings = study
    chosen = plan.training_sets[network.training_set]
    sections = {
        name: changed(getattr(settings, name), getattr(chosen, name)) for name in SET_SECTIONS
    }
    return settings.model_copy(update={**sections, "seed": settings.seed + network.seed})


def settings_of_tests(study: Study, noise: str = "none") -> Settings:
    """The settings that networks are tested with.

    Args:
        study: The whole configuration.
        noise: Noise of the depth images of trials with single objects: none or stereo. Cleared
            tables have all kinds of noise of the study.
    """
    plan, settings = study
    depth_noise = STEREO.disparity if noise == "stereo" else 0.0
    scenes = {"scenes": tuple(plan.clutter), "noise": tuple(plan.noise), "rounds": plan.rounds}
    parts = {
        "trials": settings.trials.model_copy(update={"depth_noise": depth_noise}),
        "clutter": settings.clutter.model_copy(update=scenes),
    }
    return settings.model_copy(update=parts)


def page_settings(study: Study) -> PageSettings:
    """What the page reads, without training sets that are not used."""
    plan, settings = study
    used = [name for key in plan.sets for name in (key, *plan.training_sets[key].images)]
    sets = {name: plan.training_sets[name] for name in used}
    chosen = plan.model_copy(update={"training_sets": sets})
    return PageSettings(plan=chosen, training=settings.training, trials=settings.trials)


if __name__ == "__main__":
    sys.stdout.write(yaml.safe_dump(read_study(Path(sys.argv[1])).workflow_config))
