"""Settings of evolution: constraints on shapes, their mutation and meshes; the search."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    SEARCH_ONLY,
    Archived,
    Axis,
    Fraction,
    FractionRange,
    Length,
    Offset,
    Parameters,
    PositiveFraction,
    Range,
    Sigma,
    UserPath,
    check_ascending,
)
from egad.geometry import VOXELS, Smoothing
from egad.measures import MeasureMeshes, MeasureParameters

Activation = Literal["sin", "sigmoid", "gaussian", "identity"]  # `query.activate`
_USUAL = Smoothing()
COARSEST, FINEST = 8, 200  # resolutions that a genome can be grown at


class Shape(Parameters):
    """Conversion of a genome to a mesh."""

    resolution: int = Field(VOXELS, ge=8, le=64, description="voxels along each side of the cube")
    threshold: float = Field(0.5, description="network output above which a voxel is solid")
    smoothing_iterations: int = Field(
        _USUAL.iterations, ge=0, le=100, description="rounds of Humphrey smoothing"
    )
    smoothing_alpha: Fraction = Field(
        _USUAL.alpha, description="Humphrey alpha: pull towards the original position"
    )
    smoothing_beta: Fraction = Field(
        _USUAL.beta,
        description="Humphrey beta: smoothing of the pull towards the original position",
    )
    longest_side: Length = Field(0.1, description="longest axis-aligned side of the mesh, metres")


class Region(Parameters):
    """A region of the cube that shapes grow in; the cube has sides of 1, centered at 0."""

    kind: Literal["none", "box", "ellipsoid", "cylinder", "mesh"] = Field(
        "none",
        description="type of the region; a sphere is an ellipsoid with equal sides; none: off",
    )
    size: tuple[PositiveFraction, PositiveFraction, PositiveFraction] = Field(
        (1, 1, 1), description="sides along x, y, z, as fractions of the cube"
    )
    center: tuple[Offset, Offset, Offset] = Field(
        (0, 0, 0), description="center, as fractions of the cube relative to its center"
    )
    axis: Axis = Field("z", description="axis of a cylinder")
    mesh: UserPath = Field(
        "", description="mesh file, scaled uniformly to fit `size`; the region is its interior"
    )

    @model_validator(mode="after")
    def _a_mesh_has_a_file(self) -> Self:
        if (self.kind == "mesh") != bool(self.mesh):
            raise ValueError(
                f"kind is {self.kind} and mesh is {self.mesh!r}; `kind: mesh` needs a mesh file, "
                "and other kinds take none"
            )
        return self


class Envelope(Region):
    """Region that shapes must stay inside, except for the kept solid."""


class KeepSolid(Region):
    """Region that every shape must contain, except for the hole. It may exceed the envelope."""


class Hole(Region):
    """Region that must stay empty."""


class Symmetry(Parameters):
    """How shapes repeat. Mirrors also apply to the envelope, the kept solid and the hole."""

    mirror: tuple[Axis, ...] = Field(
        (), description="axes across which the two halves of a shape are mirror images"
    )
    fold: int = Field(1, ge=1, le=32, description="order of the rotational symmetry; 1: none")
    axis: Axis = Field("z", description="axis of the rotational symmetry")


class Limits(Parameters):
    """Proportions of shapes. Shapes outside these limits are rejected before they are measured."""

    aspect_ratio: Range = Field(
        (1, 64),
        description="longest over shortest side of the axis-aligned bounding box, in voxels",
    )
    box_fraction: FractionRange = Field(
        (0, 1), description="volume as a fraction of the axis-aligned bounding box"
    )
    cube_fraction: FractionRange = Field((0, 1), description="volume as a fraction of the cube")

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        check_ascending(self, "aspect_ratio", "box_fraction", "cube_fraction")
        if self.aspect_ratio[1] < 1:
            raise ValueError("the upper limit of aspect_ratio must be at least 1")
        return self


class Neat(Parameters):
    """Mutation of CPPN genomes (NEAT; the values of the released EGAD code)."""

    activations: list[Activation] = Field(
        ["sin", "sigmoid", "gaussian", "identity"],
        min_length=1,
        description="activation functions of the nodes: sin(x), sigmoid(5x), exp(-5x^2), x",
    )
    initial_connections: Fraction = Field(
        0.1, description="fraction of the inputs that a new genome connects to the output"
    )
    weight_sigma: Sigma = Field(1.0, description="standard deviation of a new weight")
    weight_limit: float = Field(30.0, gt=0, description="largest magnitude of weights and biases")
    weight_mutation_rate: Fraction = Field(0.8, description="probability of shifting a weight")
    weight_mutation_sigma: Sigma = Field(2.5, description="standard deviation of that shift")
    weight_replacement_rate: Fraction = Field(0.1, description="probability of resampling a weight")
    bias_sigma: Sigma = Field(1.0, description="standard deviation of a new bias")
    bias_mutation_rate: Fraction = Field(0.7, description="probability of shifting a bias")
    bias_mutation_sigma: Sigma = Field(1.0, description="standard deviation of that shift")
    bias_replacement_rate: Fraction = Field(0.2, description="probability of resampling a bias")
    activation_mutation_rate: Fraction = Field(
        0.1, description="probability of resampling the activation of a node"
    )
    connection_addition_rate: Fraction = Field(
        0.15, description="probability of adding a connection"
    )
    connection_deletion_rate: Fraction = Field(
        0.15, description="probability of deleting a connection"
    )
    connection_toggle_rate: Fraction = Field(
        0.1, description="probability of resampling whether a connection is enabled"
    )
    node_addition_rate: Fraction = Field(
        0.1, description="probability of splitting a connection with a new node"
    )
    node_deletion_rate: Fraction = Field(0.1, description="probability of deleting a node")


ESTIMATE = frozenset(
    {"estimator", "max_candidates", "grasps"}
)  # decide how graspability is measured


class Evolution(Parameters):
    """MAP-Elites over CPPN genomes; config/paper.yaml has the values of the paper."""

    evaluations: int = Field(
        2400,
        ge=1,
        description="offspring in all islands and epochs, in whole steps of `population`",
    )
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

    @property
    def steps(self) -> int:
        """Steps that have this many evaluations."""
        return -(-self.evaluations // self.population)


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


class PostprocessSolids(MeasureMeshes):
    """Repair, mass properties and measures of the objects of a shard."""

    shape: Shape
