"""Base classes and bounded number types of all sections: closed, immutable models."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from egad.errors import UserError

Name = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_\-]*$")]
Fraction = Annotated[float, Field(ge=0, le=1)]
PositiveFraction = Annotated[float, Field(gt=0, le=1)]
Length = Annotated[float, Field(gt=0, le=10)]
Sigma = Annotated[float, Field(ge=0)]
Range = tuple[float, float]
FractionRange = tuple[Fraction, Fraction]
Offset = Annotated[float, Field(ge=-0.5, le=0.5)]
Axis = Literal["x", "y", "z"]
Activation = Literal["sin", "sigmoid", "gaussian", "identity"]
ScaleRule = Literal["paper", "egad-script", "exact"]


class Parameters(BaseModel):
    """A group of settings: immutable, without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


P = TypeVar("P", bound=Parameters)


class ParameterGroup(Parameters):
    """The groups of settings that a function or stage reads."""


@dataclass(frozen=True)
class Archived:
    """What an archive of elites depends on in a section: all of it without this mark.

    Attributes:
        keys: Those that count; all if None.
        difficulty: Whether the difficulties depend on the section, too.
    """

    keys: frozenset[str] | None = None
    difficulty: bool = True


# decides which objects are found, not how they are measured
SEARCH_ONLY = Archived(keys=frozenset())


def from_arguments(kind: type[P], **values: Any) -> P:  # noqa: ANN401 (fields of any type)
    """Parameters from the arguments of a public function.

    Raises:
        UserError: A value is not allowed; the text names the argument.
    """
    try:
        return kind(**values)
    except ValidationError as error:
        wrong = error.errors(include_url=False)
        told = (f"{'.'.join(map(str, e['loc']))} is {e['input']!r}: {e['msg']}" for e in wrong)
        raise UserError("; ".join(told)) from error


def check_ascending(section: Parameters, *names: str) -> None:
    """Raise ValueError for a range that does not go from low to high."""
    for name in names:
        low, high = getattr(section, name)
        if not low < high:
            raise ValueError(f"{name} must go from low to high, got {low} to {high}")


Pixels = Annotated[int, Field(ge=16, le=4096)]

Percent = Annotated[float, Field(ge=0, le=100)]
SideFraction = Annotated[float, Field(gt=0, le=3)]

Angle = Annotated[float, Field(ge=0, le=60)]
