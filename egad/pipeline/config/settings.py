"""The whole configuration."""

from collections.abc import Mapping
from typing import Self

from pydantic import Field, model_validator

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
            *_unknown("training_study.sets", self.training_study.sets, self.training_sets),
            *_unknown("training_study.tests", self.training_study.tests, self.datasets),
            *_unknown("training_study.references", self.training_study.references, self.detectors),
            *self._unknown_datasets_of_sets(),
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

    def _unknown_datasets_of_sets(self) -> list[str]:
        """Unknown datasets of the sets in use; unused default sets may name a missing dataset."""
        used = [name for name in self.training_study.sets if name in self.training_sets]
        return [
            problem
            for name in used
            if (dataset := self.training_sets[name].dataset)
            for problem in _unknown(f"training_sets.{name}.dataset", [dataset], self.datasets)
        ]

    def _unknown_in_release(self) -> list[str]:
        """Unknown names of the section, if it is given; its defaults may name what is missing."""
        if "release" not in self.model_fields_set:
            return []
        return [
            *_unknown("release.dataset", [self.release.dataset], self.datasets),
            *_unknown("release.gripper", [self.release.gripper], self.grippers),
        ]


def _unknown(key: str, used: list[str], table: Mapping[str, Parameters]) -> list[str]:
    return [
        f"{key}: {name!r} is not defined; known: {', '.join(sorted(table))}"
        for name in used
        if name not in table
    ]
