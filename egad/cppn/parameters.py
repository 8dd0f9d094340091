"""Which shapes may grow, and how they become meshes."""

from typing import Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    Activation,
    Axis,
    Fraction,
    FractionRange,
    Length,
    Offset,
    Parameters,
    PositiveFraction,
    Range,
    Sigma,
    check_ascending,
)


class Shape(Parameters):
    """From a genome to a mesh."""

    resolution: int = Field(25, ge=8, le=64, description="voxels along each side of the cube")
    threshold: float = Field(0.5, description="network output above which a voxel is solid")
    smoothing_iterations: int = Field(10, ge=0, le=100, description="rounds of Humphrey smoothing")
    smoothing_alpha: Fraction = Field(0.1, description="Humphrey alpha: pull to the original place")
    smoothing_beta: Fraction = Field(0.25, description="Humphrey beta: smoothing of that pull")
    longest_side: Length = Field(0.1, description="longest axis-aligned side of the mesh, metres")


class Region(Parameters):
    """A part of the cube that shapes grow in; the cube has sides of 1 and its middle at 0."""

    kind: Literal["none", "box", "ellipsoid", "cylinder", "mesh"] = Field(
        "none", description="its form; a sphere is an ellipsoid with equal sides, none: off"
    )
    size: tuple[PositiveFraction, PositiveFraction, PositiveFraction] = Field(
        (1, 1, 1), description="its sides along x, y, z, as parts of the cube"
    )
    center: tuple[Offset, Offset, Offset] = Field(
        (0, 0, 0), description="its middle, as parts of the cube from the middle of that"
    )
    axis: Axis = Field("z", description="axis of a cylinder")
    mesh: str = Field(
        "", description="file of a mesh, scaled evenly to fit `size`; its inside counts"
    )

    @model_validator(mode="after")
    def _a_mesh_has_a_file(self) -> Self:
        if (self.kind == "mesh") != bool(self.mesh):
            raise ValueError(
                f"kind is {self.kind} and mesh is {self.mesh!r}; `kind: mesh` and a file belong "
                "together"
            )
        return self


class Envelope(Region):
    """What shapes must stay in, but for their part."""


class KeepSolid(Region):
    """What every shape must contain, but for the hole. It may stick out of the envelope."""


class Hole(Region):
    """What must stay empty."""


class Symmetry(Parameters):
    """Symmetry that shapes must have. Mirrors hold for envelope, part and hole too."""

    mirror: tuple[Axis, ...] = Field(
        (), description="axes across which the two halves of a shape are mirror images"
    )
    fold: int = Field(1, ge=1, le=32, description="how often a shape repeats itself in a full turn")
    axis: Axis = Field("z", description="axis of that turn")


class Limits(Parameters):
    """Shapes outside are rejected before they are measured."""

    aspect_ratio: Range = Field(
        (1, 64), description="longest by shortest side of the axis-aligned box, in voxels"
    )
    box_fraction: FractionRange = Field((0, 1), description="volume as part of that box")
    cube_fraction: FractionRange = Field((0, 1), description="volume as part of the cube")

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Self:
        check_ascending(self, "aspect_ratio", "box_fraction", "cube_fraction")
        if self.aspect_ratio[1] < 1:
            raise ValueError("aspect_ratio must reach 1 at least: no box is shorter than itself")
        return self


class Neat(Parameters):
    """Mutation of CPPN genomes (NEAT; the values of the released EGAD code)."""

    activations: list[Activation] = Field(
        ["sin", "sigmoid", "gaussian", "identity"],
        min_length=1,
        description="activation functions a node can have: sin(x), sigmoid(5x), exp(-5x^2), x",
    )
    initial_connections: Fraction = Field(
        0.1, description="part of the inputs that a new genome connects to the output"
    )
    weight_sigma: Sigma = Field(1.0, description="standard deviation of a new weight")
    weight_limit: float = Field(30.0, gt=0, description="weights and biases stay within +- this")
    weight_mutation_rate: Fraction = Field(0.8, description="chance to shift a weight")
    weight_mutation_sigma: Sigma = Field(2.5, description="standard deviation of that shift")
    weight_replacement_rate: Fraction = Field(0.1, description="chance to draw a weight anew")
    bias_sigma: Sigma = Field(1.0, description="standard deviation of a new bias")
    bias_mutation_rate: Fraction = Field(0.7, description="chance to shift a bias")
    bias_mutation_sigma: Sigma = Field(1.0, description="standard deviation of that shift")
    bias_replacement_rate: Fraction = Field(0.2, description="chance to draw a bias anew")
    activation_mutation_rate: Fraction = Field(
        0.1, description="chance that a node draws its activation anew"
    )
    connection_addition_rate: Fraction = Field(0.15, description="chance to add a connection")
    connection_deletion_rate: Fraction = Field(0.15, description="chance to delete a connection")
    connection_toggle_rate: Fraction = Field(
        0.1, description="chance that a connection draws anew whether it is enabled"
    )
    node_addition_rate: Fraction = Field(0.1, description="chance to split a connection by a node")
    node_deletion_rate: Fraction = Field(0.1, description="chance to delete a node")
