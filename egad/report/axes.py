"""Names of the axes of the space in figures, pages and tables."""

from dataclasses import dataclass
from typing import NamedTuple

from egad.measures import CustomMeasures, plugin_name

ARROW = "\N{RIGHTWARDS ARROW}"
MILLI = "\N{MULTIPLICATION SIGN}10\N{SUPERSCRIPT MINUS}\N{SUPERSCRIPT THREE}"
COMPARATIVES = {"simple": "simpler", "easy": "easier", "low": "lower", "high": "higher"}


@dataclass(frozen=True)
class MeasureAxis:
    """An axis of the space in words."""

    name: str
    short: str  # short name, for where space is limited
    start: str  # what objects of the first cell are
    end: str  # what objects of the last cell are
    value: str  # name of its number
    unit: str = ""  # unit of the number as it is shown, with a space before it, or empty
    factor: int = 1  # the number is multiplied by this before it is shown

    @property
    def label(self) -> str:
        """The text along an axis."""
        return f"{self.short}: {self.start} {ARROW} {self.end}"

    @property
    def long_label(self) -> str:
        """The same in full."""
        return f"{self.name}: {self.start} {ARROW} {self.end}"

    def along(self, first: float, last: float) -> str:
        """The full text along an axis, with the values at its ends."""
        ends = f"{self.factor * first:g} to {self.factor * last:g}{self.unit}"
        value = f"{self.value} " if self.value not in self.name else ""
        return f"{self.long_label} ({value}{ends})"

    @property
    def printed_unit(self) -> str:
        """The unit as shown on pages, without a space before it."""
        return self.unit.strip().replace("1e-3", MILLI)

    @property
    def before(self) -> str:
        """The comparative for an object that lies closer to the start, such as `simpler`."""
        return COMPARATIVES[self.start]


class AxisPair(NamedTuple):
    """The axes of a map."""

    across: MeasureAxis
    upwards: MeasureAxis


COMPLEXITY = MeasureAxis(
    "shape complexity", "complexity", "simple", "complex", "complexity", " bit"
)
DIFFICULTY = MeasureAxis(
    "grasp difficulty", "difficulty", "easy", "hard", "graspability", " 1e-3", 1000
)
USUAL = AxisPair(COMPLEXITY, DIFFICULTY)


def axis_pair(axes: CustomMeasures) -> AxisPair:
    """The axes that a configuration asks for; high graspability comes first."""
    return named_axes(plugin_name(axes.complexity), plugin_name(axes.graspability))


def named_axes(across: str | None, upwards: str | None) -> AxisPair:
    """Axes of measures of these names (default: complexity, difficulty); high values come first."""
    return AxisPair(
        MeasureAxis(across, across, "low", "high", across) if across else COMPLEXITY,
        MeasureAxis(upwards, upwards, "high", "low", upwards) if upwards else DIFFICULTY,
    )
