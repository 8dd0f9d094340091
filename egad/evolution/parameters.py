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

    resolution: int = Field(VOXELS, ge=8, le=64)
    """voxels along each side of the cube"""
    threshold: float = 0.5
    """network output above which a voxel is solid"""
    smoothing_iterations: int = Field(_USUAL.iterations, ge=0, le=100)
    """rounds of Humphrey smoothing"""
    smoothing_alpha: Fraction = _USUAL.alpha
    """Humphrey alpha: pull towards the original position"""
    smoothing_beta: Fraction = _USUAL.beta
    """Humphrey beta: smoothing of the pull towards the original position"""
    longest_side: Length = 0.1
    """longest axis-aligned side of the mesh, metres"""


class Region(Parameters):
    """A region of the cube that shapes grow in; the cube has sides of 1, centered at 0."""

    kind: Literal["none", "box", "ellipsoid", "cylinder", "mesh"] = "none"
    """type of the region; a sphere is an ellipsoid with equal sides; none: off"""
    size: tuple[PositiveFraction, PositiveFraction, PositiveFraction] = (1, 1, 1)
    """sides along x, y, z, as fractions of the cube"""
    center: tuple[Offset, Offset, Offset] = (0, 0, 0)
    """center, as fractions of the cube relative to its center"""
    axis: Axis = "z"
    """axis of a cylinder"""
    mesh: UserPath = ""
    """mesh file, scaled uniformly to fit `size`; the region is its interior"""

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

    mirror: tuple[Axis, ...] = ()
    """axes across which the two halves of a shape are mirror images"""
    fold: int = Field(1, ge=1, le=32)
    """order of the rotational symmetry; 1: none"""
    axis: Axis = "z"
    """axis of the rotational symmetry"""


class Limits(Parameters):
    """Proportions of shapes. Shapes outside these limits are rejected before they are measured."""

    aspect_ratio: Range = (1, 64)
    """longest over shortest side of the axis-aligned bounding box, in voxels"""
    box_fraction: FractionRange = (0, 1)
    """volume as a fraction of the axis-aligned bounding box"""
    cube_fraction: FractionRange = (0, 1)
    """volume as a fraction of the cube"""

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        check_ascending(self, "aspect_ratio", "box_fraction", "cube_fraction")
        if self.aspect_ratio[1] < 1:
            raise ValueError("the upper limit of aspect_ratio must be at least 1")
        return self


class Neat(Parameters):
    """Mutation of CPPN genomes (NEAT; the values of the released EGAD code)."""

    activations: list[Activation] = Field(["sin", "sigmoid", "gaussian", "identity"], min_length=1)
    """activation functions of the nodes: sin(x), sigmoid(5x), exp(-5x^2), x"""
    initial_connections: Fraction = 0.1
    """fraction of the inputs that a new genome connects to the output"""
    weight_sigma: Sigma = 1.0
    """standard deviation of a new weight"""
    weight_limit: float = Field(30.0, gt=0)
    """largest magnitude of weights and biases"""
    weight_mutation_rate: Fraction = 0.8
    """probability of shifting a weight"""
    weight_mutation_sigma: Sigma = 2.5
    """standard deviation of that shift"""
    weight_replacement_rate: Fraction = 0.1
    """probability of resampling a weight"""
    bias_sigma: Sigma = 1.0
    """standard deviation of a new bias"""
    bias_mutation_rate: Fraction = 0.7
    """probability of shifting a bias"""
    bias_mutation_sigma: Sigma = 1.0
    """standard deviation of that shift"""
    bias_replacement_rate: Fraction = 0.2
    """probability of resampling a bias"""
    activation_mutation_rate: Fraction = 0.1
    """probability of resampling the activation of a node"""
    connection_addition_rate: Fraction = 0.15
    """probability of adding a connection"""
    connection_deletion_rate: Fraction = 0.15
    """probability of deleting a connection"""
    connection_toggle_rate: Fraction = 0.1
    """probability of resampling whether a connection is enabled"""
    node_addition_rate: Fraction = 0.1
    """probability of splitting a connection with a new node"""
    node_deletion_rate: Fraction = 0.1
    """probability of deleting a node"""


ESTIMATE = frozenset(
    {"estimator", "max_candidates", "grasps"}
)  # decide how graspability is measured


class Evolution(Parameters):
    """MAP-Elites over CPPN genomes; config/paper.yaml has the values of the paper."""

    evaluations: int = Field(2400, ge=1)
    """offspring in all islands and epochs, in whole steps of `population`"""
    population: int = Field(100, ge=1)
    """children that an island evaluates per step"""
    crossover_probability: Fraction = 0.5
    """probability that a child has two parents; otherwise it is a mutated copy of one"""
    parents: Literal["uniform", "sparse"] = "sparse"
    """how parents are sampled: uniformly, or with weights that grow with the number of empty slots
    in their cell and the eight around it"""
    siblings: int = Field(1, ge=1)
    """number of successive children with the same parents"""
    restart: Fraction = 0.0
    """probability that a child is a new random genome"""
    estimator: Literal["sequential", "paper"] = "sequential"
    """how graspability is estimated: sequential: roughly, then until the cell is certain for
    objects that the archive would keep; paper: from grasps that keep a minimum distance, as in the
    paper"""
    max_candidates: int = Field(16384, ge=1)
    """maximum number of candidate grasps per object (estimator: sequential)"""
    grasps: int = Field(100, ge=1)
    """grasps per object (estimator: paper)"""

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
