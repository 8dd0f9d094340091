"""Reading the model of a hand that its maker publishes: URDF or MJCF, by MuJoCo."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from egad.errors import UserError

log = logging.getLogger(__name__)
Floats = NDArray[np.float64]

MOVING = {int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)}
LEAST_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
LARGEST_LINK = 1.0  # metres
ROUND = 32  # corners of a circle
BOX_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def read_description(path: Path) -> mujoco.MjModel:
    """The links, joints and collision shapes that a URDF or MJCF file describes.

    Meshes of `package://NAME/...` are looked for in the folders above the file. Shapes that are
    only seen are left out.

    Args:
        path: The file.

    Raises:
        UserError: The file or one of its meshes cannot be used.
    """
    with _logged_warnings(path):
        model = _compiled(path)
    _check_shapes(model, path)
    return model


def _compiled(path: Path) -> mujoco.MjModel:
    """The model that a file describes, with shapes that collide only."""
    spec = _parse(path)
    compiler = spec.compiler
    compiler.fusestatic = False
    compiler.discardvisual = True
    compiler.boundmass = compiler.boundinertia = LEAST_INERTIA
    try:
        return spec.compile()
    except ValueError as error:
        raise UserError(f"{path}: MuJoCo refuses it: {_line(error)}") from error


def description_files(path: Path) -> list[Path]:
    """A URDF or MJCF file and the meshes that it names.

    Args:
        path: The file.

    Raises:
        UserError: The file or one of its meshes cannot be used.
    """
    with _logged_warnings(path):
        return [path, *(Path(mesh.file) for mesh in _parse(path).meshes if mesh.file)]


@contextmanager
def _logged_warnings(path: Path) -> Iterator[None]:
    """Log what MuJoCo warns of. Otherwise it writes a file into the current folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: log.warning("%s: %s", path, text))
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _parse(path: Path) -> mujoco.MjSpec:
    """The description with its meshes found; raises as `read_description`."""
    if not path.is_file():
        raise UserError(f"{path}: there is no such file")
    try:
        spec = mujoco.MjSpec.from_file(str(path.resolve()))
    except ValueError as error:
        raise UserError(f"{path} is no URDF or MJCF that MuJoCo reads: {_line(error)}") from error
    _find_meshes(spec, path)
    return spec


def body_name(model: mujoco.MjModel, body: int) -> str:
    """Name of a link."""
    return str(model.body(body).name)


def joint_name(model: mujoco.MjModel, joint: int) -> str:
    """Name of a joint."""
    return str(model.joint(joint).name)


def moving_joints(model: mujoco.MjModel) -> list[int]:
    """Numbers of the joints that slide or turn."""
    return [joint for joint in range(model.njnt) if int(model.jnt_type[joint]) in MOVING]


def subtree(model: mujoco.MjModel, body: int) -> set[int]:
    """A link and all that it carries."""
    carried = {body}
    for other in range(body + 1, model.nbody):  # parents come first
        if model.body_parentid[other] in carried:
            carried.add(other)
    return carried


def shapes_of(model: mujoco.MjModel, body: int) -> list[Floats]:
    """Points whose convex hulls are the collision shapes of a link, (n, 3) each, in its frame."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    shapes = [shape for shape in range(first, first + count) if _collides(model, shape)]
    return [_points(model, shape) for shape in shapes]


def _points(model: mujoco.MjModel, shape: int) -> Floats:
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[shape])
    corners = _corners(model, shape)
    return np.asarray(corners @ turn.reshape(3, 3).T + model.geom_pos[shape])


def _corners(model: mujoco.MjModel, shape: int) -> Floats:
    """Points of a shape in its own frame. Round ones get the corners of polygons around them."""
    kind, size = model.geom_type[shape], model.geom_size[shape]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[shape]
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        return np.asarray(vertices, dtype=np.float64)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return np.asarray(BOX_CORNERS * size)
    angles = 2 * np.pi * np.arange(ROUND) / ROUND
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / ROUND)
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return _ring(circle * size[0], -size[1], size[1])
    levels = np.sin(np.linspace(-np.pi / 2, np.pi / 2, ROUND // 2 + 1))
    ball = np.concatenate([_ring(np.sqrt(1 - z * z) * circle, z) for z in levels])
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        ball *= size[0]
        ends = np.array([[0, 0, size[1]]])
        return np.concatenate([ball - ends, ball + ends])
    return np.asarray(ball * (size if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else size[0]))


def _ring(circle: Floats, *heights: float) -> Floats:
    return np.concatenate([np.insert(circle, 2, height, axis=1) for height in heights])


def _collides(model: mujoco.MjModel, shape: int) -> bool:
    plane = model.geom_type[shape] == mujoco.mjtGeom.mjGEOM_PLANE
    return bool(model.geom_contype[shape] | model.geom_conaffinity[shape]) and not plane


def _check_shapes(model: mujoco.MjModel, path: Path) -> None:
    """Raise UserError if nothing collides, or something is larger than any hand."""
    found = False
    for body in range(1, model.nbody):
        for points in shapes_of(model, body):
            found = True
            if (size := float(np.ptp(points, axis=0).max())) > LARGEST_LINK:
                raise UserError(
                    f"{path}: the link {body_name(model, body)} is {size:.3g} m wide. If its mesh "
                    'is in millimetres, give it scale="0.001 0.001 0.001"'
                )
    if not found:
        names = ", ".join(body_name(model, body) for body in range(1, model.nbody))
        raise UserError(f"{path}: none of its links has collision shapes: {names}")


def _find_meshes(spec: mujoco.MjSpec, path: Path) -> None:
    """Let meshes be read from where they are.

    Raises:
        UserError: One is missing, or in a format that MuJoCo does not read.
    """
    users = {shape.meshname: shape.parent.name for shape in reversed(spec.geoms) if shape.meshname}
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        wanted = mesh.file if "://" in mesh.file else str(Path(spec.meshdir) / mesh.file)
        places = list(_places(wanted, path))
        found = next((place for place in places if place.is_file()), None)
        link = f"a mesh of the link {users[mesh.name]}" if mesh.name in users else "a mesh"
        if found is None:
            looked = ", ".join(str(place) for place in places[:3])
            raise UserError(f"{path}: {link} is missing: {mesh.file} (looked for {looked})")
        mesh.file = str(found.resolve())


def _places(wanted: str, path: Path) -> Iterator[Path]:
    """Where a mesh file may be."""
    folder = path.resolve().parent
    if not wanted.startswith("package://"):
        yield folder / wanted.removeprefix("file://")
        return
    package, _, rest = wanted.removeprefix("package://").partition("/")
    for above in (folder, *folder.parents):
        if above.name == package:
            yield above / rest
        yield above / package / rest


def _line(error: Exception) -> str:
    """The text of an error in one line."""
    return " ".join(str(error).removeprefix("Error: ").split())
