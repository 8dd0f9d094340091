"""Settings of labelled scenes for training detectors."""

from typing import Self

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, ParameterGroup, Parameters, Seed
from egad.bench import CUSTOM, NAMED_PROTOCOLS, Clutter, ClutterParameters, Protocol, SceneCameras
from egad.detectors import NoiseName
from egad.geometry import Material
from egad.grippers import Gripper
from egad.sim import ENGINES, EngineName

MAX_OBJECTS = 20  # in a scene
# How far the fingertips reach below the surface, in finger lengths. In VGN's code from -0.1 on,
# where nothing is held.
DEPTHS = (0.1, 1.1)
TRAINING_CAMERAS: SceneCameras = SceneCameras(
    distance=(0.48, 0.72), tilt=(5.0, 65.0), azimuth=(0.0, 360.0)
)


class TrainingScenes(Parameters):
    """Scenes of several objects with depth images and grasps labelled by simulation."""

    scenes: int = Field(1000, ge=1, le=10_000_000)
    """scenes per dataset, regardless of the number of objects; about 4 s each"""
    pile: Fraction = 0.5
    """fraction of the scenes that are piles; in the others, objects are packed"""
    objects: float = Field(5.0, ge=1, le=10)
    """mean number of objects put into a scene: one plus a Poisson-distributed number"""
    grasps: int = Field(60, ge=1, le=10_000)
    """labelled grasps per scene"""
    yaws: int = Field(5, ge=1, le=64)
    """rotations about the approach that are simulated for each grasp, evenly spaced over half a
    turn; the grasp succeeds if one of them does"""
    protocol: Protocol = NAMED_PROTOCOLS["egad"]
    """rules of a published benchmark, or a section, as in `clutter.protocol`, for sizes, packing,
    dropping, friction, closing force and success; for labels, the hand opens fully, and a contact
    force above `stopping_force` during the approach is a failure; a section must not set cameras or
    noise: set `scenes.cameras` and `scenes.noise`"""
    engine: EngineName = ENGINES[0]
    """physics engine, as in `trials`"""
    cameras: SceneCameras = TRAINING_CAMERAS
    """cameras of the images; values with a range are sampled for each view"""
    noise: tuple[NoiseName, ...] = Field(("none", "dex"), min_length=1)
    """kinds of noise added to depth images, as in `clutter.noise`; one is sampled per scene"""
    validation: Fraction = 0.1
    """fraction of objects and scenes in the validation set"""
    test: Fraction = 0.1
    """fraction of objects and scenes in the test set"""
    hold_out: bool = True
    """whether the objects of the evaluation set, their parents and their children are kept out of
    all scenes; not if the set is the whole dataset"""

    @model_validator(mode="after")
    def _something_is_left(self) -> Self:
        if self.validation + self.test >= 1:
            raise ValueError("validation and test together must be less than 1")
        return self

    @model_validator(mode="after")
    def _cameras_and_noise_are_those_of_the_scenes(self) -> Self:
        rules, usual = self.protocol, NAMED_PROTOCOLS["egad"]
        if rules.name == CUSTOM and (rules.cameras, rules.noise) != (usual.cameras, usual.noise):
            raise ValueError(
                "cameras and noise of a protocol are not used for labelled scenes; set those of "
                "the scenes instead (scenes.cameras, scenes.noise)"
            )
        return self


class SceneParameters(ParameterGroup):
    """The settings that labelled scenes depend on."""

    seed: Seed
    gripper: Gripper
    scenes: TrainingScenes

    @property
    def clutter(self) -> ClutterParameters:
        """The same as settings of rounds of clearing a table, with the cameras of the images."""
        protocol = self.scenes.protocol.model_copy(update={"cameras": self.scenes.cameras})
        clutter = Clutter(engine=self.scenes.engine, protocol=protocol)
        return ClutterParameters(seed=self.seed, gripper=self.gripper, clutter=clutter)


class MakeScenes(SceneParameters):
    """Labelled scenes of the objects of a dataset."""

    material: Material
