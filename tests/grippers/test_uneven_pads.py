"""Fingers with holes, windows, ribs and grooves open as far as plain ones of their outline.

The face towards the other finger is the plane x = 0, or the foremost points lie in it.
"""

import re

import manifold3d
import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from egad.geometry import to_mesh
from egad.grippers import Gripper
from egad.grippers.reading import read_model
from egad.report.hand import hand_doubts, hand_facts

LENGTH, THICK, WIDE = 90.0, 24.0, 20.0  # mm: along z, x and y
STROKE = 0.035  # metres, of each parallel finger
TURN = 1.0  # radians, of a jaw about (HINGE, 0, 0) mm
HINGE = 30.0


def hull(corners):
    mesh = trimesh.convex.convex_hull(np.array(corners, dtype=float))
    return manifold3d.Manifold(
        manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
    )


def along_y(corners, half=WIDE / 2):
    return hull([(x, y, z) for y in (-half, half) for x, z in corners])


def along_z(corners):
    return hull([(x, y, z) for z in (-5, LENGTH + 5) for x, y in corners])


def box(low, high):
    return manifold3d.Manifold.cube(tuple(np.subtract(high, low))).translate(low)


def union(parts):
    return manifold3d.Manifold.batch_boolean(list(parts), manifold3d.OpType.Add)


SOLID = along_y([(0, 0), (THICK, 0), (3, LENGTH), (0, LENGTH)])


def hole(y, z, radius):
    drill = manifold3d.Manifold.cylinder(60, radius, radius, 16).rotate((0, 90, 0))
    return drill.translate((-10, y, z))


def fin_ray():
    """A front wall, a back and slanted ribs, as overlapping bodies of one mesh."""
    ribs = [((1, z), (THICK - 21 * (z + 5) / LENGTH, z + 5)) for z in range(10, 82, 9)]
    bars = [((THICK - 1, 0), (2, LENGTH)), *ribs]
    return [
        along_y([(0, 0), (2, 0), (2, LENGTH), (0, LENGTH)]),
        along_y([(0, 0), (THICK, 0), (THICK, 4), (0, 4)]),
        *(along_y([(x, z + s) for x, z in bar for s in (-0.7, 0.7)]) for bar in bars),
    ]


def vee(degrees):
    depth = np.tan(np.radians(degrees)) * WIDE / 2
    return SOLID - along_z([(-1e-3, -WIDE / 2), (-1e-3, WIDE / 2), (depth, 0)])


FINGERS = {
    "screw hole": [SOLID - hole(0, 70.75, 2)],
    "window": [SOLID - box((-10, -6, 60), (60, 6, 80))],
    "fin-ray": fin_ray(),
    "V of 30 degrees": [vee(30)],
    "flutes": [SOLID - union(box((-1, y, -1), (0.9, y + 2, 91)) for y in range(-9, 9, 3))],
}


def hand(folder, bodies, joints):
    """A URDF with a finger of some bodies on each side of a palm."""
    mesh = trimesh.util.concatenate([to_mesh(body) for body in bodies])
    mesh.apply_scale(0.001).export(folder / "finger.stl")
    mesh.apply_transform(np.diag([-1.0, 1, 1, 1])).export(folder / "mirrored.stl")
    path = folder / "hand.urdf"
    path.write_text(f'<robot name="hand">{joints}</robot>')
    return path


def link(name, file, x=0.0, more=""):
    return f"""<link name="{name}"><collision><origin xyz="{x} 0 0"/><geometry>
      <mesh filename="{file}.stl"/></geometry></collision>{more}</link>"""


def joint(name, child, kind, limit, axis, x=0.0, more=""):
    return f"""<joint name="{name}" type="{kind}"><parent link="palm"/><child link="{child}"/>
      <origin xyz="{x} 0 0"/><axis xyz="{axis}"/>
      <limit lower="0" upper="{limit}" effort="9" velocity="1"/>{more}</joint>"""


PALM = """<collision><origin xyz="0 0 -0.01"/><geometry><box size="0.08 0.03 0.02"/></geometry>
  </collision>"""


def parallel(folder, bodies):
    fingers = link("l", "finger") + link("r", "mirrored")
    joints = joint("jl", "l", "prismatic", STROKE, "1 0 0")
    joints += joint("jr", "r", "prismatic", STROKE, "-1 0 0", more='<mimic joint="jl"/>')
    return read_model(hand(folder, bodies, f'<link name="palm">{PALM}</link>{fingers}{joints}'))


