"""The functions of `import egad`, as a user calls them."""

import re
import subprocess
import sys

import igl
import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.errors import RejectedError, UserError
from egad.grasps.quality import ferrari_canny


@pytest.fixture(scope="module")
def mug():
    """A closed mesh that is neither convex nor symmetric, metres."""
    body = trimesh.creation.annulus(0.02, 0.025, 0.07)
    handle = trimesh.creation.box((0.03, 0.01, 0.04)).apply_translation((0.035, 0, 0.01))
    return trimesh.boolean.union([body, handle], engine="manifold")


@pytest.fixture(scope="module")
def grasps(mug):
    return egad.sample_grasps(mug, "panda", n=60, seed=3)


def test_importing_egad_loads_no_heavy_package():
    heavy = ("numpy", "pandas", "numba", "trimesh", "h5py", "snakemake")
    code = f"import sys, egad; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_can_be_imported_and_is_documented():
    for name in egad.__all__:
        assert getattr(egad, name).__doc__, name
    with pytest.raises(AttributeError, match="load_grips"):
        egad.load_grips  # noqa: B018


def test_a_released_object_has_the_measures_of_its_label():
    """Its label comes from an evaluation with other grasps, so it may lie in the next cell."""
    objects = egad.load("released")
    for label in ("E08_0", "M14_3", "U18_1"):
        found = egad.measure(objects[label].mesh)
        assert found.cell[0] == int(label[1:3])
        assert abs(found.cell[1] - "ABCDEFGHIJKLMNOPQRSTUVWXY".index(label[0])) <= 1
        assert found.label == f"{'ABCDEFGHIJKLMNOPQRSTUVWXY'[found.cell[1]]}{found.cell[0]:02}"


def test_complexity_is_that_of_the_shape_and_beside_it_that_of_the_triangles():
    parts = [trimesh.creation.box([60, 40, 30]), trimesh.creation.cylinder(10, 50, sections=32)]
    part = trimesh.boolean.union(parts, engine="manifold")
    meshes = part, part.subdivide().subdivide()
    coarse, fine = (egad.measure(mesh, max_candidates=512) for mesh in meshes)
    assert fine.complexity == pytest.approx(coarse.complexity, abs=0.16)
    assert fine.raw_complexity < coarse.raw_complexity - 0.5
    assert f"({fine.raw_complexity:.3f} by its triangles)" in repr(fine)


def test_a_suction_cup_has_no_cell(mug):
    found = egad.measure(mug, "cup_30mm", max_candidates=512)
    assert (found.cell, found.label, found.comparable) == (None, "", False)
    assert repr(found).startswith("Measures(no cell: complexity")
    assert "confidence" not in repr(found)


def test_measures_do_not_depend_on_the_unit_and_repeat(mug):
    """By a power of two nothing is rounded; elsewhere, other grasps may be sampled."""
    first = egad.measure(mug, max_candidates=512)
    large = egad.measure(mug.copy().apply_scale(1024), max_candidates=512)
    assert large[:3] == pytest.approx(first[:3])
    other = egad.measure(mug.copy().apply_scale(25.4), max_candidates=512)
    assert other.complexity == pytest.approx(first.complexity, abs=0.05)
    assert other.graspability == pytest.approx(first.graspability, abs=first.graspability_std)
    assert egad.measure(mug, max_candidates=512) == first
    assert egad.measure(mug, max_candidates=512, seed=1).graspability != first.graspability


def plate():
    """100 x 100 mm and 1 mm thick."""
    return trimesh.creation.box((0.1, 0.1, 0.001))


