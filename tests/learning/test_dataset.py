import pickle
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import pytest

from egad.errors import TableError, UserError
from egad.learning.augmentation import Change, Crop
from egad.learning.dataset import ImageDataset, PositiveFilter, Stream, example, order

RULE = PositiveFilter(0.002, 0.02)


@dataclass
class Changed:
    """Rows of which the first has another value."""

    rows: list

    def __call__(self, **values):
        return [{**self.rows[0], **values}, *self.rows[1:4]]


@pytest.fixture
def changed(pictures):
    return Changed(pictures)


def test_every_image_is_found_with_its_counts(images, pictures):
    index = ImageDataset([images], RULE).index
    assert index["image"].tolist() == [row["image"] for row in pictures]
    assert index["grasps"].tolist() == [len(row["u"]) for row in pictures]
    # One that collides and one that would slip are in every image; a third shows no other.
    expected = [0 if n % 3 == 0 else len(row["u"]) - 2 for n, row in enumerate(pictures)]
    assert index["positive"].tolist() == expected


@pytest.mark.parametrize("split", ["train", "validation", "test"])
def test_a_split_has_its_images_and_no_others(images, pictures, split):
    found = ImageDataset([images], RULE).indices(split)
    assert found.tolist() == [n for n, row in enumerate(pictures) if row["split"] == split]


def test_depths_and_grasps_come_back(images, pictures):
    shards = ImageDataset([images], RULE)
    for number in (59, 1, 31):
        depth, grasps = shards.image(number)
        row = pictures[number]
        assert depth.shape == (300, 300)
        assert 0.005 < np.isnan(depth).mean() < 0.015
        assert 0.53 < np.nanmin(depth) < np.nanmax(depth) < 0.61
        good = (row["quality"] > 0.002) & row["collision_free"]
        np.testing.assert_allclose(grasps[:, 0], row["u"][good])
        np.testing.assert_allclose(grasps[:, 3], row["opening"][good])
        np.testing.assert_allclose(grasps[:, 4], 0.02 * 417 / 0.58, rtol=1e-6)


def test_the_best_grasp_is_the_last_one(write, changed, tmp_path):
    count = len(changed.rows[0]["u"])
    quality = np.linspace(0.005, 0.003, count).astype(np.float32)
    rows = changed(
        quality=quality, collision_free=np.ones(count, bool), u=np.arange(count, dtype=np.float32)
    )
    _, grasps = ImageDataset([write(tmp_path, rows)], RULE).image(0)
    assert grasps[:, 0].tolist() == list(range(count))[::-1]


def test_by_simulation_a_positive_grasp_is_free_and_succeeded(write, changed, tmp_path):
    """Whatever its quality; one that was not simulated is not positive."""
    count = len(changed.rows[0]["u"])
    won = [True, None, False, *[True] * (count - 3)]
    free = np.array([True, True, True, False, *[True] * (count - 4)])
    values = {"simulated_success": won, "collision_free": free}
    rows = [{"simulated_success": [None] * len(row["u"]), **row} for row in changed(**values)]
    quality = np.linspace(0.009, 0, count).astype(np.float32)
    rows[0] |= {"quality": quality, "u": np.arange(count, dtype=np.float32)}
    shards = ImageDataset([write(tmp_path, rows, 1)], PositiveFilter(1.0, 0.02, simulated=True))
    assert shards.index["positive"].tolist() == [count - 3, 0, 0, 0]
    assert shards.image(0)[1][:, 0].tolist() == [*range(count - 1, 3, -1), 0]
    assert len(shards.image(1)[1]) == 0
    by_quality = ImageDataset([tmp_path], PositiveFilter(0.0, 0.02))
    assert by_quality.index["positive"][0] == count - 2


def test_several_folders_are_one_set(write, pictures, tmp_path):
    parts = [
        write(tmp_path / name, rows) for name, rows in zip("ab", halves(pictures), strict=True)
    ]
    shards, first, second = (ImageDataset(each, RULE) for each in (parts, parts[:1], parts[1:]))
    assert shards.index["id"].tolist() == [*first.index["id"], *second.index["id"]]
    count = len(first.index)
    for number in (0, count - 1, count, 59):
        alone = first.image(number) if number < count else second.image(number - count)
        for one, other in zip(shards.image(number), alone, strict=True):
            np.testing.assert_array_equal(one, other)
    train = shards.indices("train")
    shown = order(shards.index.loc[train], 0, 0)
    assert sorted(shown) == train.tolist()
    assert min(shown) < count <= max(shown)


def halves(pictures):
    """Images of different objects in two sets, which are numbered alike."""
    cut = 30
    return pictures[:cut], [{**row, "image": n} for n, row in enumerate(pictures[cut:])]


def test_an_object_in_two_splits_is_a_mistake(write, pictures, tmp_path):
    """Also one that lies in a scene of several."""
    rows = [{**row, "split": "test"} for row in pictures[:3]]
    scene = {**pictures[-1], "id": "pile-0", "objects": ["id19", "id0"], "split": "test"}
    whole = write(tmp_path / "a", pictures)
    for name, others in (("b", rows), ("c", [scene])):
        parts = [whole, write(tmp_path / name, others, 1)]
        with pytest.raises(UserError, match=rf"/a, .*/{name}: the object id\d+ is in more than"):
            ImageDataset(parts, RULE)


def test_few_images_are_kept_in_memory(images, monkeypatch):
    monkeypatch.setattr("egad.learning.dataset.WINDOW", 16)
    shards = ImageDataset([images], RULE)
    expected = [shards.image(number)[1] for number in range(60)]
    assert sum(map(len, shards._kept.values())) <= 32
    for number in range(60):
        np.testing.assert_array_equal(shards.image(number)[1], expected[number])


