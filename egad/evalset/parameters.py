"""Settings of the evaluation set, its prints and its files for simulators."""

from typing import Annotated, Literal

from pydantic import Field

from egad._util.parameters import Length, Name, ParameterGroup, Parameters, PositiveFraction
from egad.geometry import Rescale
from egad.grippers import Gripper
from egad.measures import MeasureSpace
from egad.measures.reeb import Similarity

Side = Annotated[float, Field(ge=0, le=10)]  # metres


class SelectEval(Parameters):
    """The evaluation set: one object per cell of a coarse grid, chosen for dissimilar shapes."""

    rows: int = Field(7, ge=1, le=26)
    """rows of the grid: difficulty, named by letters"""
    columns: int = Field(7, ge=1, le=10)
    """columns of the grid: complexity, named by digits"""
    borrow: float = Field(0.1, ge=0)
    """an empty cell takes the nearest object if it is at most this far away, in cells"""
    gripper: Name | None = None
    """all chosen objects must be printable when scaled to this gripper, from the table `grippers`;
    nothing: the narrowest gripper, or for meshes of your own the narrowest of `targets.grippers`"""


class PrintCheck(Parameters):
    """Limits of the printer."""

    wall: Length = 0.0012
    """thinnest wall, metres: a few nozzle widths"""
    blunting: float = Field(0.0015, ge=0)
    """how much printing may round off edges and tips, metres"""


class PrintExport(Parameters):
    """Files for 3D printers."""

    bed: tuple[Length, Length] = (0.22, 0.22)
    """print bed, metres; another common one: [0.256, 0.256]"""
    keep_out: tuple[Side, Side] = (0.0, 0.0)
    """width and depth of the front left corner of the bed where nothing may be printed, metres;
    Bambu Lab X1 and P1: [0.018, 0.028]"""
    gap: float = Field(0.005, ge=0)
    """gap between objects on a plate, metres"""
    engraving: bool = False
    """whether labels are engraved into the prints"""
    pose: Literal["stable", "overhang"] = "overhang"
    """stable: the most probable pose at rest; overhang: the pose at rest with the least surface to
    support, improbable poses excluded"""
    perimeters: int = Field(2, ge=1, le=20)
    """lines along each outline of a layer"""
    line_width: float = Field(0.00045, ge=0.0001, le=0.002)
    """width of the lines of perimeters and infill, metres"""
    solid_layers: int = Field(3, ge=0, le=50)
    """solid layers below each top surface and above each bottom surface"""
    infill: PositiveFraction = 0.2
    """fraction of the inside that is filled"""
    filament_density: float = Field(1240.0, gt=0)
    """density of solid filament, kg/m3: PLA 1240"""


class EvalSelection(ParameterGroup):
    """The evaluation set."""

    seed: int
    space: MeasureSpace
    similarity: Similarity
    select_eval: SelectEval
    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck


class PrintFiles(ParameterGroup):
    """Files for printers."""

    gripper: Gripper
    rescale: Rescale
    print_check: PrintCheck
    print_export: PrintExport


class DataSheets(ParameterGroup):
    """The datasheet of an evaluation set."""

    select_eval: SelectEval
    print_export: PrintExport