def test_a_mesh_is_measured_at_the_size_of_the_rule(mug):
    for rule in ("paper", "egad-script"):
        found = egad.measure(mug, "panda", rule=rule, max_candidates=512)
        assert found.factor == pytest.approx(egad.rescale(mug, "panda", rule)[1])
        assert found.rule == rule
    real = egad.measure(plate(), rule="none", max_candidates=512)
    assert (real.factor, real.sides) == (1, pytest.approx((0.001, 0.1, 0.1)))
    with pytest.warns(egad.ScaleWarning):
        large = egad.measure(plate(), max_candidates=512)
    assert (large.factor, large.sides) == (pytest.approx(40), pytest.approx((0.04, 4, 4)))
    assert (
        real.graspability > 5 * large.graspability
    )  # contacts on a plate of 4 m are far off center


def test_the_size_is_said_and_whether_cells_are_comparable(mug):
    found = egad.measure(mug, max_candidates=512)
    assert found.comparable
    assert found.label in repr(found)
    assert "(yumi, opening 50 mm)" in repr(found)
    assert "by the rule exact" in repr(found)
    assert "comparable" not in repr(found)
    for settings in ({"rule": "none"}, {"gripper": egad.Gripper(opening=0.1)}):
        other = egad.measure(mug, max_candidates=512, **settings)
        assert not other.comparable
        assert "not comparable with the map (exact, yumi)" in repr(other)
    assert egad.measure(mug, egad.Gripper(opening=0.05), max_candidates=512).comparable
    with pytest.raises(UserError, match="rule 'big' is not known"):
        egad.measure(mug, rule="big")


def test_a_mesh_that_is_enlarged_or_loses_bodies_is_named_once(recwarn):
    two = trimesh.util.concatenate([plate(), plate().apply_translation((0, 0, 0.1))])
    for mesh in (two, two.copy()):
        found = egad.measure(mesh, max_candidates=512)
    assert (found.dropped_bodies, found.dropped_volume) == (1, pytest.approx(0.5))
    assert "1 of 2 bodies was dropped, 50 % of the volume" in repr(found)
    categories = [each.category for each in recwarn.list]
    assert categories.count(egad.ScaleWarning) == categories.count(egad.DroppedBodiesWarning) >= 1
    assert {each.filename for each in recwarn.list} == {__file__}
    recwarn.clear()
    egad.measure(two, rule="none", max_candidates=512)
    egad.similarity(two, plate())
    assert {each.category for each in recwarn.list} == {egad.DroppedBodiesWarning}


def test_similarity_is_one_for_a_turned_copy_and_less_for_another_shape(mug):
    turned = mug.copy().apply_transform(trimesh.transformations.rotation_matrix(1, (1, 2, 3)))
    box = trimesh.creation.box((0.02, 0.03, 0.05))
    matrix = egad.similarity_matrix([mug, turned, box])
    assert matrix == pytest.approx(matrix.T)
    assert np.diag(matrix) == pytest.approx(1)
    assert matrix[0, 1] > 0.9 > matrix[0, 2]
    assert egad.similarity(mug, box) == matrix[0, 2]


def test_rescaling_makes_the_smallest_side_fit():
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    scaled, factor = egad.rescale(box, "panda", "exact")
    assert factor == pytest.approx(0.8 * 0.08 / 0.1)
    assert np.sort(scaled.extents) == pytest.approx(factor * np.array([0.1, 0.2, 0.3]))
    same, one = egad.rescale(box, egad.Gripper(opening=1.0))
    assert one == 1
    assert same.vertices == pytest.approx(box.vertices)
    for rule, hint in (
        ("papr", "did you mean paper"),
        ("best", "known: egad-script, exact, none, paper"),
    ):
        with pytest.raises(UserError, match=f"rule '{rule}' is not known; {hint}"):
            egad.rescale(box, "panda", rule)
    for wrong in (0, 3.5, "big", None, float("nan"), True, [0.8]):
        message = re.escape(f"side_fraction is {wrong!r}; allowed: a number, above 0, at most 3")
        with pytest.raises(UserError, match=message):
            egad.rescale(box, "panda", side_fraction=wrong)
    halved, factor = egad.rescale(box, "panda", "exact", side_fraction=np.float32(0.5))
    assert halved.extents.min() == pytest.approx(0.04)


