"""How objects are evolved."""

from typing import Annotated, Literal

from pydantic import Field

from egad._util.parameters import SEARCH_ONLY, Archived, Fraction, Parameters
from egad.cppn.parameters import Envelope, Hole, KeepSolid, Limits, Neat, Shape, Symmetry
from egad.measures.parameters import MeasureParameters, Space


class Evolution(Parameters):
    """Breeding: MAP-Elites over CPPN genomes; config/paper.yaml has the paper's values."""

    steps_per_epoch: int = Field(24, ge=1, description="steps of an island in one epoch")
    population: int = Field(100, ge=1, description="children an island evaluates in one step")
    crossover_probability: Fraction = Field(
        0.5, description="chance that a child has two parents; else it is a mutated copy of one"
    )
    parents: Literal["uniform", "sparse"] = Field(
        "sparse",
        description="how parents are drawn: all alike, or the more often the more places are empty "
        "in their cell and the eight around it",
    )
    siblings: int = Field(1, ge=1, description="children of the same parents, one after another")
    restart: Fraction = Field(0.0, description="chance that a child is a random genome instead")
    reevaluation_grasps: int = Field(
        0,
        ge=0,
        description="grasps that a newcomer to a full cell is graded again by, against lucky "
        "elites; 0: not",
    )


class EvolutionParameters(MeasureParameters):
    """What one epoch of an island depends on."""

    evolution: Annotated[Evolution, Archived(keys=frozenset({"reevaluation_grasps"}))]
    neat: Annotated[Neat, SEARCH_ONLY]
    shape: Shape
    envelope: Annotated[Envelope, SEARCH_ONLY]
    keep_solid: Annotated[KeepSolid, SEARCH_ONLY]
    hole: Annotated[Hole, SEARCH_ONLY]
    symmetry: Annotated[Symmetry, SEARCH_ONLY]
    limits: Annotated[Limits, SEARCH_ONLY]
    space: Space
