"""Films of the simulation, drawn in software: no window and no graphics card."""

from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pybullet
from numpy.typing import NDArray

from egad._util.files import atomic_output
from egad.errors import UserError
from egad.sim.world import TIME_STEP, World

Pixels = NDArray[np.uint8]

ENDINGS = (".gif", ".mp4")
STEPS = 12  # of the simulation, from one frame to the next: 20 a second
SIZE = (352, 400)  # multiples of 16, as video wants them
DISTANCE, YAW, PITCH = 0.5, 35.0, -9.0
FIELD_OF_VIEW = 38.0
LOWEST = (-np.inf, -np.inf, 0.06)  # that the camera looks at; it follows the object
FOLLOWING = 0.3  # of the way to it, in a frame
LIGHT = (-0.4, -0.6, 1.2)
ORANGE = (0.93, 0.55, 0.2, 1)


class Film:
    """Looks at a world in real time: what the engine collides is what is seen."""

    def __init__(self, world: World) -> None:
        """Watch a world from its next step on.

        Args:
            world: The world.
        """
        self.frames: list[Pixels] = []
        self._steps = 0
        self._looking_at = np.array([0.0, 0.0, LOWEST[2]])
        self._projection = pybullet.computeProjectionMatrixFOV(
            FIELD_OF_VIEW, SIZE[0] / SIZE[1], 0.05, 5.0
        )
        world.watch = self._look

    def _look(self, world: World) -> None:
        if self._steps % STEPS == 0:
            self.frames.append(self._frame(world))
        self._steps += 1

    def _frame(self, world: World) -> Pixels:
        client = world.client
        place = np.maximum(client.getBasePositionAndOrientation(world.object)[0], LOWEST)
        self._looking_at += FOLLOWING * (place - self._looking_at)
        view = pybullet.computeViewMatrixFromYawPitchRoll(
            self._looking_at.tolist(), DISTANCE, YAW, PITCH, 0, 2
        )
        client.changeVisualShape(world.object, -1, rgbaColor=ORANGE)
        picture = client.getCameraImage(
            *SIZE,
            view,
            self._projection,
            lightDirection=LIGHT,
            shadow=1,
            renderer=pybullet.ER_TINY_RENDERER,
        )[2]
        frame: Pixels = np.reshape(np.asarray(picture, dtype=np.uint8), (SIZE[1], SIZE[0], 4))
        return frame[..., :3].copy()


def write_film(frames: list[Pixels], path: Path) -> None:
    """Write a film in real time.

    Args:
        frames: Pictures of one size.
        path: `.gif`, or `.mp4` if ffmpeg is there.

    Raises:
        UserError: There is no ffmpeg for it.
    """
    seconds = STEPS * TIME_STEP
    if path.suffix.lower() == ".gif":
        data = imageio.imwrite("<bytes>", frames, extension=".gif", duration=1000 * seconds, loop=0)
    else:
        try:
            data = imageio.imwrite(
                "<bytes>", frames, extension=".mp4", plugin="FFMPEG", fps=1 / seconds
            )
        except ImportError as error:
            raise UserError(
                f"{path}: MP4 needs ffmpeg (pip install imageio-ffmpeg); GIF does not"
            ) from error
    with atomic_output(path) as temporary:
        temporary.write_bytes(data)