def test_grasps_touch_the_object_within_the_opening(mug, grasps):
    assert len(grasps) == 60
    points = grasps.contacts.reshape(-1, 3)
    squares, *_ = igl.point_mesh_squared_distance(points, mug.vertices, mug.faces)
    assert np.sqrt(squares.max()) < 1e-6
    spans = np.linalg.norm(grasps.contacts[:, 1] - grasps.contacts[:, 0], axis=1)
    assert grasps.widths == pytest.approx(spans)
    assert spans.max() <= egad.gripper("panda").opening


def test_poses_close_along_x_about_the_middle_of_the_contacts(grasps):
    poses, contacts = grasps.poses, grasps.contacts
    assert poses[:, :3, 3] == pytest.approx(contacts.mean(axis=1))
    along = np.einsum(
        "nij,nj->ni", poses[:, :3, :3].transpose(0, 2, 1), np.diff(contacts, axis=1)[:, 0]
    )
    assert along == pytest.approx(np.outer(grasps.widths, [1, 0, 0]), abs=1e-9)
    identity = np.einsum("nij,nik->njk", poses[:, :3, :3], poses[:, :3, :3])
    assert identity == pytest.approx(np.tile(np.eye(3), (len(grasps), 1, 1)), abs=1e-9)
    assert np.linalg.det(poses) == pytest.approx(np.ones(len(grasps)))


def test_quality_is_ferrari_canny_about_the_center_of_mass(mug, grasps):
    axes = grasps.poses[:, :3, 0]
    expected = ferrari_canny(grasps.contacts, grasps.normals, axes, mug.center_mass)
    assert grasps.quality == pytest.approx(expected)
    off = egad.sample_grasps(mug, "panda", n=60, seed=3, center_of_mass=(0.05, 0, 0))
    assert off.quality == pytest.approx(
        ferrari_canny(off.contacts, off.normals, off.poses[:, :3, 0], np.array([0.05, 0, 0]))
    )


def test_the_same_seed_gives_the_same_grasps(mug, grasps):
    again = egad.sample_grasps(mug, egad.gripper("panda"), n=60, seed=3)
    pd.testing.assert_frame_equal(again.to_frame(), grasps.to_frame())
    other = egad.sample_grasps(mug, "panda", n=60, seed=4)
    assert not np.array_equal(other.contacts, grasps.contacts)
    numpy = egad.sample_grasps(mug, "panda", n=np.uint8(60), seed=np.int64(3))
    pd.testing.assert_frame_equal(numpy.to_frame(), grasps.to_frame())


def test_a_box_is_one_convex_part_that_rests_on_six_faces():
    box = trimesh.creation.box((0.04, 0.04, 0.04))
    (part,) = egad.convex_parts(box)
    assert part.volume == pytest.approx(box.volume)
    poses = egad.stable_poses(box)
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6)
    low = egad.stable_poses(box, center_of_mass=(0, 0, -0.015))
    assert low[0].height == pytest.approx(0.005)
    placed = trimesh.transform_points([*box.vertices, (0, 0, -0.015)], low[0].matrix)
    assert placed[:8, 2].min() == pytest.approx(0, abs=1e-12)
    assert placed[8] == pytest.approx([0, 0, 0.005])
    for wrong in ((0, 0), "abc", [[0, 0], [0]], (0, 0, np.nan), 1.0):
        with pytest.raises(UserError, match=r"center_of_mass is .* allowed: 3 finite numbers"):
            egad.stable_poses(box, center_of_mass=wrong)


def test_an_open_surface_rests_if_its_center_of_mass_is_given():
    box = trimesh.creation.box((0.04, 0.04, 0.04))
    box.update_faces(np.arange(len(box.faces)) > 0)
    with pytest.raises(RejectedError, match="open"):
        egad.stable_poses(box)
    poses = egad.stable_poses(box, center_of_mass=(0, 0, 0))
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6)


