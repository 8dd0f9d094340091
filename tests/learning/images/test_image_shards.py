"""What is written is read again, whole or with a sentence about what is missing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from egad.errors import TableError, UserError
from egad.learning.images import Images, Share, coded, encoded, pictures, read
from egad.learning.images.image_shards import decoded
from egad.tables import parquet
from egad.tables.images import IMAGES
from egad.tables.origin import Origin, made_by

SHARE = Share("id-1", "A1", "train", 10, 6, "single", ("A1",))


@pytest.fixture(scope="module")
def rendered(block, hand, rendering):
    return list(pictures(block, SHARE, hand, rendering()))


@pytest.fixture
def folder(rendered, tmp_path):
    """Two shards, of four images and of two."""
    table = pd.DataFrame([encoded(picture) for picture in rendered])
    for number, rows in enumerate((table[:4], table[4:])):
        notes = {"shard": number, "shards": 2}
        parquet.write(rows, IMAGES, tmp_path / f"images-{number}.parquet", notes)
    return tmp_path


def test_pictures_survive_the_files(folder, rendered):
    found = read(folder)
    assert len(found) == 6
    for before, after in zip(rendered, found, strict=True):
        assert (before.image, before.id, before.label) == (after.image, after.id, after.label)
        assert (before.split, before.scene, before.draws) == (
            after.split,
            after.scene,
            after.draws,
        )
        assert after.depth.dtype == np.float32
        np.testing.assert_allclose(after.depth, before.depth, atol=5.1e-5)
        np.testing.assert_array_equal(after.mask, before.mask)
        assert after.view.intrinsics == before.view.intrinsics
        np.testing.assert_allclose(after.view.pose, before.view.pose, atol=1e-12)
        for first, second in zip(before.objects, after.objects, strict=True):
            assert first[:3] == second[:3]
            np.testing.assert_allclose(second.matrix, first.matrix, atol=1e-12)
        assert list(before.grasps.simulated_success) == list(after.grasps.simulated_success)
        for name in before.grasps._fields[:-1]:
            found, expected = getattr(after.grasps, name), getattr(before.grasps, name)
            np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_images_are_a_sequence(folder):
    found = read(folder)
    assert isinstance(found[2:4], Images)
    assert [picture.image for picture in found[2:4]] == [12, 13]
    assert found[-1].image == 15
    assert len(read(folder, "train")) == 6
    assert len(read(folder, "test")) == 0
    with pytest.raises(UserError, match="train"):
        read(folder, "trian")


def test_the_same_bytes_whatever_is_rendered_beside(block, hand, rendering, rendered):
    again = list(pictures(block, SHARE._replace(first=0), hand, rendering()))
    for before, after in zip(rendered, again, strict=True):
        first, second = encoded(before), encoded(after)
        assert first.pop("image") == second.pop("image") + 10
        assert first["depth"] == second["depth"]
        assert first["mask"] == second["mask"]


def test_half_written_folders_say_what_is_missing(folder):
    (folder / "images-0.parquet").unlink()
    with pytest.raises(UserError, match=r"incomplete, images-0\.parquet of 2 shards missing"):
        read(folder)
    with pytest.raises(UserError, match="no images found"):
        read(folder / "nowhere")


@pytest.mark.parametrize("changed", [{"settings": "b"}, {"inputs": ((Path("o"), "2"),)}])
def test_shards_made_from_something_else_are_no_part(folder, rendered, changed):
    """As a changed configuration leaves them if it is interrupted: their splits may differ."""
    before = Origin("1", "render", "code", settings="a", inputs=((Path("o"), "1"),))
    for number, origin in enumerate((before, replace(before, **changed))):
        table = pd.DataFrame([encoded(rendered[number])])
        with made_by(origin):
            notes = {"shard": number, "shards": 2}
            parquet.write(table, IMAGES, folder / f"images-{number}.parquet", notes)
    with pytest.raises(UserError, match="of several sets"):
        read(folder)


def test_a_shard_that_was_cut_short_is_not_read(folder):
    path = folder / "images-1.parquet"
    path.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(TableError, match=r"images-1\.parquet"):
        read(folder)


def test_what_is_too_deep_or_missing_has_no_value():
    depth = np.array([[0.6, np.nan, 6.5535, 6.5536, np.inf]], dtype=np.float32)
    assert coded(depth).tolist() == [[6000, 0, 65535, 0, 0]]


def test_missing_pixels_are_not_a_number(block, hand, rendering):
    noise = rendering(image_noise={"missing": 0.1})
    picture = next(pictures(block, SHARE, hand, noise))
    found = decoded(encoded(picture))
    assert np.isnan(found.depth).mean() == pytest.approx(0.1, rel=0.01)
    np.testing.assert_array_equal(np.isnan(found.depth), np.isnan(picture.depth))
