"""The whole configuration."""

from collections.abc import Iterable, Mapping
from typing import Any, Self, TypeVar

from pydantic import Field, ValidationError, model_validator

from egad._util.parameters import Name, Parameters, Seed
from egad.cppn import Envelope, Hole, KeepSolid, Limits, Neat, Shape, Symmetry
from egad.detectors import DETECTORS, DetectorConfig
from egad.evalset import Bundle, Engraving, PrintCheck, PrintExport, SelectEval
from egad.exchange import Acronym, DexNet
from egad.geometry import Material
from egad.grasps import GraspLabel, Quality, Robust, Sampling
from egad.grippers import GRIPPERS, Gripper
from egad.learning import Training
from egad.map_elites import Evolution
from egad.measures import Complexity, CustomMeasures, Difficulty, SizeEffect, Space
from egad.perception import CAMERAS, Camera, ImageNoise, Render
from egad.pipeline.config.sections import (
    SET_SECTIONS,
    TRAINING_SETS,
    Dataset,
    Postprocess,
    Release,
    Rescale,
    Schedule,
    Targets,
    TrainingSet,
    TrainingStudy,
)
from egad.reeb import Similarity
from egad.sim import Agreement, Clutter, SimulatedLabel, Trials

P = TypeVar("P", bound=Parameters)


