"""Parameters of solids: their material, repair of open surfaces, scaling to a gripper."""

from typing import Literal, NamedTuple

from pydantic import Field

from egad._util.parameters import Parameters, PositiveFraction, ScaleRule
from egad.friction import OBJECT

OpenSurfaces = Literal["reject", "thicken"]
SIDE_FRACTION = 0.8  # of a gripper's opening: the smallest side that scale rules aim at
MAX_PARTS = 512  # convex parts of an object
VOLUME_ERROR = 0.06  # relative excess volume of the convex parts
DEVIATION = 0.0005  # metres: how deep the touchable surface may lie in a convex part
MAX_VERTICES = 64  # of a convex part: PhysX takes no more on a GPU
VOXELS = 25  # along the longest side of an object of the dataset
SHELL_THICKNESS = 0.002  # metres: glasses, cups and bowls are 1 to 5 mm thick


class Smoothing(NamedTuple):
    """Humphrey smoothing: rounds, pull to the original position, and smoothing of that pull."""

    iterations: int = 10
    alpha: float = 0.1
    beta: float = 0.25


class Material(Parameters):
    """What objects are made of, which gives their mass."""

    density: float = Field(400.0, gt=0)
    """density, kg/m3; printed PLA at 20 % infill: 350-450"""


class Rescale(Parameters):
    """Scaling of objects to a gripper."""

    rule: ScaleRule = "paper"
    """paper: smallest side at most `side_fraction` of the opening; egad-script: longest side =
    opening, then as paper; exact: smallest side = `side_fraction` of the opening; none: objects
    keep their size"""
    side_fraction: PositiveFraction = SIDE_FRACTION
    """fraction of the opening that the rule uses"""


class Bundle(Parameters):
    """Files for simulators: convex parts, URDF and MJCF."""

    method: Literal["cut", "coacd"] = "cut"
    """how the convex parts are made: cut: by cutting along planes; coacd: by CoACD, which needs
    `pip install 'egad[coacd]'`"""
    max_parts: int = Field(MAX_PARTS, ge=1)
    """maximum number of convex parts of an object"""
    volume_error: float = Field(VOLUME_ERROR, gt=0, lt=1)
    """largest relative excess volume of the parts; objects that exceed it are flagged"""
    deviation: float = Field(DEVIATION, gt=0)
    """99 % of the surface that fingers can touch lies at most this deep in a part, metres (method:
    cut); objects that exceed it are flagged"""
    max_vertices: int = Field(MAX_VERTICES, ge=8)
    """maximum number of vertices of a part"""
    friction: float = Field(OBJECT.friction, gt=0, le=2)
    """sliding friction of the objects"""