@pytest.mark.parametrize("wrong", [None, 3, ["released"]])
def test_paths_that_are_none_are_told(wrong):
    with pytest.raises(UserError, match=re.escape(f"source is {wrong!r}; allowed: ")):
        egad.load(wrong)
    with pytest.raises(UserError, match=re.escape(f"path is {wrong!r}; allowed: a path")):
        egad.load_grasps(wrong)


def friction_angles(grasps):
    """Tangents of the angles between the closing axis and both normals, (n, 2)."""
    axis = np.diff(grasps.contacts, axis=1)[:, 0] / grasps.widths[:, None]
    cosines = np.abs(np.einsum("nck,nk->nc", grasps.normals, axis))
    return np.sqrt(1 - np.minimum(cosines, 1) ** 2) / cosines


def test_grasps_lie_in_the_cone_and_slip_outside_the_friction(mug):
    narrow = egad.sample_grasps(mug, "panda", n=40, cone=0.3, friction=0.3)
    assert friction_angles(narrow).max() < 0.3 + 1e-6
    wide = egad.sample_grasps(mug, "panda", n=40, friction=0.3)
    angles = friction_angles(wide).max(axis=1)
    within = angles < 0.3 * np.cos(np.pi / 8)  # the cone of eight edges lies in the round one
    assert 0 < within.sum() < 40
    assert (angles > 0.3).any()
    assert (wide.quality[within] > 0).all()
    assert (wide.quality[angles > 0.3] == 0).all()


def test_a_hand_finds_more_ways_among_more_directions(mug):
    few, many = (
        egad.sample_grasps(mug, "panda", n=40, approach_angles=angles) for angles in (2, 32)
    )
    assert np.array_equal(few.contacts, many.contacts)
    assert few.collision_free.sum() < many.collision_free.sum()
    assert few.to_frame()["angles_fit"].max() <= 2


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"n": 0}, "n is 0; allowed: a whole number, at least 1"),
        ({"n": "many"}, "n is 'many'"),
        ({"cone": 0}, "cone is 0; allowed: a number, above 0, at most 2"),
        ({"friction": -1}, "friction is -1"),
        ({"approach_angles": 0}, "approach_angles is 0"),
        ({"approach_angles": 2.0}, "approach_angles is 2.0; allowed: a whole number, 1 to 360"),
        ({"seed": "x"}, "seed is 'x'; allowed: a whole number, at least 0, below 4294967296"),
        ({"seed": True}, "seed is True"),
        ({"seed": np.array([1, 2])}, "seed is array"),
        ({"gripper": 0.08}, r"a gripper is an egad\.Gripper or the name of one, got 0\.08"),
    ],
)
def test_wrong_arguments_of_the_sampler_are_named(wrong, message):
    with pytest.raises(UserError, match=message):
        egad.sample_grasps(**{"mesh": trimesh.creation.box(), "gripper": "panda"} | wrong)


@pytest.mark.parametrize("opening", [0, -0.1, float("nan"), 20, "wide", None])
def test_a_gripper_that_cannot_open_is_refused(opening):
    message = rf"^opening is {opening!r}; allowed: a number, above 0, at most 10 \(widest"
    with pytest.raises(UserError, match=message):
        egad.Gripper(opening=opening)


def test_wrong_arguments_of_a_gripper_are_told_together():
    with pytest.raises(UserError) as error:
        egad.Gripper(pads="soft", palm=(0.1, -0.1, 0.1))
    first, second, third = str(error.value).split("\n")
    assert first.startswith("opening is missing; allowed: a number")
    assert second.startswith("palm[1] is -0.1; allowed: a list of 3")
    assert third.startswith("pads is 'soft'; allowed: silicone or bare")
    with pytest.raises(UserError, match="'openning' is not known; did you mean opening"):
        egad.Gripper(openning=0.08)
