"""Rules by which tables are cleared, and those that published benchmarks use."""

from functools import partial
from typing import Annotated, Literal, Self, get_args

from pydantic import BeforeValidator, Field, model_validator

from egad._util.parameters import Length, Pixels, Range, UserParameters, by_name
from egad.detectors import NOISES, NoiseName
from egad.sim import COLLISION_FORCE, Contact, contacts_in_words

SceneKind = Literal["single", "packed", "pile"]
SCENE_KINDS: tuple[SceneKind, ...] = get_args(SceneKind)
"""How objects lie: each alone, packed upright side by side, or in a pile."""
CUSTOM = "custom"
Extent = Annotated[float, Field(gt=0, le=1)]


class SceneCameras(UserParameters):
    """Depth cameras around the table; values with a range are sampled before every attempt."""

    views: int = Field(6, ge=1, le=64)
    """number of cameras, evenly spaced around the table"""
    distance: Range = (0.6, 0.6)
    """range of the distance of the cameras from the point that they look at, metres"""
    tilt: Range = (30.0, 30.0)
    """range of the angle between line of sight and vertical, degrees"""
    azimuth: Range = (0.0, 0.0)
    """range of the direction in which the first camera stands, counterclockwise from the x axis,
    degrees"""
    aim: float = Field(-0.05, ge=-1, le=1)
    """height of the point that the cameras look at, above the middle of the table, metres"""
    image: tuple[Pixels, Pixels] = (320, 240)
    """width and height of the images, pixels"""
    focal: float = Field(207.89351730849154, gt=0)  # 1.047 rad from top to bottom
    """focal length, pixels: half the image height / the tangent of half the vertical field of
    view"""

    @model_validator(mode="after")
    def _ranges_can_be_drawn_from(self) -> Self:
        for name in ("distance", "tilt", "azimuth"):
            low, high = getattr(self, name)
            least = {"distance": 0.1, "tilt": 0}.get(name, low)
            if not least <= low <= high:
                raise ValueError(f"{name} must go from low to high, got {low} to {high}")
        if self.tilt[1] >= 90:
            raise ValueError(f"tilt must be less than 90 degrees, got {self.tilt[1]}")
        return self


class ClutterProtocol(UserParameters):
    """Rules by which a table is cleared: egad, vgn, giga, edgegrasp, or a section of your own.

    Keys that a section omits are as in `egad`. studies/benchmark/protocols.md has the sources.
    """

    cameras: SceneCameras = SceneCameras()
    noise: tuple[NoiseName, ...] = Field(NOISES[:2], min_length=1)
    """kinds of noise, unless `clutter.noise` is set"""
    scale: Range = (0.8, 1.0)
    """range of object sizes, relative to those in the bundle"""
    packed_scale: Range | None = None
    """range of object sizes in packed scenes; nothing: as `scale`"""
    repetition: bool = False
    """whether an object may occur in a scene more than once"""
    packing_area: Extent = 0.2
    """side of the square that contains the origins of packed objects, metres"""
    packing_tries: int = Field(50, ge=1)
    """maximum number of positions to try in packed scenes; objects that find no space are left
    out"""
    packing_tries_of: Literal["object", "scene"] = "object"
    """whether `packing_tries` is the limit for each object, or for all objects of a scene
    together"""
    drop_height: Length = 0.02
    """height from which objects are dropped, metres; see `drop_above`"""
    drop_above: Literal["objects", "table"] = "objects"
    """how `drop_height` is measured: objects: from the objects already there to the lowest point of
    the object; table: from the table to its center of mass"""
    opening: Literal["predicted", "full"] = "predicted"
    """how far the hand opens: as the detector predicts, or fully"""
    contact: Contact = Field(
        "close",
        description="what a contact during the approach means: "
        f"{contacts_in_words('close', 'collided', 'ignore')}. A contact before the approach is "
        "always a failure",
    )
    stopping_force: float = Field(COLLISION_FORCE, ge=0, le=1000)
    """force above which a contact counts, newtons"""
    force: float | None = Field(None, gt=0, le=1000)
    """closing force, newtons; nothing: that of the gripper"""
    friction: float | None = Field(None, gt=0, le=2)
    """friction of the pads; nothing: that of the gripper"""
    success: Literal["pinched", "touched"] = "pinched"
    """when an attempt succeeds: touched: after the retreat, the hand touches an object and is open
    by more than a tenth; pinched: in addition, both fingers pressed on an object after they
    closed"""
    removed: Literal["pressed", "first"] = "pressed"
    """which object is removed after a success: pressed: the one that the hand presses on most;
    first: the first in the list of those that it touches"""
    choice: Literal["highest", "random"] = "highest"
    """which grasp is tried: the one with the highest score, or a random one of those that pass
    `threshold`"""
    threshold: float | None = Field(None, ge=0, le=1)
    """minimum score of a grasp to be tried, on whatever scale the detector uses; nothing: no
    minimum"""
    failures: int = Field(2, ge=1)
    """number of failures in a row that end a round"""
    skips: int = Field(1, ge=1)
    """a round ends when the detector has proposed no grasp this many times; before that, new images
    are taken"""

    @property
    def name(self) -> str:
        """The name of these rules in tables, or `custom`."""
        names = [name for name, each in NAMED_PROTOCOLS.items() if each == self]
        return names[0] if names else CUSTOM

    def __str__(self) -> str:
        """The name of these rules, or their values."""
        return super().__str__() if self.name == CUSTOM else self.name

    @model_validator(mode="after")
    def _scales_can_be_drawn_from(self) -> Self:
        for low, high in (self.scale, self.packed_scale or self.scale):
            if not 0 < low <= high:
                raise ValueError(f"scale must go from a positive low to high, got {low} to {high}")
        return self


_VGN = ClutterProtocol(
    cameras=SceneCameras(image=(640, 480), focal=540.0),
    noise=("none",),
    packed_scale=(0.7, 0.9),
    repetition=True,
    packing_area=0.14,
    packing_tries=12,
    packing_tries_of="scene",
    drop_height=0.2,
    drop_above="table",
    opening="full",
    stopping_force=0.0,
    force=20.0,
    friction=1.0,
    success="touched",
    removed="first",
    choice="random",
    threshold=0.9,
)
NAMED_PROTOCOLS: dict[str, ClutterProtocol] = {
    "egad": ClutterProtocol(),
    "vgn": _VGN,
    "giga": _VGN.model_copy(
        update={
            "cameras": SceneCameras(
                views=1,
                tilt=(60.0, 60.0),
                azimuth=(-90.0, -90.0),
                aim=0.05,
                image=(640, 480),
                focal=540.0,
            ),
            "noise": ("dex",),
            "choice": "highest",
            "threshold": 0.5,
        }
    ),
    "edgegrasp": _VGN.model_copy(
        update={
            "cameras": SceneCameras(
                views=1,
                distance=(0.6, 0.75),
                tilt=(45.0, 60.0),
                azimuth=(0.0, 180.0),
                aim=0.2,
                image=(640, 480),
                focal=540.0,
            ),
            "noise": ("points",),
            "packed_scale": (0.7, 0.8),
            "contact": "ignore",
            "friction": 0.75,
            "choice": "highest",
            "threshold": None,
            "skips": 3,
        }
    ),
}


Protocol = Annotated[
    ClutterProtocol, BeforeValidator(partial(by_name, "protocol", NAMED_PROTOCOLS))
]
