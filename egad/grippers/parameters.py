"""Settings of a gripper: two jaws, or a suction cup."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from egad._util.display import facts_html
from egad._util.parameters import Length, Place, UserParameters, UserPath
from egad.friction import CUP_RING, PADS, Surface
from egad.grippers.kinds import CupKind, JawKind, Kind


class SuctionCup(UserParameters):
    """One suction cup on a straight stem: the model of Dex-Net 3.0.

    The cup is a pyramid of springs: a ring of `sides` vertices, and an apex on the approach axis.

    Source: Mahler et al., Dex-Net 3.0, ICRA 2018, arXiv 1709.06670: strain, vacuum force, friction
    and bending. GraspGen (NVlabs, `single_suction_cup_30mm.yaml`) has the same four values and
    gives radius, height and sides, which the paper does not. The stem is the collision cylinder of
    SuctionNet-1Billion. The tolerance is the residual that GraspGen's solver accepts.
    """

    radius: Length = 0.015
    """radius of the ring, metres; a 30 mm cup"""
    height: Length = 0.03
    """distance from the ring to the apex, metres; twice the radius if not given"""
    sides: int = Field(15, ge=5, le=360)
    """vertices of the ring"""
    max_strain: float = Field(0.1, gt=0, lt=1)
    """relative change of length that each spring allows"""
    vacuum_force: float = Field(250.0, gt=0)
    """force that presses cup and object together, newtons"""
    friction: float = Field(CUP_RING.friction, gt=0, le=2)
    """friction of the ring on the object"""
    bending: float = Field(0.005, gt=0)
    """kappa, newtons: the cup resists pi radius kappa / sqrt(2) of bending torque"""
    torque_tolerance: float = Field(0.0316, ge=0)
    """bending torque beyond the limit given by `bending` that still counts as resisted, newton
    metres"""
    stem_radius: Length = 0.01
    """radius of the stem, metres"""
    stem_length: Length = 0.09
    """length of the stem, starting at the apex, metres"""
    approach: Length = 0.1
    """length of the straight approach to the object, metres"""

    @model_validator(mode="before")
    @classmethod
    def _height_follows(cls, values: Any) -> Any:  # noqa: ANN401 (whatever was given)
        if not isinstance(values, dict) or values.get("height") is not None:
            return values
        radius = values.get("radius")
        if isinstance(radius, int | float) and radius > 0:
            return {**values, "height": 2 * radius}
        return values

    def _repr_html_(self) -> str:
        """All fields, for notebooks."""
        return facts_html("SuctionCup (metres, newtons)", dict(self))


if TYPE_CHECKING:  # what may be given; it is kept as text
    FilePath = str | Path
else:
    FilePath = Annotated[UserPath, BeforeValidator(lambda p: str(p) if isinstance(p, Path) else p)]


# what a file describes
SIZES = {"opening", "finger_length", "finger_width", "finger_thickness", "fingertip", "palm"}


# what a gripper with a suction cup can have besides it
OF_CUP = {"cup", "opening", "sampler"}
CUP_SCALE = 0.08  # metres


class Gripper(UserParameters):
    """A gripper: two jaws that close, or a suction cup."""

    cup: SuctionCup | None = Field(default=None)
    """suction cup in place of jaws; nothing: jaws"""
    sampler: UserPath = Field(default="")
    """grasp sampler: empty: antipodal (jaws) or suction (cups); FILE.py:NAME: a function of your
    own"""

    file: FilePath | None = Field(default=None)
    """URDF or MJCF file of the hand; opening, sizes and collision shapes come from it; `egad
    gripper inspect FILE` shows what is found"""
    joint: str | None = Field(default=None)
    """name of the joint in the file that closes the hand; nothing: detected"""
    finger_links: tuple[str, str] | None = Field(default=None)
    """names of one link of each finger in the file; nothing: detected"""
    pad_links: tuple[str, str] | None = Field(default=None)
    """names of the links with the pads in the file; nothing: detected"""
    tcp: Place | None = Field(default=None)
    """middle of the closed pads in the frame of the palm's link in the file, metres; nothing:
    detected"""
    closing_axis: Place | None = Field(default=None)
    """closing axis in the frame of the palm's link in the file; nothing: detected"""
    approach_axis: Place | None = Field(default=None)
    """approach axis in the frame of the palm's link in the file; nothing: detected"""
    opening: Length
    """widest opening, metres; with a file, by default that of the hand; with a cup, objects are
    scaled as for jaws of this opening (default 0.08)"""
    finger_length: Length = Field(default=0.04)
    """length of a finger from palm to fingertip, metres"""
    finger_width: Length = Field(default=0.02)
    """width of a finger, across the closing axis and the approach, metres"""
    finger_thickness: Length = Field(default=0.01)
    """thickness of a finger along the closing axis, metres"""
    fingertip: Length | None = Field(default=None)
    """distance from the middle of the pads to the fingertips, metres; nothing: half the width of a
    finger"""
    palm: tuple[Length, Length, Length] = Field(default=(0.1, 0.06, 0.05))
    """sides of the palm box, metres: along the closing axis, across it, along the approach"""
    mesh: FilePath | None = Field(default=None)
    """mesh file, in metres, that replaces the palm box where grasps are checked for collisions; x
    is the closing axis, z the approach, and the origin lies midway between the fingers, where they
    begin"""
    force: float = Field(default=40.0, gt=0)
    """closing force, newtons; of a jaw that turns, at its pads"""
    torque: float | None = Field(default=None, gt=0)
    """torque of the joint of a jaw that turns, newton metres, in place of `force`, which follows
    from the distance of the pads from the hinge"""
    pads: Literal["silicone", "bare"] = Field(default="silicone")
    """finger pads in simulation: silicone, friction 0.8; or bare plastic or metal, friction 0.4"""
    friction: float | None = Field(default=None, gt=0, le=2)
    """friction of the pads in simulation; nothing: that of their material"""

    @classmethod
    def from_file(cls, file: str | Path, **settings: Any) -> Self:  # noqa: ANN401 (fields)
        """A gripper from the URDF or MJCF file that its maker publishes.

        The actuated joint, mimic joints and linkages, the fingers and their pads, the closing and
        approach axes and the opening are found in the file. Set explicitly whatever is found
        incorrectly. One of the two jaws may be part of the palm, while the other one turns or
        slides.

        Args:
            file: The file. Its meshes are searched for where it says, and ROS packages in the
                folders above it and in those of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
            settings: Other fields of a gripper, such as `force` or `joint`.

        Raises:
            UserError: The file cannot be used, or it is neither a parallel-jaw hand nor one with a
                moving jaw; the message names the link or joint.
        """
        return cls(file=file, **settings)

    @model_validator(mode="before")
    @classmethod
    def _sizes_from_the_file(cls, values: Any) -> Any:  # noqa: ANN401 (whatever was given)
        if not isinstance(values, dict):
            return values
        # strict reading of JSON accepts a list as a tuple, but not behind a validator
        values = {key: tuple(v) if isinstance(v, list) else v for key, v in values.items()}
        if values.get("cup") is not None:
            return _with_cup(values)
        torque = values.get("torque")
        if not isinstance(values.get("file"), str | Path):
            if torque is not None:
                raise ValueError("torque is for the file of a hand with a jaw that turns")
            return values
        if values.get("mesh") is not None:
            raise ValueError("a gripper takes a file or a mesh for its palm, not both")
        missing = SIZES - {name for name, value in values.items() if value is not None}
        if not missing and (torque is None or values.get("force") is not None):
            return values
        from egad.grippers.described import (  # noqa: PLC0415 (it takes long)
            force_at_pads,
            read_described,
            sizes_of,
        )

        model = read_described(Path(values["file"]).expanduser(), values)
        found = sizes_of(model)
        if isinstance(opening := values.get("opening"), int | float) and opening > found["opening"]:
            raise ValueError(
                f"opening is {opening:g}; the hand of {values['file']} opens at most "
                f"{found['opening']:.4g} m"
            )
        if isinstance(torque, int | float) and torque > 0:
            values = values | {"force": force_at_pads(model, torque, values.get("force"))}
        return values | {name: found[name] for name in missing}

    @property
    def kind(self) -> Kind:
        """What it holds objects with, asked wherever kinds of grippers differ."""
        if self.cup is not None:
            return CupKind(self.cup.height)
        return JawKind(self.finger_length, self.finger_width, self.fingertip)

    @property
    def grasps_with(self) -> str:
        """The sampler that applies: `antipodal`, `suction`, or the name of a function."""
        return self.sampler or self.kind.sampler

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """What pydantic prints: the fields that differ from their defaults."""
        for name, field in type(self).model_fields.items():
            value = getattr(self, name)
            if value != field.default:
                yield name, value

    def _repr_html_(self) -> str:
        """All fields that are set, for notebooks."""
        known = OF_CUP if self.cup else type(self).model_fields.keys()
        given = {name: value for name, value in dict(self).items() if name in known}
        facts = {name: value for name, value in given.items() if value not in (None, "")}
        return facts_html("Gripper (metres, newtons)", facts)

    @property
    def pad(self) -> Surface:
        """The pads with the friction that applies."""
        pad = PADS[self.pads]
        return pad if self.friction is None else pad._replace(friction=self.friction)


def _with_cup(values: dict[str, Any]) -> dict[str, Any]:
    """The settings of a gripper with a cup; `ValueError` if it has a setting of jaws."""
    fields = Gripper.model_fields
    others = {name: value for name, value in values.items() if name in fields.keys() - OF_CUP}
    if odd := [name for name, value in others.items() if value != fields[name].default]:
        raise ValueError(
            f"a gripper with a suction cup has no {' or '.join(odd)}; allowed: "
            f"{', '.join(sorted(OF_CUP))}"
        )
    return {"opening": CUP_SCALE, **values}
