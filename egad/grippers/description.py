"""Read the model of a hand that its maker publishes, URDF or MJCF, with MuJoCo."""

import logging
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

from egad._util.arrays import Floats, Ints
from egad.errors import UserError
from egad.grippers.mechanism import body_name
from egad.grippers.shape_files import Packages, find_file, list_packages, read_shape
from egad.grippers.urdf import read_urdf, without_faults

log = logging.getLogger(__name__)

USD = (".usd", ".usda", ".usdc", ".usdz")
NOT_READ = "it is not URDF or MJCF that MuJoCo can read: "
MIN_INERTIA = 1e-6  # kg and kg m2; links without mass are not allowed
MAX_LINK = 1.0  # metres
ROUND = 32  # corners of a circle
BOX_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def read_description(path: Path) -> mujoco.MjSpec:
    """A URDF or MJCF file as it is written, or `UserError`."""
    if not path.is_file():
        raise UserError("there is no such file")
    if path.suffix.lower() in USD:
        raise UserError(
            "USD is not read; export URDF or MJCF, such as with the URDF exporter of Isaac Sim, or "
            "take the URDF or MJCF that the USD file was made from"
        )
    text = read_urdf(path)
    spec = _read_mjcf(path) if text is None else _parsed(lambda: mujoco.MjSpec.from_string(text))
    for shape in spec.geoms:
        if shape.type == mujoco.mjtGeom.mjGEOM_HFIELD:
            _replace(shape)
    for each in (*spec.skins, *spec.hfields):
        spec.delete(each)
    return spec


def _read_mjcf(path: Path) -> mujoco.MjSpec:
    """A MJCF file, without what MuJoCo refuses but other programs allow in parts of a model."""
    try:
        return mujoco.MjSpec.from_file(str(path.resolve()))
    except ValueError as error:
        repaired = without_faults(path)
        if repaired is None:
            raise UserError(NOT_READ + _line(error)) from error
    return _parsed(lambda: mujoco.MjSpec.from_string(repaired))


def _parsed(read: Callable[[], mujoco.MjSpec]) -> mujoco.MjSpec:
    try:
        return read()
    except ValueError as error:
        raise UserError(NOT_READ + _line(error)) from error


def compile_skeleton(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The links and joints of a description, without shapes, whose files may be missing."""
    bare = spec.copy()
    for shape in bare.geoms:
        _replace(shape)
    for mesh in bare.meshes:
        bare.delete(mesh)
    return _compiled(bare)


def compile_with_shapes(spec: mujoco.MjSpec, path: Path, bodies: Collection[int]) -> mujoco.MjModel:
    """A description, which is changed, compiled with the collision shapes of some links."""
    for number, body in enumerate(spec.bodies):
        if number not in bodies:
            for shape in body.geoms:
                _replace(shape)
    used = {shape.meshname for shape in spec.geoms}
    for mesh in spec.meshes:
        if mesh.name not in used:
            spec.delete(mesh)
    _read_meshes(spec, path)
    model = _compiled(spec)
    _check_shapes(model)
    return model


def description_files(path: Path) -> list[Path]:
    """A URDF or MJCF file and the meshes it names that exist; `UserError` if it cannot be used."""
    with name_file_in_messages(path):
        spec = read_description(path)
    return [path, *mesh_files(spec, path)]


def mesh_files(spec: mujoco.MjSpec, path: Path) -> list[Path]:
    """The meshes that a description from a file names and that exist."""
    packages, found = cache(list_packages), []
    for mesh in spec.meshes:
        with suppress(UserError):
            found.append(_mesh_file(spec, mesh, path, packages))
    return found


@contextmanager
def name_file_in_messages(path: Path) -> Iterator[None]:
    """Name the file in errors and in MuJoCo's warnings, which it would write into a file here."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: log.warning("%s: %s", path, text))
    try:
        yield
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    finally:
        mujoco.set_mju_user_warning(before)


def _replace(shape: mujoco.MjsGeom) -> None:
    """Replace a shape by a small ball that touches nothing."""
    shape.type, shape.meshname = mujoco.mjtGeom.mjGEOM_SPHERE, ""
    shape.hfieldname = ""
    shape.size[:], shape.fromto[:] = MIN_INERTIA, np.nan
    shape.contype = shape.conaffinity = 0


def _compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model of a description, with only the shapes that collide."""
    compiler = spec.compiler
    compiler.fusestatic = False
    compiler.discardvisual = compiler.balanceinertia = True
    compiler.boundmass = compiler.boundinertia = MIN_INERTIA
    try:
        return spec.compile()
    except ValueError as error:
        raise UserError(f"MuJoCo rejects it: {_line(error)}") from error


def shapes_of(model: mujoco.MjModel, body: int) -> list[Floats]:
    """Points whose convex hulls are the collision shapes of a link, (n, 3) each, in its frame."""
    return [points for points, _ in shape_surfaces(model, body)]


def shape_surfaces(model: mujoco.MjModel, body: int) -> Iterator[tuple[Floats, Ints]]:
    """Points and faces of the collision shapes of a link; no faces: their convex hull counts."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    for shape in range(first, first + count):
        if not _collides(model, shape):
            continue
        faces = np.empty((0, 3), dtype=np.int64)
        if model.geom_type[shape] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[shape]
            start = model.mesh_faceadr[mesh]
            faces = model.mesh_face[start : start + model.mesh_facenum[mesh]].astype(np.int64)
        yield _points(model, shape), faces


def _points(model: mujoco.MjModel, shape: int) -> Floats:
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[shape])
    corners = _corners(model, shape)
    return np.asarray(corners @ turn.reshape(3, 3).T + model.geom_pos[shape])


