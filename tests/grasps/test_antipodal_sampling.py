from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.geometry.rays import RayCaster
from egad.grasps import ContactPairs, Sampling, SamplingStatistics, sample_contacts
from egad.grasps.antipodal import _keep_apart, approach_directions
from egad.grasps.quality import ferrari_canny
from egad.measures.percentile import percentile

REFERENCE = np.load(Path(__file__).parents[1] / "data" / "ferrari_canny.npz")
OPENING = 0.05


def draw(mesh, count=100, seed=0, clearance=0.1, **rules):
    caster, rng = RayCaster(mesh), np.random.default_rng(seed)
    return sample_contacts(caster, OPENING, count, Sampling(**rules), rng, clearance=clearance)


@pytest.fixture
def one_round(monkeypatch):
    monkeypatch.setattr("egad.grasps.antipodal.ROUNDS", 1)


def box(*sides):
    return trimesh.creation.box(sides)


def union(*meshes):
    return trimesh.boolean.union(meshes, engine="manifold")


def block(low, high):
    return trimesh.creation.box(bounds=[low, high])


def ell():
    return union(
        block([-0.02, -0.06, -0.06], [0.02, 0.06, -0.02]),
        block([-0.02, -0.06, -0.06], [0.02, -0.02, 0.06]),
    )


def analytic_shape(name, half):
    if name == "ell":
        return ell()
    if name.startswith("cyl"):
        return trimesh.creation.cylinder(half[0], 2 * half[2], sections=128)
    if name.startswith(("sphere", "ellipsoid")):
        ball = trimesh.creation.icosphere(subdivisions=4)
        return trimesh.Trimesh(ball.vertices * half, ball.faces, process=False)
    return box(*(2 * np.asarray(half)))


def test_grasps_keep_all_rules():
    mesh = ell()
    grasps, _ = draw(mesh)
    assert len(grasps) == 100
    assert grasps.widths.max() <= OPENING
    np.testing.assert_allclose(np.linalg.norm(grasps.axes, axis=1), 1)
    span = grasps.points[:, 1] - grasps.points[:, 0]
    np.testing.assert_allclose(span, grasps.widths[:, None] * grasps.axes, atol=1e-12)
    np.testing.assert_allclose(grasps.centers, grasps.points.mean(axis=1))
    for c, sign in enumerate((-1, 1)):
        cosine = sign * np.einsum("nk,nk->n", grasps.normals[:, c], grasps.axes)
        assert np.tan(np.arccos(np.minimum(cosine, 1))).max() <= 0.75 + 1e-9
        _, distance, face = trimesh.proximity.closest_point_naive(mesh, grasps.points[:, c])
        assert distance.max() < 1e-9
        agreement = np.einsum("nk,nk->n", mesh.face_normals[face], grasps.normals[:, c])
        assert np.median(agreement) == pytest.approx(1)


def test_grasps_are_spread():
    grasps, _ = draw(box(0.04, 0.04, 0.04), spacing=0.004)
    apart = np.linalg.norm(grasps.centers[:, None] - grasps.centers, axis=2)
    turn = np.arccos(np.minimum(np.abs(grasps.axes @ grasps.axes.T), 1))
    distance = apart + 0.05 * 2 / np.pi * turn
    assert distance[~np.eye(len(grasps), dtype=bool)].min() >= 0.004


def test_a_grasp_with_its_fingers_exchanged_is_the_same_grasp():
    grasps, _ = draw(box(0.04, 0.04, 0.04), spacing=0.004)
    turned = ContactPairs(grasps.points[:, ::-1], grasps.normals[:, ::-1], -grasps.axes)
    assert len(_keep_apart(grasps, turned, 0.004)) == 0


