"""Files of collision shapes: find them, and read those that MuJoCo does not read."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import numpy as np
import trimesh
from collada.common import DaeError
from scipy.spatial import ConvexHull, QhullError
from trimesh.units import unit_conversion

from egad._util.arrays import Floats
from egad.errors import RejectedError, UserError
from egad.io import count_binary_faces, read_content

Packages = Mapping[str, Sequence[Path]]  # folders by names

PACKAGE = ("package://", "model://")
STL_FACES = 200_000  # at most, of a file that MuJoCo reads


def list_packages() -> Packages:
    """ROS packages below ROS_PACKAGE_PATH by their names and folders; links are followed once."""
    packages: dict[str, list[Path]] = {}
    entered: set[str] = set()
    for root in _listed("ROS_PACKAGE_PATH"):
        for found, folders, files in os.walk(root, followlinks=True):
            real = os.path.realpath(found)
            if "package.xml" in files or "manifest.xml" in files:
                for name in {Path(found).name, _package_name(Path(found))} - {None}:
                    packages.setdefault(str(name), []).append(Path(found))
                folders.clear()  # packages are not nested
            elif real in entered:
                folders.clear()
            else:
                folders[:] = sorted(each for each in folders if not each.startswith("."))
            entered.add(real)
    return packages


def find_file(wanted: str, path: Path, packages: Callable[[], Packages] = list_packages) -> Path:
    """The path of a file or package that a description names; `UserError` says where it looked."""
    folder = path.resolve().parent
    scheme = next((each for each in PACKAGE if wanted.startswith(each)), None)
    if scheme is None:
        local = unquote(urlparse(wanted).path) if wanted.startswith("file://") else wanted
        place = folder / local
        if place.is_file():
            return place.resolve()
        raise UserError(f"{wanted} (looked for {place})")
    package, _, rest = unquote(wanted.removeprefix(scheme)).partition("/")
    rest, looked = rest.lstrip("/"), list[Path]()
    for place in _packages(package, folder, packages):
        if (place / rest).is_file():
            return (place / rest).resolve()
        looked.append(place / rest)
    if looked:
        raise UserError(f"{wanted} (looked for {looked[0]})")
    raise UserError(
        f"{wanted} (the package {package} is in none of the folders above the file, nor in those "
        "of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH)"
    )


def _packages(name: str, folder: Path, packages: Callable[[], Packages]) -> Iterator[Path]:
    """The folders that may be a package, the nearest ones first."""
    for above in (folder, *folder.parents):
        if above.name == name or _package_name(above) == name:
            yield above
        if (above / name).is_dir():
            yield above / name
    yield from packages().get(name, [])
    for root in _listed("AMENT_PREFIX_PATH"):
        if (root / "share" / name).is_dir():
            yield root / "share" / name


def _listed(variable: str) -> list[Path]:
    """The folders that an environment variable lists."""
    return [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each]


def _package_name(folder: Path) -> str | None:
    """Name of the ROS package in a folder; None if there is none."""
    try:
        root = ElementTree.parse(folder / "package.xml")  # noqa: S314 (expat limits entities)
    except (OSError, ElementTree.ParseError):
        return None
    return root.findtext("name", "").strip() or None


def read_shape(path: Path) -> Floats | None:
    """Hull corners (n, 3) of a shape, in the unit of its file; None if MuJoCo reads it itself."""
    ending = path.suffix[1:].lower()
    # MuJoCo reads OBJ, its own MSH, and binary STL of the length it states and not too many faces
    regular = ending == "stl" and 0 < (count_binary_faces(path) or 0) <= STL_FACES
    if ending in ("obj", "msh") or regular:
        return None
    if ending not in ("stl", "ply", "off", "dae", "glb", "gltf"):
        raise UserError(
            f"{path} is not STL, OBJ, PLY, OFF, glTF or Collada (DAE); convert it to STL"
        )
    points = _collada_points(path) if ending == "dae" else _points(path)
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError) as error:
        raise UserError(f"{path} is flat or damaged; a shape needs a volume") from error


def _points(path: Path) -> Floats:
    try:
        points = read_content(path).vertices
    except RejectedError as reason:
        raise UserError(f"{path}: {reason}") from reason
    if path.suffix.lower() in (".glb", ".gltf"):  # y is up in these files, and was made z
        points = points[:, [0, 2, 1]] * [1, 1, -1]
    return np.unique(points, axis=0)


def _collada_points(path: Path) -> Floats:
    advice = "convert it to STL or OBJ"
    try:
        scene = trimesh.load_scene(path, file_type="dae", process=False, ignore_broken=False)
        points = np.asarray(scene.to_mesh().vertices)
    except DaeError as error:
        reason = error.msg.partition(" (<string>")[0]
        raise UserError(f"{path} is not readable as Collada: {reason}; {advice}") from error
    except Exception as error:  # of a damaged file; anything may be raised
        raise UserError(f"{path} is damaged or has no Collada scene; {advice}") from error
    if not len(points):
        raise UserError(f"{path} is a Collada file without faces in its scene; {advice}")
    return np.unique(points * unit_conversion(scene.units or "meters", "meters"), axis=0)
