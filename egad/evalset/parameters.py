"""What is made of the objects: repair, scaling, the evaluation set, prints."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import Length, Name, Parameters, PositiveFraction


class SelectEval(Parameters):
    """The evaluation set: one object a cell of a coarse grid, chosen to look least alike."""

    rows: int = Field(7, ge=1, le=26, description="rows = letters = difficulty")
    columns: int = Field(7, ge=1, le=10, description="columns = digits = complexity")
    restarts: int = Field(20, ge=1, description="random starts of the local search")
    borrow: float = Field(
        0.1,
        ge=0,
        description="a cell without an object takes the nearest one that lies at most so many "
        "cells away",
    )
    gripper: Name | None = Field(
        None,
        description="gripper of the table that all chosen objects must be printable for; nothing: "
        "the narrowest, since scaling makes walls thinner",
    )


class PrintCheck(Parameters):
    """What a printer can make."""

    wall: Length = Field(0.0012, description="thinnest wall, metres: some nozzle widths")
    blunting: float = Field(
        0.0015,
        ge=0,
        description="edges and tips may become blunter by this much, metres",
    )


class PrintExport(Parameters):
    """Files for 3D printers."""

    bed: tuple[Length, Length] = Field(
        (0.22, 0.22), description="print bed, metres; another common one: [0.256, 0.256]"
    )
    gap: float = Field(0.005, ge=0, description="free space between objects on a plate, metres")
    pose: Literal["stable", "overhang"] = Field(
        "overhang",
        description="stable: the face of its hull that an object most probably comes to rest on; "
        "overhang: of all but the improbable ones, the one with the least surface to support",
    )
    overhang_angle: float = Field(
        40.0,
        gt=0,
        lt=90,
        description="surface that leans out further from the vertical is supported, degrees",
    )
    infill: PositiveFraction = Field(0.2, description="part of the inside that is filled")
    shell: Length = Field(0.0009, description="solid layer below the surface, metres")
    filament_density: float = Field(1240.0, gt=0, description="of solid filament, kg/m3: PLA 1240")


class Engraving(Parameters):
    """The label of an object, cut into its print."""

    enabled: bool = Field(False, description="whether prints carry their labels")
    depth: Length = Field(0.0006, description="below the surface, metres")
    letters: Length = Field(0.006, description="height of the letters, metres")
    relief: Length = Field(
        0.001,
        description="highest less lowest point below the label, metres; objects without a place "
        "that even stay as they are",
    )


class Bundle(Parameters):
    """Files for simulators: convex parts, URDF and MJCF."""

    method: Literal["cut", "coacd"] = Field(
        "cut",
        description="how the convex parts are made: cut by planes, or by CoACD, which is installed "
        "with `pip install 'egad[coacd]'`",
    )
    max_parts: int = Field(256, ge=1, description="most convex parts of an object")
    volume_error: float = Field(
        0.06,
        gt=0,
        lt=1,
        description="bound of the parts' excess volume; objects beyond are marked",
    )
    coacd_threshold: float = Field(
        0.05, ge=0.01, le=1, description="concavity of a part (method: coacd)"
    )
    friction: float = Field(0.5, gt=0, le=2, description="sliding friction of the objects")
