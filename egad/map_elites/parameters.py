"""Settings of evolution."""

from typing import Annotated, Literal

from pydantic import Field

from egad._util.parameters import SEARCH_ONLY, Archived, Fraction, Parameters
from egad.cppn import Envelope, Hole, KeepSolid, Limits, Neat, Shape, Symmetry
from egad.measures import MeasureParameters

ESTIMATE = frozenset(
    {"estimator", "max_candidates", "grasps"}
)  # decide how graspability is measured


class Evolution(Parameters):
    """MAP-Elites over CPPN genomes; config/paper.yaml has the values of the paper."""

    steps_per_epoch: int = Field(24, ge=1, description="steps of an island per epoch")
    population: int = Field(100, ge=1, description="children that an island evaluates per step")
    crossover_probability: Fraction = Field(
        0.5,
        description="probability that a child has two parents; otherwise it is a mutated copy of "
        "one",
    )
    parents: Literal["uniform", "sparse"] = Field(
        "sparse",
        description="how parents are sampled: uniformly, or with weights that grow with the "
        "number of empty slots in their cell and the eight around it",
    )
    siblings: int = Field(
        1, ge=1, description="number of successive children with the same parents"
    )
    restart: Fraction = Field(0.0, description="probability that a child is a new random genome")
    estimator: Literal["sequential", "paper"] = Field(
        "sequential",
        description="how graspability is estimated: sequential: roughly, then until the cell is "
        "certain for objects that the archive would keep; paper: from grasps that keep a minimum "
        "distance, as in the paper",
    )
    max_candidates: int = Field(
        16384,
        ge=1,
        description="maximum number of candidate grasps per object (estimator: sequential)",
    )
    grasps: int = Field(100, ge=1, description="grasps per object (estimator: paper)")


class EvolutionParameters(MeasureParameters):
    """The settings that one epoch of an island depends on."""

    evolution: Annotated[Evolution, Archived(keys=ESTIMATE)]
    neat: Annotated[Neat, SEARCH_ONLY]
    shape: Shape
    envelope: Annotated[Envelope, SEARCH_ONLY]
    keep_solid: Annotated[KeepSolid, SEARCH_ONLY]
    hole: Annotated[Hole, SEARCH_ONLY]
    symmetry: Annotated[Symmetry, SEARCH_ONLY]
    limits: Annotated[Limits, SEARCH_ONLY]
