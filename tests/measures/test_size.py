import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.measures import SizeEffect
from egad.measures.parameters import SizeEffectParameters
from egad.measures.size_effect import size_effect, summarize
from egad.tables.grasping import SIZE_EFFECT
from egad_workflow.settings import Settings, select

WANTED = SizeEffect(fractions=[0.3, 0.6, 0.9, 1.1], grasps=60, repeats=2)
SETTINGS = select(Settings(size_effect=WANTED), SizeEffectParameters, "panda")
BALL = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
BRICK = trimesh.creation.box([1.0, 1.5, 2.0])
BRICK.vertices += [0.3, -2.0, 5.0]


@pytest.fixture(scope="module")
def brick():
    return size_effect(BRICK, "brick", SETTINGS)


def test_there_is_a_row_for_every_size_repetition_and_percentile(brick):
    assert brick.columns.tolist() == SIZE_EFFECT.names
    keys = brick[["fraction", "repeat", "percentile"]]
    assert len(brick) == 4 * 2 * 3
    assert not keys.duplicated().any()
    assert (brick["possible"] <= brick["candidates"]).all()
    assert (brick["grasps"] <= np.minimum(brick["possible"], 60)).all()


def test_grasps_are_those_of_the_grippers_sampler():
    """A cup of 30 mm seals nowhere on a face of 24 mm, and holds larger cubes in the middle."""
    settings = select(Settings(size_effect=WANTED), SizeEffectParameters, "cup_30mm")
    found = size_effect(trimesh.creation.box([1.0, 1.0, 1.0]), "cube", settings)
    upper = found[found["percentile"] == 85].groupby("fraction")["quality"]
    assert upper.max().isna().tolist() == [True, False, False, False]
    assert 0 < upper.min()[0.9] <= upper.max().max() <= 1
    assert (found["candidates"] == 60).all()


def test_percentiles_ascend(brick):
    for _, group in brick.dropna().groupby(["fraction", "repeat"]):
        assert group.sort_values("percentile")["quality"].is_monotonic_increasing
    assert brick["quality"].max() > 0


def test_nothing_is_found_beyond_the_opening(brick):
    beyond = brick[brick["fraction"] > 1]
    assert (beyond["grasps"] == 0).all()
    assert (beyond["possible"] == 0).all()
    assert beyond["quality"].isna().all()
    assert (brick.loc[brick["fraction"] < 1, "grasps"] > 0).all()


def test_the_share_of_possible_grasps_of_a_brick_falls_as_its_sides_outgrow_the_opening(brick):
    """At 0.6 its longest sides are beyond the opening, at 0.9 the middle ones too."""
    share = summarize(brick).drop_duplicates("fraction").set_index("fraction")["share"]
    assert share.is_monotonic_decreasing
    assert share[0.9] < 0.7 * share[0.3]


def test_a_ball_gives_the_quality_of_a_grasp_through_its_middle():
    """Torsion is what the fingers resist least; it does not depend on the size of a ball."""
    settings = SETTINGS.model_copy(
        update={"sampling": SETTINGS.sampling.model_copy(update={"cone": 0.01})}
    )
    curve = size_effect(BALL, "ball", settings).dropna()
    quality = settings.quality
    most = np.pi * quality.finger_radius**2 * quality.friction * quality.torque_scaling
    assert set(curve["fraction"]) == {0.3, 0.6, 0.9}
    np.testing.assert_allclose(curve["quality"], most, rtol=0.06)
    assert (curve["quality"] <= most * (1 + 1e-9)).all()


@pytest.mark.parametrize("factor", [0.001, 25.4])
def test_the_unit_of_the_mesh_does_not_matter(brick, factor):
    scaled = trimesh.Trimesh(BRICK.vertices * factor, BRICK.faces, process=False)
    same = size_effect(scaled, "brick", SETTINGS)
    np.testing.assert_allclose(same["quality"], brick["quality"], rtol=1e-6, atol=1e-12)
    assert (same["grasps"] == brick["grasps"]).all()


def test_the_curve_follows_from_seed_and_name_and_each_repetition_is_another(brick):
    assert size_effect(BRICK, "brick", SETTINGS).equals(brick)
    other = size_effect(BRICK, "other", SETTINGS)
    assert not other["quality"].equals(brick["quality"])
    first, second = (brick[brick["repeat"] == repeat]["quality"].dropna() for repeat in (0, 1))
    assert (first.to_numpy() != second.to_numpy()).all()


def test_a_size_is_the_same_whatever_other_sizes_there_are(brick):
    fewer = WANTED.model_copy(update={"fractions": [0.6]})
    alone = size_effect(BRICK, "brick", SETTINGS.model_copy(update={"size_effect": fewer}))
    expected = brick[brick["fraction"] == 0.6].reset_index(drop=True)
    assert alone.equals(expected)


def test_a_summary_spans_the_repetitions(brick):
    numbers = summarize(brick)
    assert len(numbers) == 4 * 3
    row = numbers.iloc[1]
    own = brick[(brick["fraction"] == row["fraction"]) & (brick["percentile"] == row["percentile"])]
    assert row["mean"] == pytest.approx(own["quality"].mean())
    assert (row["low"], row["high"]) == (own["quality"].min(), own["quality"].max())
    assert numbers["found"].tolist() == [1.0] * 9 + [0.0] * 3
    assert numbers["mean"].tail(3).isna().all()


def test_a_flat_mesh_is_rejected():
    sheet = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])
    with pytest.raises(RejectedError, match="flat"):
        size_effect(sheet, "sheet", SETTINGS)


@pytest.mark.parametrize("values", [[0.5, 0.4], [0.5, 0.5], [], [0.0], [9.0]])
def test_sizes_ascend(values):
    with pytest.raises(ValueError, match="fractions"):
        SizeEffect(fractions=values)
