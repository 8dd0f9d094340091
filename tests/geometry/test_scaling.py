import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.errors import RejectedError, UserError
from egad.geometry.scaling import box_sides, rescale, scale_factor, size_text
from egad.tables.grasping import SCALES


def turned(mesh, seed):
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    return mesh.copy().apply_transform(matrix)


def blob(seed=3):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(300, 3)) * [0.01, 0.02, 0.04]
    return trimesh.convex.convex_hull(points)


@pytest.mark.parametrize("seed", range(5))
def test_the_box_of_a_turned_block_is_the_block(seed):
    block = turned(trimesh.creation.box((0.03, 0.05, 0.11)), seed)
    assert np.allclose(box_sides(block), [0.03, 0.05, 0.11], rtol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_no_random_box_is_smaller_and_turning_changes_little(seed):
    mesh = blob(seed)
    volume = np.prod(box_sides(mesh))
    turns = Rotation.random(5000, rng=np.random.default_rng(9)).as_matrix()
    others = np.ptp(np.einsum("kij,nj->kni", turns, mesh.vertices), axis=1).prod(axis=1)
    assert volume <= others.min()
    assert np.prod(box_sides(turned(mesh, 8))) == pytest.approx(volume, rel=0.01)


@pytest.mark.parametrize(
    ("rule", "sides", "factor"),
    [
        ("paper", [0.03, 0.05, 0.2], 1.0),  # fits as it is
        ("paper", [0.12, 0.12, 0.2], 0.5),
        ("egad-script", [0.03, 0.05, 0.2], 0.075 / 0.2),  # longest side decides
        ("egad-script", [0.05, 0.05, 0.05], 1.2),  # smallest side decides
        ("egad-script", [0.01, 0.01, 0.025], 3.0),  # grows
        ("exact", [0.03, 0.05, 0.2], 2.0),
        ("exact", [0.12, 0.12, 0.2], 0.5),
        ("none", [0.03, 0.05, 0.2], 1.0),
        ("none", [0.12, 0.12, 0.2], 1.0),
    ],
)
def test_the_rules(rule, sides, factor):
    assert scale_factor(rule, np.array(sides), 0.075, 0.8) == pytest.approx(factor)


@pytest.mark.parametrize("rule", ["paper", "egad-script", "exact"])
def test_the_row_says_what_was_done(rule):
    mesh = blob()
    scaled, row = rescale(mesh, rule, 0.02, 0.8)
    assert SCALES.names[: len(row) + 1] == ["label", *row]
    assert np.allclose(scaled.vertices, mesh.vertices * row["factor"])
    after = [row["after_1"], row["after_2"], row["after_3"]]
    assert np.allclose(box_sides(scaled), after, rtol=1e-3)
    assert after[0] <= 0.016 * (1 + 1e-9)
    assert (rule, 0.02) == (row["rule"], row["opening"])


def test_a_size_is_said_in_millimetres_without_exponents():
    assert size_text([0.04, 4, 4], 40.0) == "40 x 4000 x 4000 mm, 40 times its size"
    assert size_text([0.0004, 0.0123456, 0.1], 1 / 3) == "0.4 x 12.3 x 100 mm, 0.333 times its size"


def test_an_unknown_rule_and_a_flat_object_are_named():
    with pytest.raises(UserError, match="rule 'papr' is not known; did you mean paper"):
        scale_factor("papr", np.ones(3), 0.1, 0.8)
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    for faces in ([[0, 1, 2]], [[0, 1, 2], [1, 3, 2]]):
        sheet = trimesh.Trimesh(corners[: len(faces) + 2], faces, process=False)
        with pytest.raises(RejectedError, match="flat"):
            rescale(sheet, "paper", 0.1, 0.8)
