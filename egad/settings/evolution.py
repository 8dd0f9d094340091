"""How objects are evolved."""

from typing import Literal

from pydantic import Field

from egad.settings.base import Activation, Fraction, Section, Sigma


class Schedule(Section):
    """How evolution is cut into jobs. More epochs than before extend a finished run."""

    islands: int = Field(
        1, ge=1, le=1024, description="archives that evolve apart within an epoch, then merge"
    )
    epochs: int = Field(1, ge=1, le=200, description="rounds of evolving apart and merging")


class Evolution(Section):
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
    regrade: int = Field(
        0,
        ge=0,
        description="grasps that a newcomer to a full cell is graded again by, against lucky "
        "elites; 0: not",
    )


class Neat(Section):
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