class Settings(Parameters):
    """The whole configuration."""

    seed: Seed = Field(0, description="seed of all random numbers")
    shards: int = Field(
        4, ge=1, le=1024, description="jobs per dataset; does not change any result"
    )
    datasets: dict[Name, Dataset] = Field(
        {"egad": Dataset(source="evolved")}, min_length=1, description="all datasets, by name"
    )
    targets: Targets = Targets()
    schedule: Schedule = Schedule()
    evolution: Evolution = Evolution()
    neat: Neat = Neat()
    shape: Shape = Shape()
    envelope: Envelope = Envelope()
    keep_solid: KeepSolid = KeepSolid()
    hole: Hole = Hole()
    symmetry: Symmetry = Symmetry()
    limits: Limits = Limits()
    space: Space = Space()
    measures: CustomMeasures = CustomMeasures()
    complexity: Complexity = Complexity()
    difficulty: Difficulty = Difficulty()
    similarity: Similarity = Similarity()
    sampling: Sampling = Sampling()
    quality: Quality = Quality()
    robust: Robust = Robust()
    material: Material = Material()
    postprocess: Postprocess = Postprocess()
    grasp_label: GraspLabel = GraspLabel()
    size_effect: SizeEffect = SizeEffect()
    rescale: Rescale = Rescale()
    select_eval: SelectEval = SelectEval()
    print_check: PrintCheck = PrintCheck()
    print_export: PrintExport = PrintExport()
    engraving: Engraving = Engraving()
    bundle: Bundle = Bundle()
    dexnet: DexNet = DexNet()
    acronym: Acronym = Acronym()
    trials: Trials = Trials()
    clutter: Clutter = Clutter()
    simulated_label: SimulatedLabel = SimulatedLabel()
    agreement: Agreement = Agreement()
    training: Training = Training()
    render: Render = Render()
    image_noise: ImageNoise = ImageNoise()
    training_study: TrainingStudy = TrainingStudy()
    release: Release = Release()
    grippers: dict[Name, Gripper] = Field(
        GRIPPERS, min_length=1, description="all grippers, by name"
    )
    cameras: dict[Name, Camera] = Field(
        CAMERAS, min_length=1, description="all cameras of rendered images, by name"
    )
    detectors: dict[Name, DetectorConfig] = Field(
        DETECTORS, min_length=1, description="all grasp detectors, by name"
    )
    training_sets: dict[Name, TrainingSet] = Field(
        TRAINING_SETS, min_length=1, description="all training sets of networks, by name"
    )

    @model_validator(mode="after")
    def _names_refer_to_something(self) -> Self:
        problems = [
            *_unknown("targets.datasets", self.targets.datasets, self.datasets),
            *_unknown("targets.grippers", self.targets.grippers, self.grippers),
            *_unknown("targets.detectors", self.targets.detectors, self.detectors),
            *_unknown("targets.clutter", self.targets.clutter, self.detectors),
            *_unknown("render.camera", [self.render.camera], self.cameras),
            *_unknown("difficulty.gripper", [self.difficulty.gripper], self.grippers),
            *_unknown(
                "select_eval.gripper",
                [name] if (name := self.select_eval.gripper) else [],
                self.grippers,
            ),
            *self._unknown_in_study(),
            *self._unknown_in_release(),
        ]
        evolved = [name for name, data in self.datasets.items() if data.source == "evolved"]
        if len(evolved) > 1:
            problems.append(
                f"datasets: at most one can have the source `evolved`, got {', '.join(evolved)}"
            )
        if "training_study" in self.datasets:
            problems.append(
                "datasets.training_study: the name is reserved for the folder of the study"
            )
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _unknown_in_study(self) -> list[str]:
        """Unknown names of the training study, and settings of its sets that do not go together.

        Training sets that are not used may name a missing dataset.
        """
        study, sets = self.training_study, self.training_sets
        used = [name for name in study.sets if name in sets]
        images = dict.fromkeys(name for key in used for name in sets[key].images if name in sets)
        own = {name: each for name, each in sets.items() if each.dataset}
        compared = dict.fromkeys([*study.sets, *study.references])
        trained = [name for name in study.sets if name in sets and not sets[name].weights]
        curves = {key: getattr(study, key) for key in ("object_curve", "image_curve")}
        twice = sorted({*study.sets} & {*study.references})
        return [
            *_unknown("training_study.sets", study.sets, sets),
            *_unknown("training_study.tests", study.tests, self.datasets),
            *_unknown("training_study.references", study.references, self.detectors),
            *(f"training_study.references: {name!r} is a training set, too" for name in twice),
            *(
                p
                for key, names in curves.items()
                for p in _unknown(f"training_study.{key}", names, dict.fromkeys(trained))
            ),
            *(
                p
                for pair in study.comparisons
                for p in _unknown("training_study.comparisons", pair, compared)
            ),
            *(
                p
                for name in used
                for p in _unknown(f"training_sets.{name}.images", sets[name].images, own)
            ),
            *(p for name in dict.fromkeys([*used, *images]) for p in self._problems_of_set(name)),
        ]

    def _problems_of_set(self, name: str) -> list[str]:
        """What is wrong with a training set, apart from its images."""
        chosen, path = self.training_sets[name], f"training_sets.{name}"
        dataset = [chosen.dataset] if chosen.dataset else []
        camera = [chosen.render["camera"]] if "camera" in chosen.render else []
        problems = [
            *_unknown(f"{path}.dataset", dataset, self.datasets),
            *_unknown(f"{path}.render.camera", camera, self.cameras),
        ]
        for key in SET_SECTIONS:
            try:
                changed(getattr(self, key), getattr(chosen, key))
            except ValidationError as error:
                problems += [f"{path}.{key}: {each['ctx']['error']}" for each in error.errors()]
        positive = chosen.training.get("positive", self.training.positive)
        shown = [name for name in (chosen.images or [name]) if name in self.training_sets]
        simulated = [
            self.training_sets[name].render.get("simulate", self.render.simulate) for name in shown
        ]
        if positive == "simulated" and not chosen.weights and not all(simulated):
            problems.append(
                f"{path}.training.positive: simulated needs images with render.simulate: true"
            )
        return problems

    def _unknown_in_release(self) -> list[str]:
        """Unknown names of the section, if it is given; its defaults may name what is missing."""
        if "release" not in self.model_fields_set:
            return []
        return [
            *_unknown("release.dataset", [self.release.dataset], self.datasets),
            *_unknown("release.gripper", [self.release.gripper], self.grippers),
        ]


def changed(section: P, changes: Mapping[str, Any]) -> P:
    """A section of which some settings are different.

    Raises:
        ValidationError: They do not go together.
    """
    return type(section)(**{**section.model_dump(), **changes})


def _unknown(key: str, used: Iterable[str], table: Mapping[str, object]) -> list[str]:
    return [
        f"{key}: {name!r} is not defined; known: {', '.join(sorted(table))}"
        for name in used
        if name not in table
    ]
