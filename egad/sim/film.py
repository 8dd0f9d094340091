"""Films of the simulation by ray casting: no window and no graphics card."""

from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, RgbImage
from egad._util.files import atomic_output
from egad.errors import UserError
from egad.geometry import TriangleScene
from egad.sim.robot import shape_mesh
from egad.sim.world import TIME_STEP, World

ENDINGS = (".gif", ".mp4")
STEPS = 12  # of the simulation, from one frame to the next: 20 frames per second
SIZE = (352, 400)  # multiples of 16, as video wants them
FOLLOWED, WHOLE = (0.5, 35.0, -9.0), (0.7, 35.0, -40.0)  # cameras: metres, yaw and pitch, degrees
FIELD_OF_VIEW = 38.0  # vertical, degrees
LOWEST = (-np.inf, -np.inf, 0.06)  # lowest point that the camera looks at, as it follows the object
FOLLOWING = 0.3  # fraction of the way to the object, per frame
LIGHT = np.array([0.0, -0.7, 1.2]) / np.linalg.norm([0.0, -0.7, 1.2])
AMBIENT, HEADLIGHT = 0.4, 0.2  # fractions of the brightness; the rest comes from the light
TABLE_SIDE = 100.0  # metres
SKY = (0.97, 0.97, 0.98)
TABLE_COLOR, ROBOT_COLOR = (0.87, 0.88, 0.9), (0.55, 0.6, 0.68)
OBJECT_COLORS = (
    (0.93, 0.55, 0.2),
    (0.27, 0.55, 0.75),
    (0.55, 0.7, 0.3),
    (0.75, 0.4, 0.6),
    (0.9, 0.78, 0.3),
)
OFF = 1e-4  # metres; rays to the light start this far off the surface


class Film:
    """Films a world in real time; it shows the shapes that the engine collides."""

    def __init__(self, world: World) -> None:
        """Film a world from its next step on."""
        self.frames: list[RgbImage] = []
        self._world, self._steps = world, 0
        self._looking_at = np.array([0.0, 0.0, LOWEST[2]])
        self._objects = [trimesh.util.concatenate(list(model.parts)) for model in world.models]
        self._links = (
            [] if world.robot is None else [link.shapes + link.soft for link in world.robot.links]
        )
        world.watch = self._look

    def _look(self, _: World) -> None:
        if self._steps % STEPS == 0:
            self.frames.append(self.frame())
        self._steps += 1

    def frame(self) -> RgbImage:
        """The current frame."""
        world = self._world
        camera = FOLLOWED if len(self._objects) == 1 else WHOLE
        bodies = [(_table(), TABLE_COLOR)]
        for number in world.present():
            pose = world.pose(number)
            color = OBJECT_COLORS[number % len(OBJECT_COLORS)]
            bodies.append((self._objects[number].copy().apply_transform(pose.matrix), color))
            if camera == FOLLOWED:
                way = np.maximum(pose.position, LOWEST) - self._looking_at
                self._looking_at += FOLLOWING * way
        places = world.link_poses()
        for shapes, place in zip(self._links if places else [], places, strict=True):
            for shape in shapes:
                mesh = shape_mesh(shape)
                bodies.append((mesh.apply_transform(place.matrix), ROBOT_COLOR))
        return draw(bodies, self._looking_at, camera)


def draw(
    bodies: list[tuple[trimesh.Trimesh, tuple[float, float, float]]],
    looking_at: Floats,
    camera: tuple[float, float, float] = FOLLOWED,
) -> RgbImage:
    """Draw colored meshes with one light, (height, width, 3); camera at m and degrees."""
    counts = [len(mesh.faces) for mesh, _ in bodies]
    colors = np.repeat([color for _, color in bodies], counts, axis=0)
    scene = TriangleScene(
        *trimesh.util.append_faces(
            [mesh.vertices for mesh, _ in bodies], [mesh.faces for mesh, _ in bodies]
        )
    )
    eye, rays = _rays(looking_at, *camera)
    hits = scene.intersections(np.broadcast_to(eye, rays.shape), rays)
    seen = hits.faces >= 0
    points = eye + rays[seen] * hits.distances[seen, None]
    normals = hits.normals[seen] / np.linalg.norm(hits.normals[seen], axis=1, keepdims=True)
    facing = -np.einsum("ij,ij->i", normals, rays[seen])
    normals *= np.sign(facing)[:, None]
    shadow = scene.occluded(points + OFF * normals, np.broadcast_to(LIGHT, points.shape))
    lit = np.where(shadow, 0.0, np.maximum(normals @ LIGHT, 0.0))
    bright = AMBIENT + HEADLIGHT * np.abs(facing) + (1 - AMBIENT - HEADLIGHT) * lit
    picture = np.tile(np.array(SKY), (len(rays), 1))
    picture[seen] = colors[hits.faces[seen]] * bright[:, None]
    return np.round(255 * picture).astype(np.uint8).reshape(SIZE[1], SIZE[0], 3)


def _rays(looking_at: Floats, distance: float, yaw: float, pitch: float) -> tuple[Floats, Floats]:
    """Position of the camera, (3,), and directions of its pixels, (n, 3), row by row."""
    turn = Rotation.from_euler("ZX", [yaw, pitch], degrees=True).as_matrix()
    right, forward, up = turn.T
    half = np.tan(np.radians(FIELD_OF_VIEW) / 2)
    width, height = SIZE
    across = (np.arange(width) + 0.5 - width / 2) / (height / 2) * half
    down = (np.arange(height) + 0.5 - height / 2) / (height / 2) * half
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(across, down))
    rays: Floats = forward + u * right - v * up
    return looking_at - distance * forward, rays / np.linalg.norm(rays, axis=1, keepdims=True)


def _table() -> trimesh.Trimesh:
    side = TABLE_SIDE / 2
    corners = [(-side, -side, 0), (side, -side, 0), (side, side, 0), (-side, side, 0)]
    return trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 3)], process=False)


def write_film(frames: list[RgbImage], path: Path) -> None:
    """Write pictures as a film in real time: `.gif`, or `.mp4`; `UserError` without ffmpeg."""
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
