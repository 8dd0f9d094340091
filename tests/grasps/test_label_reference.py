"""All labels of three objects against a slow reference that shares no code with them."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from egad.geometry.rays import RayCaster
from egad.grasps import SPREAD, GraspLabel
from egad.grasps.labels import rate_grasps, sample_for_labels, statistics_row
from egad.grasps.parameters import LabelParameters
from egad.grippers import BoxBody
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(), LabelParameters, gripper="yumi").model_copy(
    update={"grasp_label": GraspLabel(grasps=10)}
)
HAND = SETTINGS.gripper


def lump():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.02)
    x, y, z = ball.vertices.T * 200
    return trimesh.Trimesh(
        ball.vertices * (1 + 0.2 * np.sin(x) * np.cos(y + z))[:, None], ball.faces
    )


OBJECTS = {
    "cylinder": trimesh.creation.cylinder(0.018, 0.07, sections=32),
    "torus": trimesh.creation.torus(0.03, 0.01, major_sections=32, minor_sections=16),
    "lump": lump(),
}


@pytest.fixture(params=OBJECTS)
def labelled(request):
    mesh = OBJECTS[request.param]
    caster = RayCaster(mesh)
    rng = np.random.default_rng(7)
    grasps, statistics = sample_for_labels(caster, SETTINGS, rng)
    state = rng.bit_generator.state
    frame = rate_grasps(caster, mesh.center_mass, grasps, SETTINGS, rng, BoxBody(SETTINGS.gripper))
    again = np.random.default_rng()
    again.bit_generator.state = state
    return mesh, frame, statistics, again


def vectors(frame, name):
    return frame[[f"{name}_{part}" for part in "xyz"]].to_numpy(copy=True)


def first_hit(mesh, origin, direction):
    """Distance along a ray to the first triangle (Moller and Trumbore), and its normal."""
    corner, first, second = np.moveaxis(mesh.triangles, 1, 0)
    first, second = first - corner, second - corner
    across = np.cross(direction, second)
    facing = np.einsum("nk,nk->n", first, across)
    away = origin - corner
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("nk,nk->n", away, across) / facing
        turned = np.cross(away, first)
        v = turned @ direction / facing
        distance = np.einsum("nk,nk->n", second, turned) / facing
    slack = 1e-9
    hit = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & (distance > 0)
    if not hit.any():
        return np.inf, np.zeros(3)
    face = np.flatnonzero(hit)[distance[hit].argmin()]
    return distance[face], mesh.face_normals[face]


def quality(points, normals, axis, com, friction, scaling):
    """Ferrari-Canny by the whole hull of the wrenches, one contact after the other."""
    rows = []
    for point, normal, closing in zip(points, normals, (axis, -axis), strict=True):
        pressure = -normal @ closing
        if pressure < 1 / np.sqrt(1 + friction**2):
            return 0.0
        helper = np.array([1.0, 0, 0]) if abs(normal[0]) < 1 - 1e-9 else np.array([0, 1.0, 0])
        tangent = helper - helper @ normal * normal
        tangent /= np.linalg.norm(tangent)
        for angle in np.arange(8) * np.pi / 4:
            lean = np.cos(angle) * tangent + np.sin(angle) * np.cross(normal, tangent)
            force = pressure * (friction * lean - normal)
            rows.append([*force, *(scaling * np.cross(point - com, force))])
        twist = np.pi * SETTINGS.quality.finger_radius**2 * friction * scaling * pressure * normal
        rows += [[0, 0, 0, *twist], [0, 0, 0, *-twist]]
    try:
        return max(-ConvexHull(rows).equations[:, -1].max(), 0.0)
    except QhullError:
        return 0.0


def test_contacts_and_quality_equal_the_reference(labelled):
    mesh, frame, statistics, _ = labelled
    axes, points = vectors(frame, "axis"), [vectors(frame, f"contact{i}") for i in (0, 1)]
    normals = [vectors(frame, f"normal{i}") for i in (0, 1)]
    for i, row in frame.iterrows():
        for side, sign in ((0, 1), (1, -1)):
            start = vectors(frame, "center")[i] - sign * HAND.opening / 2 * axes[i]
            distance, normal = first_hit(mesh, start, sign * axes[i])
            np.testing.assert_allclose(
                start + sign * distance * axes[i], points[side][i], atol=1e-8
            )
            np.testing.assert_allclose(normal, normals[side][i], atol=1e-6)
        pair = ([each[i] for each in points], [each[i] for each in normals])
        expected = quality(*pair, axes[i], mesh.center_mass, 0.5, 100)
        assert row["quality"] == pytest.approx(expected, rel=1e-6, abs=1e-9)
    row = statistics_row(10, statistics, frame)
    causes = ["n_too_wide", "n_not_antipodal", "n_blocked", "n_too_close", "n_surplus", "n_grasps"]
    assert sum(row[cause] for cause in causes) == row["n_candidates"] == 200
    assert row["n_grasps"] == len(frame) == 10
    assert row["n_slipping"] == (frame["quality"] == 0).sum()


def test_robust_quality_equals_the_reference(labelled):
    """The object moves, not the hand, and every copy is computed by itself."""
    mesh, frame, _, rng = labelled
    noise, samples = SPREAD, SETTINGS.robust.samples
    shape = (len(frame) * samples, 3)
    hand_shift = rng.normal(0, noise.grasp_translation_sigma, shape)
    hand_turn = rng.normal(0, noise.grasp_rotation_sigma, shape)
    shift = rng.normal(0, noise.object_translation_sigma, shape)
    turn = rng.normal(0, noise.object_rotation_sigma, shape)
    com_shift = rng.normal(0, noise.com_sigma, shape)
    friction = np.maximum(rng.normal(0.5, noise.friction_sigma, len(shift)), 0)
    center, axes, com = vectors(frame, "center"), vectors(frame, "axis"), mesh.center_mass
    values = np.zeros(shape[0])
    for copy in range(shape[0]):
        grasp = copy // samples
        rotation = Rotation.from_rotvec(turn[copy])
        moved = mesh.copy()
        moved.vertices = rotation.apply(mesh.vertices - com) + com + shift[copy]
        axis = Rotation.from_rotvec(hand_turn[copy]).apply(axes[grasp])
        middle = center[grasp] + hand_shift[copy]
        points, normals = [], []
        for closing in (axis, -axis):
            start = middle - HAND.opening / 2 * closing
            distance, normal = first_hit(moved, start, closing)
            if distance <= HAND.opening and normal @ closing < 0:
                points.append(start + distance * closing)
                normals.append(normal)
        if len(points) == 2:
            mass = com + shift[copy] + rotation.apply(com_shift[copy])
            values[copy] = quality_turned(points, normals, axis, mass, friction[copy], rotation)
    table = values.reshape(len(frame), samples)
    np.testing.assert_allclose(frame["robust_quality"], table.mean(axis=1), rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(frame["robust_quality_std"], table.std(axis=1), rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(frame["robust_success_rate"], (table > 0).mean(axis=1))


def quality_turned(points, normals, axis, com, friction, rotation):
    """The quality in the frame of the object: there the edges of a friction cone start."""
    back = rotation.inv().apply
    return quality(back(points), back(normals), back(axis), back(com), friction, 1000)