def test_a_copy_for_another_process_gives_the_same(images):
    shards = ImageDataset([images], RULE)
    copy = pickle.loads(pickle.dumps(shards))  # noqa: S301 (our own)
    np.testing.assert_array_equal(copy.image(7)[0], shards.image(7)[0])


def test_a_folder_without_images_or_with_a_gap_is_a_mistake(write, pictures, tmp_path):
    with pytest.raises(UserError, match="no images found"):
        ImageDataset([tmp_path], RULE)
    write(tmp_path, pictures[:6], shards=3)
    (tmp_path / "images-1.parquet").unlink()
    with pytest.raises(UserError, match=r"incomplete, images-1\.parquet of 3 shards missing"):
        ImageDataset([tmp_path], RULE)


def test_a_shard_that_is_cut_short_or_lacks_a_column_is_a_mistake(write, pictures, tmp_path):
    path = write(tmp_path, pictures[:6], shards=1) / "images-0.parquet"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(TableError, match="not a readable Parquet file"):
        ImageDataset([tmp_path], RULE)
    write(tmp_path, [{k: v for k, v in row.items() if k != "angle"} for row in pictures[:6]], 1)
    with pytest.raises(TableError, match="columns are missing: angle"):
        ImageDataset([tmp_path], RULE)


def test_an_unknown_split_and_an_empty_one_are_mistakes(write, changed, tmp_path):
    shards = ImageDataset([write(tmp_path / "one", changed())], RULE)
    with pytest.raises(UserError, match="no image in the split test"):
        shards.indices("test")
    with pytest.raises(UserError, match="split 'holdout' is none of train, validation, test"):
        ImageDataset([write(tmp_path / "two", changed(split="holdout"))], RULE)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"depth": b"hello"}, "image 0: its depth cannot be read"),
        ({"height": 200}, "300 x 200, not 300 x 300"),
        ({"u": np.ones(3, np.float32)}, "not of equal lengths"),
    ],
)
def test_a_damaged_image_is_named(write, changed, tmp_path, values, words):
    shards = ImageDataset([write(tmp_path, changed(**values))], RULE)
    shards.image(1)
    with pytest.raises(TableError, match=words):
        shards.image(0)


@pytest.mark.parametrize(
    ("name", "value"), [("u", np.nan), ("opening", -1), ("depth_center", 0), ("angle", np.inf)]
)
def test_numbers_that_are_no_pixels_are_refused(write, pictures, tmp_path, name, value):
    row = {**pictures[1], name: np.full(len(pictures[1]["u"]), value, np.float32)}
    with pytest.raises(TableError, match="numbers that are not pixels"):
        ImageDataset([write(tmp_path, [row], 1)], RULE).image(0)


def test_a_damaged_png_is_refused_whatever_is_wrong_with_it(write, pictures, tmp_path):
    """Any byte may be wrong: the image is read, or it is refused in a sentence."""
    rng = np.random.default_rng(0)
    whole = pictures[1]["depth"]
    broken = [whole[: int(cut)] for cut in rng.integers(10, len(whole), 10)]
    for place in rng.integers(8, 200, 30):
        data = bytearray(whole)
        data[place] ^= 0x41
        broken.append(bytes(data))
    shards = ImageDataset(
        [write(tmp_path, [{**pictures[1], "depth": data} for data in broken], 1)], RULE
    )
    for number in range(len(broken)):
        with suppress(TableError):
            assert np.nanmax(shards.image(number)[0]) > 0


@pytest.fixture(scope="module")
def shards(images):
    return ImageDataset([images], RULE)


def test_a_pass_shows_each_training_image_once(shards):
    train = shards.indices("train")
    part = shards.index.loc[train]
    first, second = order(part, 0, 0), order(part, 0, 1)
    assert sorted(first) == sorted(second) == train.tolist()
    assert first.tolist() != second.tolist()
    assert first.tolist() == order(part, 0, 0).tolist()
    assert first.tolist() != order(part, 1, 0).tolist()


def test_few_groups_are_open_at_a_time(shards, monkeypatch):
    """Images are shuffled within windows of whole groups."""
    monkeypatch.setattr("egad.learning.dataset.WINDOW", 20)
    index = shards.index
    group = index.groupby(["shard", "group"]).ngroup()
    shuffled = order(index, 3, 0)
    assert sorted(shuffled) == list(range(60))
    open_at = {name: np.flatnonzero(group[shuffled] == name) for name in set(group)}
    assert all(places.max() - places.min() < 20 + 2 * 16 for places in open_at.values())
    assert any(np.diff(places).max() > 1 for places in open_at.values())


def test_an_example_depends_on_its_number_alone(shards):
    forth = [Stream(shards, 100, seed=1)[number] for number in (0, 50, 99)]
    stream = Stream(shards, 100, seed=1)
    for number, (seen, wanted) in zip((99, 50, 0), forth[::-1], strict=True):
        again = stream[number]
        np.testing.assert_array_equal(again[0], seen)
        np.testing.assert_array_equal(again[1], wanted)
    assert not np.array_equal(Stream(shards, 100, seed=2)[0][0], forth[0][0])


@pytest.mark.parametrize("number", [1, 4])
def test_a_cropped_example_is_a_part_of_the_whole_one(shards, number):
    """Depths are less the mean of the whole image, as when a network is used."""
    depth, rectangles = shards.image(number)
    for change in (Change(), Change(3, 0.9)):
        seen, wanted = example(depth, rectangles, change)
        row, column, side = crop = Crop(60, 64, 180)
        part = np.s_[:, row : row + side, column : column + side]
        cropped = example(depth, rectangles, change, crop)
        np.testing.assert_allclose(cropped[0], seen[part], atol=1e-6)
        np.testing.assert_array_equal(cropped[1], wanted[part])
        assert wanted[part].any()
