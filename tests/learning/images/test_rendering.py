"""Images show objects as they lie, in the sizes that were asked for, and only with good grasps."""

import numpy as np
import pytest
import trimesh

from egad.detectors import DepthCamera
from egad.errors import RejectedError
from egad.geometry import RayCaster
from egad.grasps import Sampling
from egad.learning.images import Share, draw_width, pictures, sample_factor, views_of
from egad.learning.images.arrangement import is_good, near_level, table_grasps
from egad.learning.images.rendering import Labelled

SHARE = Share("id-1", "A1", "train", 0, 30, "single", ("A1",))
WIDTHS = (0.02, 0.07)


def test_grasps_of_a_block_are_level_rated_and_where_it_lies(lying, hand, rendering):
    found = table_grasps([lying], hand, rendering(), np.random.default_rng(0))
    assert len(found.widths) == 100
    assert (np.abs(found.axes[:, 2]) <= np.sin(np.radians(15)) + 1e-12).all()
    corners = lying.mesh.vertices + lying.matrix[:3, 3]
    assert (found.centers > corners.min(axis=0)).all()
    assert (found.centers < corners.max(axis=0)).all()
    assert found.free.any()
    assert (found.qualities[~found.free] == 0).all()
    assert (found.qualities[found.free] > 0).any()


def test_a_neighbor_takes_away_the_grasps_beside_it(lying, hand, rendering):
    """Blocks side by side across the closing axis: a finger between them has no room."""
    other = lying._replace(id="id-2", matrix=lying.matrix.copy())
    other.matrix[0, 3] += 0.034
    settings = rendering(render={"grasps": 60})
    alone = table_grasps([lying], hand, settings, np.random.default_rng(1))
    both = table_grasps([lying, other], hand, settings, np.random.default_rng(1))
    assert both.objects.tolist() == [0] * 60 + [1] * 60
    along_x = np.abs(both.axes[:, 0]) > 0.9
    assert along_x.any()
    assert alone.free[np.abs(alone.axes[:, 0]) > 0.9].any()
    assert not both.free[along_x].any()


def test_good_is_what_held_in_simulation_or_else_has_quality():
    free = np.array([True, True, True, True, False])
    quality = np.array([0.2, 0.0, 0.2, 0.0, 0.2])
    success = [False, True, None, None, True]
    assert is_good(free, quality, success, 0.1).tolist() == [False, True, True, False, False]


def test_a_factor_gives_a_grasp_the_width(block):
    """A block has grasps across its sides and, within the cones, between their edges."""
    rng = np.random.default_rng(0)
    level = near_level(np.array([0, 0, 1.0]), 15)
    for _ in range(10):
        factor = sample_factor(RayCaster(block), 0.02, Sampling(), rng, level)
        assert 0.02 / 0.0671 < factor <= 0.02 / 0.03 + 1e-12


def test_objects_that_would_be_too_long_have_no_size():
    rod = trimesh.creation.box((0.01, 0.01, 0.2))
    found = [
        sample_factor(RayCaster(rod), 0.07, Sampling(), np.random.default_rng(k)) for k in (0, 1)
    ]
    assert found == [0, 0]


def test_widths_are_uniform_and_belong_to_the_view(rendering):
    settings = rendering(render={"widths": WIDTHS})
    drawn = np.array([draw_width(settings, "a", 0, view) for view in range(2000)])
    counts, _ = np.histogram(drawn, np.linspace(*WIDTHS, 6))
    assert counts.sum() == 2000
    assert np.abs(counts - 400).max() < 5 * np.sqrt(2000 * 0.2 * 0.8)
    assert drawn[7] == draw_width(settings, "a", 0, 7)
    assert draw_width(rendering(), "a", 0, 7) is None


def test_sized_objects_rest_on_the_table(block, hand, rendering):
    found = list(pictures(block, SHARE, hand, rendering(render={"widths": WIDTHS})))
    assert len({picture.objects[0].factor for picture in found}) == len(found) > 20
    for picture in found:
        each = picture.objects[0]
        heights = each.factor * block.vertices @ each.matrix[2, :3] + each.matrix[2, 3]
        assert heights.min() == pytest.approx(0, abs=1e-12)
        seen = picture.grasps
        assert is_good(seen.collision_free, seen.quality, seen.simulated_success, 0.001).any()


def test_images_without_a_good_grasp_are_left_out_unless_asked_for(hand, rendering):
    """A bead that is nowhere higher than the fingertips must reach."""
    bead = trimesh.creation.icosphere(subdivisions=1, radius=0.002)
    share = SHARE._replace(images=3)
    assert list(pictures(bead, share, hand, rendering())) == []
    kept = list(pictures(bead, share, hand, rendering(render={"without_grasps": True})))
    assert [picture.image for picture in kept] == [0, 1, 2]
    assert not any(picture.grasps.collision_free.any() for picture in kept)


def test_the_mask_tells_objects_apart_as_their_own_images_do(lying, hand, rendering):
    """The oracle: each object is where its own depth is that of the whole image."""
    high = lying._replace(mesh=lying.mesh.copy().apply_scale((1, 1, 1.5)), matrix=np.eye(4))
    high.matrix[:3, 3] = (0.02, 0.03, 0.03)
    settings = rendering()
    grasps = table_grasps([lying], hand, settings, np.random.default_rng(0))
    labelled = Labelled((lying, high), grasps, 1)
    for picture in views_of(labelled, SHARE._replace(images=4), settings, ("two",)):
        camera = (picture.view.intrinsics, picture.view.pose)
        alone = [
            DepthCamera(mesh).render(each.matrix, *camera).depth
            for mesh, each in zip((lying.mesh, high.mesh), picture.objects, strict=True)
        ]
        assert set(np.unique(picture.mask)) == {0, 1, 2}
        np.testing.assert_array_equal(picture.depth, np.minimum(*alone))
        for number, depth in enumerate(alone, start=1):
            assert (depth[picture.mask == number] == picture.depth[picture.mask == number]).all()


def test_simulated_grasps_arrive_in_the_frame_of_the_mesh(block, hand, rendering):
    """Their contacts lie on the sides of the scaled block, which is not around its origin."""
    settings = rendering(render={"widths": WIDTHS, "simulate": True})
    mesh, told = block.copy().apply_translation((0.02, 0.05, 0.09)), []

    def simulate(placed, contacts, approaches):
        low, high = placed.mesh.bounds
        nearness = np.minimum(np.abs(contacts.points - low), np.abs(contacts.points - high))
        assert nearness.min(axis=2).max(initial=0) < 1e-9
        assert np.abs(np.einsum("ij,ij->i", approaches, contacts.axes)).max(initial=0) < 1e-9
        told.append([number % 2 == 0 for number in range(len(contacts))])
        return told[-1]

    found = list(pictures(mesh, SHARE._replace(images=4), hand, settings, simulate))
    assert len(found) == len(told) == 4
    assert sum(map(len, told)) > 20
    for picture, expected in zip(found, told, strict=True):
        free = picture.grasps.collision_free
        assert picture.grasps.simulated_success[free].tolist() == expected
        assert all(each is None for each in picture.grasps.simulated_success[~free])


def test_what_rests_in_no_pose_is_rejected(hand, rendering):
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]], process=False)
    with pytest.raises(RejectedError, match="no volume"):
        list(pictures(flat, SHARE, hand, rendering()))
