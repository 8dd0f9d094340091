"""Settings of grasp detectors, and of the noise of what they see."""

from pathlib import Path
from typing import Any, Literal, Self, get_args

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, Parameters, UserPath
from egad.errors import UserError
from egad.grippers import Gripper
from egad.grippers.kinds import CupKind, JawKind

SIZE = 300  # pixels along each side of the image that goes in, and of those that come out
NoiseName = Literal["none", "stereo", "gamma", "dex", "points"]
NOISES: tuple[NoiseName, ...] = get_args(NoiseName)
Execution = Literal["deepest", "published"]
# Written by `egad train`. Not by way of `egad.data`: its other files do not affect detectors.
NETWORKS = Path(__file__).parents[1] / "data" / "networks"
_GGCNN2 = {"detector": "ggcnn", "weights": str(NETWORKS / "ggcnn2-evolved" / "weights.safetensors")}
_VGN = {"detector": "vgn", "weights": str(NETWORKS / "vgn-evolved" / "weights.safetensors")}
SHIPPED_NETWORKS: dict[str, dict[str, Any]] = {
    "ggcnn2-evolved": _GGCNN2,
    "ggcnn2-evolved-published": {**_GGCNN2, "execution": "published"},
    "vgn-evolved": {**_VGN, "threshold": 0.1, "avoid_collisions": True},
}
"""Settings of the networks that egad ships, as for a detector with the user's own weights."""
SHIPPED = (
    "antipodal-cloud",
    "antipodal-depth",
    "ggcnn",
    *SHIPPED_NETWORKS,
    "labels",
    "random",
    "suction-cloud",
    "suction-depth",
    "vgn",
)
FOR_CUPS = ("suction-cloud", "suction-depth")
IN_ANY_DIRECTION = ("antipodal-cloud", "graspgen", "suction-cloud", "vgn", "vgn-evolved")
LABELS = "labels"  # knows where the objects are
GRASPGEN = "graspgen"  # shipped, but of no use without an address
KNOWN_GRASPS = "grasps:"  # begins a detector that is a file of grasps, or a folder of them
ONLY_FOR = {"execution": "ggcnn", "threshold": "vgn", "avoid_collisions": "vgn"}
KNOWN = f"{', '.join(SHIPPED)}, {GRASPGEN}"
FOR_KIND = {  # of grippers
    JawKind.name: tuple(name for name in (*SHIPPED, GRASPGEN) if name not in FOR_CUPS),
    CupKind.name: (*FOR_CUPS, LABELS),
}


class DetectorConfig(Parameters):
    """A named grasp detector."""

    detector: UserPath | None = Field(
        None,
        description=f"built-in detector ({KNOWN}); your own: FILE.py:CLASS or "
        "package.module:CLASS; or known grasps: grasps:FILE, or grasps:FOLDER with a file for each "
        "object, at the size in which it is grasped",
    )
    command: tuple[UserPath, ...] | None = Field(None, min_length=1)
    """instead of `detector`: the command that starts it in its own environment"""
    weights: UserPath | None = None
    """file that the detector loads, such as the weights of a network"""
    execution: Execution = "deepest"
    """how deep the grasps of `ggcnn` are executed: deepest: as deep as the image allows; published:
    10 mm below the surface at the best pixel, as on the robot of EGAD"""
    threshold: float | None = Field(None, gt=0, lt=1)
    """minimum quality of the proposals of `vgn`; nothing: the `threshold` of the clutter protocol
    if it has one, else 0.5 for weights of `egad train` and 0.9 for others"""
    avoid_collisions: bool = False
    """whether `vgn` multiplies the quality of its proposals by 0.1 if the hand, at the grasp or on
    the last 5 cm before it, would touch the point cloud or the table"""
    address: str | None = None
    """address of the server of `graspgen`, such as tcp://localhost:5556"""

    @property
    def name(self) -> str:
        """The detector, or the command as one text."""
        return self.detector or " ".join(self.command or ())

    @property
    def known_grasps(self) -> Path | None:
        """The file of `grasps:FILE`, or the folder of `grasps:FOLDER`."""
        before, _, path = (self.detector or "").partition(KNOWN_GRASPS)
        return Path(path).expanduser() if path and not before else None

    @model_validator(mode="after")
    def _detector_can_be_found(self) -> Self:
        if (self.detector is None) == (self.command is None):
            raise ValueError("a detector needs either `detector` or `command`")
        if (self.detector == GRASPGEN) != (self.address is not None):
            raise ValueError(
                "the detector graspgen needs `address`; other detectors do not take it"
            )
        for key, owner in ONLY_FOR.items():
            changed = getattr(self, key) != type(self).model_fields[key].default
            if changed and self.detector != owner:
                raise ValueError(f"the detector {self.name} takes no `{key}`: only {owner} does")
        if self.detector is None:
            if self.weights:
                raise ValueError(
                    "a detector with `command` takes no `weights`: put them into `command`"
                )
            return self
        module, _, name = self.detector.rpartition(":")
        known = self.detector in (*SHIPPED, GRASPGEN) or self.known_grasps is not None
        if not known and not (module and name.isidentifier()):
            raise ValueError(
                f"detector is {self.detector!r}; allowed: {KNOWN}, "
                "FILE.py:CLASS, package.module:CLASS, grasps:FILE or grasps:FOLDER"
            )
        if self.weights and known and self.detector not in ("ggcnn", "vgn"):
            raise ValueError(f"the detector {self.detector} takes no `weights`")
        return self


def knows_scene(detect: object) -> bool:
    """Whether a detector knows where the objects are."""
    return isinstance(detect, DetectorConfig) and bool(
        detect.detector == LABELS or detect.known_grasps
    )


def check_gripper(detector: str, gripper: Gripper) -> None:
    """Raise UserError if a built-in detector is for another kind of gripper."""
    fitting = FOR_KIND[gripper.kind.name]
    only_jaws = detector.startswith(KNOWN_GRASPS) and not gripper.kind.closes
    if only_jaws or (detector in (*SHIPPED, GRASPGEN) and detector not in fitting):
        other = "suction cups" if detector in FOR_CUPS else "jaws"
        raise UserError(
            f"the detector {detector} is for {other}; the gripper has {gripper.kind.noun}; "
            f"allowed: {', '.join(fitting)}"
        )


DETECTORS = {name: DetectorConfig(detector=name) for name in SHIPPED}


class ImageNoise(Parameters):
    """Noise of a real depth camera in the rendered images; off by default."""

    disparity: float = Field(0.0, ge=0, le=10)
    """standard deviation of the disparity, pixels; the depth error grows with the square of the
    depth: 0.1 pixels are 1.7 mm at 0.6 m; errors of pixels less than 7 apart are correlated"""
    holes: bool = False
    """whether depth is missing where the second imager sees nothing (beside edges), and where the
    line of sight is within 10 degrees of the surface"""
    missing: Fraction = 0.0
    """fraction of the pixels that have no depth, in small spots"""