def _corners(model: mujoco.MjModel, shape: int) -> Floats:
    """Points of a shape in its own frame; round shapes get the corners of polygons around them."""
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


def _check_shapes(model: mujoco.MjModel) -> None:
    """Raise UserError if nothing collides, or something is larger than any hand."""
    found = False
    for body in range(1, model.nbody):
        for points in shapes_of(model, body):
            found = True
            if (size := float(np.ptp(points, axis=0).max())) > MAX_LINK:
                raise UserError(
                    f"the link {body_name(model, body)} is {size:.3g} m wide. If its mesh is in "
                    'millimetres, give it scale="0.001 0.001 0.001"'
                )
    if not found:
        names = ", ".join(body_name(model, body) for body in range(1, model.nbody))
        raise UserError(f"none of its links has collision shapes: {names}")


def _read_meshes(spec: mujoco.MjSpec, path: Path) -> None:
    """Let meshes be read from their files, or give them corners of their hulls, or `UserError`."""
    packages = cache(list_packages)
    users = {shape.meshname: shape.parent.name for shape in reversed(spec.geoms) if shape.meshname}
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        link = f"a mesh of the link {users[mesh.name]}" if mesh.name in users else "a mesh"
        trouble = "is missing"
        try:
            file = _mesh_file(spec, mesh, path, packages)
            trouble = "cannot be used"
            corners = read_shape(file)
        except UserError as error:
            if _drop_unless_it_collides(spec, mesh):
                continue
            raise UserError(f"{link} {trouble}: {error}") from error
        mesh.file = ""
        if corners is not None:
            mesh.uservert = corners.ravel()
            continue
        # As bytes, because MuJoCo caches files by the second in which they were changed
        mesh.file = f"{len(spec.assets)}{file.suffix}"
        spec.assets = {**spec.assets, str(Path(spec.meshdir) / mesh.file): file.read_bytes()}


def _drop_unless_it_collides(spec: mujoco.MjSpec, mesh: mujoco.MjsMesh) -> bool:
    """Leave out a mesh that is only seen; False if a collision shape has it."""
    users = [shape for shape in spec.geoms if shape.meshname == mesh.name]
    if any(shape.contype or shape.conaffinity for shape in users):
        return False
    for shape in users:
        _replace(shape)
    spec.delete(mesh)
    return True


def _mesh_file(
    spec: mujoco.MjSpec, mesh: mujoco.MjsMesh, path: Path, packages: Callable[[], Packages]
) -> Path:
    """Where a mesh is; raises the errors of `find_file`."""
    wanted = mesh.file if "://" in mesh.file else str(Path(spec.meshdir) / mesh.file)
    return find_file(wanted, path, packages)


def _line(error: Exception) -> str:
    """The text of an error in one line."""
    return " ".join(str(error).removeprefix("Error: ").split())