def test_open_fingers_reach_the_contacts():
    mesh = ell()
    caster = RayCaster(mesh)
    grasps, _ = draw(mesh)
    away = -approach_directions(grasps.axes)
    for c, sign in enumerate((-1, 1)):
        start = grasps.centers + sign * OPENING / 2 * grasps.axes
        hits = caster.first_hits(start, -sign * grasps.axes)
        reached = start - sign * hits.distances[:, None] * grasps.axes
        np.testing.assert_allclose(reached, grasps.points[:, c], atol=1e-9)
        assert hits.entering.all()
        assert not caster.obstructed(start, away, 0.1).any()


def test_walls_block_the_fingers():
    # a plate between two walls that leave no room for the fingers
    wall = box(0.002, 0.1, 0.1)
    walls = [wall.copy().apply_translation([x, 0, 0]) for x in (-0.02, 0, 0.02)]
    floor = box(0.042, 0.1, 0.002).apply_translation([0, 0, -0.05])
    grasps, statistics = draw(union(*walls, floor), clearance=0)
    across = np.abs(grasps.axes[:, 0]) > 0.75
    outer = np.abs(grasps.points[..., 0]).max(axis=1)
    assert across.any()
    np.testing.assert_allclose(outer[across], 0.021, atol=1e-9)
    assert statistics.blocked > 0


def test_wide_objects_have_no_grasp_and_say_why():
    grasps, statistics = draw(box(0.06, 0.06, 0.06))
    assert len(grasps) == 0
    assert statistics.candidates == 2000
    # rays from face to neighboring face may be short, but are not antipodal
    assert statistics.too_wide + statistics.not_antipodal == 2000
    assert statistics.too_wide > statistics.not_antipodal
    assert str(statistics).startswith(f"of 2000 candidates: {statistics.too_wide} too wide, ")


@pytest.mark.usefixtures("one_round")
def test_tally_counts_every_candidate_once():
    grasps, statistics = draw(ell(), count=10_000)
    failed = (
        statistics.too_wide + statistics.not_antipodal + statistics.blocked + statistics.too_close
    )
    assert statistics.candidates == 20_000
    assert failed + len(grasps) == statistics.candidates
    assert (
        min(statistics.too_wide, statistics.not_antipodal, statistics.blocked, statistics.too_close)
        > 0
    )
    assert statistics + statistics == SamplingStatistics(
        *(2 * value for value in vars(statistics).values())
    )


def test_first_contacts_are_uniform_over_the_surface():
    # every first contact on a ball of half the opening gives a grasp
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.01)
    grasps, _ = draw(ball, count=2000, cone=0.1, spacing=0, clearance=0)
    first = grasps.points[:, 0] / 0.01
    assert len(grasps) == 2000
    # heights on a sphere are uniform over [-1, 1]
    shares, _ = np.histogram(first[:, 2], bins=5, range=(-1, 1))
    np.testing.assert_allclose(shares / 2000, 0.2, atol=0.04)
    lean = np.tan(np.arccos(-np.einsum("nk,nk->n", grasps.normals[:, 0], grasps.axes)))
    assert np.median(lean) == pytest.approx(0.05, abs=0.005)


def test_same_seed_gives_the_same_grasps_and_another_gives_others():
    mesh = ell()
    first, again, other = draw(mesh)[0], draw(mesh)[0], draw(mesh, seed=1)[0]
    np.testing.assert_array_equal(first.points, again.points)
    assert not np.array_equal(first.points, other.points)


def test_quality_percentiles_agree_with_dex_net_on_analytic_shapes():
    near = []
    for name, half, theirs in zip(
        REFERENCE["shapes"], REFERENCE["half"], REFERENCE["q75"], strict=True
    ):
        mesh = analytic_shape(name, half)
        com = REFERENCE["com"][REFERENCE["shape"] == name][0]
        np.testing.assert_allclose(mesh.center_mass, com, atol=1e-9)
        values = []
        for seed in range(10):
            grasps, _ = draw(mesh, seed=seed)
            quality = ferrari_canny(grasps.points, grasps.normals, grasps.axes, com)
            values.append(percentile(quality, 75))
        near.append(abs(np.mean(values) - theirs.mean()) <= 0.0003)
    assert len(near) == 8
    assert sum(near) >= 7
