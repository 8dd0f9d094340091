"""Convex parts: `python studies/convex_parts/convex_parts.py hollow` or `... evaluation-set`.

Prints for hollow and thin objects, with two allowed deviations each, the number of parts, the
volume of their union / volume of the object, the share of the touchable surface that is buried, and
CPU time; or a summary of the same figures for the 49 evaluation objects, scaled to `egad_75mm`.
"""

import sys
from itertools import pairwise
from time import process_time

import manifold3d
import numpy as np
import trimesh

from egad.geometry import Bundle, buried_share, to_mesh, union_of_parts
from egad.geometry.convex_parts import decompose
from egad.geometry.manifold import Solid, box, union
from egad.grippers import as_gripper
from egad.objects import load, named_meshes, scaled_solid

DEVIATIONS = (0.0005, 0.002)
BAR = 0.003  # metres, thickness of the bars of the basket


def cylinder(height: float, low: float, high: float, sections: int = 64) -> Solid:
    """A truncated cone with two radii."""
    return manifold3d.Manifold.cylinder(height, low, high, sections)


def ring(radius: float, tube: float) -> Solid:
    """A torus."""
    circle = manifold3d.CrossSection.circle(tube, 24).translate((radius, 0))
    return manifold3d.Manifold.revolve(circle, 48)


def mug(wall: float, sections: int) -> Solid:
    """A mug, 80 mm wide and 90 mm high."""
    inner = cylinder(0.09, 0.04 - wall, 0.04 - wall, sections).translate((0, 0, wall))
    core = cylinder(0.09, 0.04 - wall / 2, 0.04 - wall / 2, sections)
    handle = ring(0.025, 0.005).rotate((90, 0, 0)).translate((0.044, 0, 0.045))
    return (cylinder(0.09, 0.04, 0.04, sections) - inner) + (handle - core)


def bowl() -> Solid:
    """Half a ball of 120 mm with a wall of 4 mm."""
    ball = manifold3d.Manifold.sphere
    return (ball(0.06, 64) - ball(0.056, 64)).trim_by_plane((0, 0, -1), 0)


def bucket() -> Solid:
    """100 mm wide and high with a wall of 2.5 mm, and a bail of 4 mm."""
    inner = cylinder(0.1, 0.0375, 0.0475).translate((0, 0, 0.0025))
    arch = ring(0.05, 0.002).rotate((90, 0, 0)).translate((0, 0, 0.1))
    return (cylinder(0.1, 0.04, 0.05) - inner) + arch.trim_by_plane((0, 0, 1), 0.095)


def basket() -> Solid:
    """An open cube of 100 mm of bars, six a side and three around."""
    steps = np.linspace(-0.05, 0.05, 6).tolist()
    ends: list[tuple[tuple[float, float, float], ...]] = [
        ((x, -0.05, 0), (x, 0.05, 0)) for x in steps
    ]
    ends += [((-0.05, y, 0), (0.05, y, 0)) for y in steps]
    ends += [((x, y, 0), (x, y, 0.06)) for x in steps for y in (-0.05, 0.05)]
    ends += [((x, y, 0), (x, y, 0.06)) for x in (-0.05, 0.05) for y in steps]
    for z in (0.02, 0.04, 0.06):
        ends += [((-0.05, y, z), (0.05, y, z)) for y in (-0.05, 0.05)]
        ends += [((x, -0.05, z), (x, 0.05, z)) for x in (-0.05, 0.05)]
    return union(box(np.array(a) - BAR / 2, np.array(b) + BAR / 2) for a, b in ends)


def helix() -> Solid:
    """Six turns of 40 mm of a wire of 4 mm, 60 mm high."""
    angles = np.linspace(0, 12 * np.pi, 193)
    places = np.column_stack([0.02 * np.cos(angles), 0.02 * np.sin(angles), 0.005 * angles / np.pi])
    balls = [manifold3d.Manifold.sphere(0.002, 16).translate(tuple(place)) for place in places]
    return union(manifold3d.Manifold.batch_hull(pair) for pair in pairwise(balls))


def link() -> Solid:
    """A link of a chain: two half rings of a bar of 8 mm, 40 mm apart."""
    half = ring(0.015, 0.004).trim_by_plane((1, 0, 0), 0).translate((0.02, 0, 0))
    bar = manifold3d.Manifold.cylinder(0.04, 0.004, 0.004, 24, True).rotate((0, 90, 0))
    sides = [bar.translate((0, y, 0)) for y in (-0.015, 0.015)]
    return union([half, half.mirror((1, 0, 0)), *sides])


def box_with_lid() -> Solid:
    """Walls of 1 mm; the lid is 2 mm above the box, on a hinge."""

    def block(*corners: tuple[float, float, float]) -> Solid:
        return box(*map(np.array, corners))

    tray = block((0, 0, 0), (0.1, 0.06, 0.05)) - block((0.001, 0.001, 0.001), (0.099, 0.059, 0.06))
    lid = block((-0.002, -0.002, 0.052), (0.102, 0.062, 0.056))
    lid -= block((-0.0005, -0.0005, 0.05), (0.1005, 0.0605, 0.0545))
    return tray + lid + block((0.04, -0.0015, 0.045), (0.06, 0.0015, 0.055))


OBJECTS = {
    "mug, 64 sections": mug(0.004, 64),
    "mug, 256 sections": mug(0.004, 256),
    "bowl": bowl(),
    "bucket": bucket(),
    "wire basket": basket(),
    "helix": helix(),
    "chain link": link(),
    "box with lid": box_with_lid(),
}


def figures(mesh: trimesh.Trimesh, deviation: float) -> tuple[int, float, float, float]:
    """Number of the parts of an object, ratio of volumes, buried share, CPU time in seconds."""
    wanted = Bundle()
    start = process_time()
    parts = decompose(mesh, wanted.max_parts, wanted.volume_error, deviation).parts
    spent = process_time() - start
    ratio = union_of_parts(parts).volume() / mesh.volume
    return len(parts), ratio, buried_share(mesh, parts, deviation), spent


def hollow() -> None:
    """Print a row for each hollow object and deviation."""
    for name, solid in OBJECTS.items():
        for deviation in DEVIATIONS:
            count, ratio, buried, spent = figures(to_mesh(solid), deviation)
            print(
                f"{name}, {1000 * deviation} mm: {count} parts, {ratio:.3f} of the volume, "
                f"{buried:.2%} buried, {spent:.1f} s",
                flush=True,
            )


def evaluation_set() -> None:
    """Print the smallest, the median and the largest figures of the evaluation objects."""
    gripper = as_gripper("egad_75mm")
    meshes = [scaled_solid(each, gripper, "paper") for each in named_meshes(load("evaluation-set"))]
    found = np.array([figures(mesh, Bundle().deviation) for mesh in meshes])
    for name, values in zip(("parts", "ratio", "buried", "CPU s"), found.T, strict=True):
        print(
            f"{name}: from {values.min():.4g}, median {np.median(values):.4g}, "
            f"to {values.max():.4g}, in all {values.sum():.4g}"
        )


if __name__ == "__main__":
    decompose(trimesh.creation.torus(0.03, 0.01), 64, 0.06)  # compiles
    {"hollow": hollow, "evaluation-set": evaluation_set}[sys.argv[1]]()
