"""The experiment on what networks learn from: the same network, taught by different objects."""

from typing import Self

from pydantic import Field, model_validator

from egad.settings.base import FractionRange, Name, PositiveFraction, Section, ascending

WHOLE = (0.0, 1.0)


class TrainingSet(Section):
    """What a network learns from, or weights that somebody else trained."""

    dataset: Name | None = Field(None, description="dataset of the objects that are rendered")
    complexity: FractionRange = Field(
        WHOLE,
        description="which of them, by their rank in complexity: [0, 0.33] is the simplest third",
    )
    part: PositiveFraction = Field(1.0, description="how many of these, drawn by chance")
    hold_out: bool = Field(
        True, description="whether the objects of its evaluation set are left out of the training"
    )
    weights: str | None = Field(
        None, description="file of given weights, in the place of all these: nothing is trained"
    )

    @model_validator(mode="after")
    def _either_objects_or_weights(self) -> Self:
        if (self.dataset is None) == (self.weights is None):
            raise ValueError("a training set needs either `dataset` or `weights`")
        if self.weights and (self.complexity != WHOLE or self.part < 1 or not self.hold_out):
            raise ValueError(
                "a training set with `weights` takes no `complexity`, `part` or `hold_out`"
            )
        ascending(self, "complexity")
        return self


TRAINING_SETS = {
    "evolved": TrainingSet(dataset="egad"),
    "third": TrainingSet(dataset="egad", part=0.333),
    "simple": TrainingSet(dataset="egad", complexity=(0.0, 0.333)),
    "complex": TrainingSet(dataset="egad", complexity=(0.667, 1.0)),
}


class Diversity(Section):
    """What the objects that a network learns from are worth; see docs/diversity.md."""

    sets: list[Name] = Field([], description="training sets of the table below to compare")
    seeds: int = Field(
        2, ge=1, le=100, description="networks trained on each; they differ in chance alone"
    )
    tests: list[Name] = Field(
        [], description="datasets whose evaluation sets the networks are tried on"
    )
    references: list[Name] = Field(
        [], description="grasp detectors of the table above that are shown beside the networks"
    )