def one_jaw(folder, bodies, kind, limit, axis):
    fingers = link("palm", "mirrored", more=PALM) + link("jaw", "finger", -HINGE / 1000)
    joints = joint("j", "jaw", kind, limit, axis, HINGE / 1000)
    found = read_model(hand(folder, bodies, fingers + joints))
    assert found.openings[0] >= -1e-4
    return found


@pytest.mark.parametrize("kind", FINGERS)
def test_parallel_fingers_open_as_far_as_they_slide(tmp_path, kind):
    found = parallel(tmp_path, FINGERS[kind])
    tolerance = 5e-4 if kind == "fin-ray" else 1e-4
    assert found.openings[[0, -1]] == pytest.approx([0, 2 * STROKE], abs=tolerance)
    np.testing.assert_allclose(found.palm_to_hand[:3, 0], [1, 0, 0], atol=1e-9)
    pad = 1000 * np.ptp(found.pad, axis=0)
    assert pad[1] == pytest.approx(WIDE, abs=0.1)
    assert pad[2] == pytest.approx(LENGTH, abs=0.5)


@pytest.mark.parametrize("kind", FINGERS)
def test_a_jaw_that_slides_opens_as_far_as_it_slides(tmp_path, kind):
    found = one_jaw(tmp_path, FINGERS[kind], "prismatic", STROKE, "1 0 0")
    assert found.openings[[0, -1]] == pytest.approx([0, STROKE], abs=1e-4)
    np.testing.assert_allclose(found.palm_to_hand[:3, 0], [1, 0, 0], atol=1e-9)
    assert 1000 * np.ptp(found.pad, axis=0)[2] == pytest.approx(LENGTH, abs=1)


@pytest.mark.parametrize("kind", FINGERS)
def test_a_jaw_that_turns_opens_by_the_angle_at_its_pads(tmp_path, kind):
    """The plane of its foremost points turns about the hinge, and is closed at 0."""
    found = one_jaw(tmp_path, FINGERS[kind], "revolute", TURN, "0 1 0")
    angle, z = found.positions[:, 0], found.palm_to_hand[2, 3]
    hinge = HINGE / 1000
    gaps = hinge - hinge / np.cos(angle) + z * np.tan(angle)
    np.testing.assert_allclose(found.openings, gaps, atol=2e-4)
    np.testing.assert_allclose(found.palm_to_hand[:3, 0], [1, 0, 0], atol=1e-9)
    if kind in ("screw hole", "window", "fin-ray"):
        assert 1000 * found.openings[-1] == pytest.approx(84.7, abs=0.5)
        assert 1000 * np.ptp(found.pad, axis=0)[2] == pytest.approx(38.5, abs=0.5)


def test_the_window_of_pads_is_said_to_be_open(tmp_path):
    model = parallel(tmp_path, FINGERS["window"])
    hand = Gripper.from_file(tmp_path / "hand.urdf")
    assert re.search(r"the pads; 1\d % of their faces is open$", hand_facts(hand, model)["opening"])
    assert hand_doubts(hand, model) == []


def test_the_groove_of_parallel_fingers_is_not_filled(tmp_path):
    """V-shaped, with its bottom in the middle; the hull of a finger would fill it."""
    bottom = np.tan(np.radians(30)) * WIDE / 2000
    x, in_groove = zip((0.2, True), (0.8, True), (1.2, False), strict=True)
    points = np.array([(part * bottom, 0.0, 0.05) for part in x])
    inside = np.zeros(3, dtype=bool)
    for corners in parallel(tmp_path, FINGERS["V of 30 degrees"]).links[1].shapes:
        planes = ConvexHull(corners).equations
        inside |= (points @ planes[:, :3].T + planes[:, 3] < 1e-4).all(axis=1)
    assert tuple(~inside) == in_groove


def test_opposite_pins_end_the_range_where_they_meet(tmp_path):
    """Three of 4 mm on each jaw: not closer than 8 mm, and nothing overlaps."""
    pins = [box((-4, -2, z), (1, 2, z + 4)) for z in (66, 74, 82)]
    found = one_jaw(tmp_path, [SOLID, *pins], "prismatic", STROKE, "1 0 0")
    assert found.openings[0] >= -1e-4
    assert found.openings[[0, -1]] == pytest.approx([0, STROKE - 0.008], abs=2e-4)
    assert found.positions[0, 0] == pytest.approx(0.008, abs=2e-4)
