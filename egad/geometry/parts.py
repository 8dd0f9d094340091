"""Convex parts by cuts or by CoACD, kept in a cache, and a warning for those beyond the bounds."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.child_process import Worker, WorkerDiedError, WorkerTimeoutError
from egad._util.extras import check_installed
from egad._util.parameters import from_arguments
from egad._util.progress import phase_if_slow
from egad._util.result_cache import Arrays, cached, source_version
from egad.errors import RejectedError
from egad.geometry.checks import check_units, warn_user
from egad.geometry.convex_parts import Decomposition, decompose, union_of_parts
from egad.geometry.distance import largest_deviation
from egad.geometry.hulls import fewer_vertices, hull_mesh, hull_of
from egad.geometry.manifold import to_mesh, to_solid, wind_outwards
from egad.geometry.parameters import DEVIATION, MAX_PARTS, MAX_VERTICES, VOLUME_ERROR, Bundle
from egad.geometry.touchable import MAX_BURIED, buried_share

CODE = ("geometry", "random.py")
LIBRARIES = ("numpy", "scipy", "manifold3d", "embreex", "libigl", "trimesh", "numba", "coacd")
COACD_THRESHOLD = 0.05  # largest concavity of a part
TIME_LIMIT = 1800  # seconds; it takes minutes at most
Task = tuple[Floats, Ints, int]


class PartsWarning(UserWarning):
    """Convex parts are farther from their object than the bounds allow."""


class Closeness(NamedTuple):
    """How far convex parts are from their object."""

    volume_error: float  # volume of the union of the parts / volume of the object - 1
    deviation: float  # largest distance by which the parts protrude from its surface, metres
    buried: float  # share of the touchable surface that lies deeper in a part than allowed

    def is_within(self, settings: Bundle) -> bool:
        """Whether the parts are as close to the object as the settings require."""
        return abs(self.volume_error) <= settings.volume_error and self.buried <= MAX_BURIED


@phase_if_slow("decomposing a mesh into convex parts")
def convex_parts(
    mesh: trimesh.Trimesh,
    *,
    max_parts: int = MAX_PARTS,
    volume_error: float = VOLUME_ERROR,
    deviation: float = DEVIATION,
    max_vertices: int = MAX_VERTICES,
) -> list[trimesh.Trimesh]:
    """Convex meshes that together approximate a solid, for physics engines.

    Args:
        mesh: A closed surface, metres.
        max_parts: The largest number of parts. If it is not enough, volume error and deviation grow
            by the same factor until it is.
        volume_error: The parts may exceed the solid by this fraction of its volume.
        deviation: About 99 % of the surface that fingers can touch lies no deeper than this in a
            part, metres.
        max_vertices: The largest number of vertices of a part.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
        UserError: A number is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
        PartsWarning: `max_parts` is not enough; the text has the bounds that the parts keep.
    """
    check_units(mesh)
    wanted = from_arguments(
        Bundle,
        max_parts=max_parts,
        volume_error=volume_error,
        deviation=deviation,
        max_vertices=max_vertices,
    )
    solid = wind_outwards(mesh)
    found = make_parts(solid, wanted)
    if found.deviation > wanted.deviation:
        errors = measure_parts(solid, found.parts, wanted)
        warn_if_beyond("the mesh", False, errors.volume_error, found.deviation)
    return found.parts


def make_parts(mesh: trimesh.Trimesh, settings: Bundle) -> Decomposition:
    """Convex parts of a solid, metres, maybe from the cache; `RejectedError` if it has none."""
    arrays = _cached("convex-parts", mesh, settings, lambda: _packed(_made(mesh, settings)))
    ends: Ints = np.cumsum(arrays["counts"], axis=0)[:-1]
    corners = np.split(arrays["vertices"], ends[:, 0])
    faces = np.split(arrays["faces"], ends[:, 1])
    parts = [trimesh.Trimesh(*each, process=False) for each in zip(corners, faces, strict=True)]
    deviation, volume_error = arrays["bounds"].tolist()
    return Decomposition(parts, deviation, volume_error)


def measure_parts(
    mesh: trimesh.Trimesh, parts: Sequence[trimesh.Trimesh], settings: Bundle
) -> Closeness:
    """How close the parts of `make_parts` are to their object, from the cache if known."""

    def measured() -> Arrays:
        solid, together = to_solid(mesh.vertices, mesh.faces), union_of_parts(parts)
        beyond = together - solid  # parts meet inside, with fine cracks
        found = Closeness(
            volume_error=float(together.volume()) / float(solid.volume()) - 1,
            deviation=0.0 if beyond.is_empty() else largest_deviation(to_mesh(beyond), mesh),
            buried=buried_share(mesh, parts, settings.deviation),
        )
        return {"closeness": np.array(found)}

    return Closeness(*_cached("part-errors", mesh, settings, measured)["closeness"].tolist())


def _cached(
    kind: str, mesh: trimesh.Trimesh, settings: Bundle, make: Callable[[], Arrays]
) -> Arrays:
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    given = [vertices, faces, *settings.model_dump(exclude={"friction"}).values()]
    return cached(kind, given, source_version(CODE, LIBRARIES), make)


def warn_if_beyond(name: str, within: bool, volume_error: float, bound: float) -> None:
    """Warn if convex parts are farther from their object than the requested bounds allow."""
    if within:
        return
    depth = "" if np.isnan(bound) else f" and their deviation {1000 * bound:.2g} mm"
    warn_user(
        f"the convex parts of {name} exceed the requested bounds: their volume error is "
        f"{volume_error:.1%}{depth}; allow more parts or larger bounds",
        PartsWarning,
    )


def _made(mesh: trimesh.Trimesh, settings: Bundle) -> Decomposition:
    if settings.method == "coacd":
        parts = coacd_parts(mesh, settings.max_parts, settings.max_vertices)
        return Decomposition(parts, np.nan, np.nan)
    return decompose(
        mesh, settings.max_parts, settings.volume_error, settings.deviation, settings.max_vertices
    )


def _packed(found: Decomposition) -> Arrays:
    return {
        "vertices": np.concatenate([part.vertices for part in found.parts]),
        "faces": np.concatenate([part.faces for part in found.parts]),
        "counts": np.array([[len(part.vertices), len(part.faces)] for part in found.parts]),
        "bounds": np.array([found.deviation, found.volume_error]),
    }


def coacd_parts(mesh: trimesh.Trimesh, max_parts: int, max_vertices: int) -> list[trimesh.Trimesh]:
    """Convex hulls of a solid by CoACD, seed 0 (Wei et al. 2022); `RejectedError` if it fails.

    It runs in a separate process because it sometimes aborts its process.
    """
    check_installed("coacd", "bundle.method: coacd")
    task = (np.array(mesh.vertices), np.array(mesh.faces), max_parts)
    try:
        with Worker(_coacd, TIME_LIMIT, name="CoACD") as run:
            parts: list[Floats] = run(task)
    except (WorkerDiedError, WorkerTimeoutError) as error:
        raise RejectedError(str(error)) from error
    hulls = [hull for hull in map(hull_of, parts) if hull.volume > 0]
    solid = [hull_mesh(fewer_vertices(hull, max_vertices, 0.0, 0.0)[0]) for hull in hulls]
    if not solid:
        raise RejectedError("CoACD found no part with a volume")
    return solid


@contextmanager
def _coacd() -> Iterator[Callable[[Task], list[Floats]]]:
    """Run CoACD in this process and discard its output: it prints a lot."""
    import coacd  # noqa: PLC0415 (an extra)

    silence = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(silence, stream)
    coacd.set_log_level("error")

    def run(task: Task) -> list[Floats]:
        vertices, faces, max_parts = task
        mesh = coacd.Mesh(vertices, faces)
        options = {"threshold": COACD_THRESHOLD, "max_convex_hull": max_parts}
        try:
            found = coacd.run_coacd(mesh, preprocess_mode="off", seed=0, **options)
        except Exception as error:
            raise RejectedError(f"CoACD failed: {error}") from error
        return [np.asarray(vertices) for vertices, _ in found]

    yield run
