"""A set of images in other layouts, by the command: splits, the same bytes, and what stops it."""

import pandas as pd
import pytest
import trimesh
from commands import egad

from egad.grippers import BoxBody
from egad.learning.images import SPLITS, RenderParameters, Share, encoded, pictures
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad.tables.images import IMAGES
from egad_workflow.settings import Settings, select


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """A block in each split, two images each, in two shards."""
    folder = tmp_path_factory.mktemp("results") / "mine"
    settings = select(Settings(), RenderParameters, "egad_75mm")
    block, hand = trimesh.creation.box((0.03, 0.03, 0.03)), BoxBody(settings.gripper)
    rows = [
        encoded(picture)
        for number, split in enumerate(SPLITS)
        for share in [Share(f"id-{split}", split, split, 2 * number, 2, "single", (split,))]
        for picture in pictures(block, share, hand, settings)
    ]
    for number, part in enumerate((rows[:4], rows[4:])):
        path = folder / "images" / "egad_75mm" / f"images-{number}.parquet"
        parquet.write(pd.DataFrame(part), IMAGES, path, {"shard": number, "shards": 2})
    scales = pd.DataFrame([dict.fromkeys(SCALES.names, "") | {"label": "train"}])
    numbers = [field.name for field in SCALES if str(field.type) == "double"]
    scales[numbers] = 0.075
    parquet.write(scales, SCALES, folder / "rescaled" / "egad_75mm" / "scales.parquet")
    return folder


def exported(dataset, out, layout, gripper="egad_75mm"):
    """What stops the export; nothing if it succeeds."""
    done = egad("export", dataset, "--gripper", gripper, "--format", layout, "--out", out)
    return done.stderr if done.returncode else ""


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_the_same_bytes_every_time(dataset, tmp_path):
    for name in ("one", "two"):
        assert exported(dataset, tmp_path / name, "jacquard") == ""
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    assert "SHA256SUMS" in contents(tmp_path / "one")


def test_every_split_has_a_folder_with_its_objects(dataset, tmp_path):
    assert exported(dataset, tmp_path / "out", "jacquard") == ""
    files = [name for name in contents(tmp_path / "out") if name.endswith("_grasps.txt")]
    assert len(files) == 6
    for name in files:
        split, label, _ = name.split("/")
        assert split == label


def test_a_folder_that_is_in_use_is_left_alone(dataset, tmp_path):
    (tmp_path / "precious.txt").write_text("mine")
    assert "is not empty" in exported(dataset, tmp_path, "jacquard")
    file = tmp_path / "precious.txt"
    assert "is a file" in exported(dataset, file, "jacquard")
    assert file.read_text() == "mine"


def test_half_written_and_missing_images_are_named(dataset, tmp_path):
    missing = dataset / "images" / "egad_75mm" / "images-1.parquet"
    kept = missing.read_bytes()
    missing.unlink()
    try:
        said = exported(dataset, tmp_path / "out", "jacquard")
    finally:
        missing.write_bytes(kept)
    assert "incomplete, images-1.parquet of 2 shards missing" in said
    assert not (tmp_path / "out").exists()
    assert "scales.parquet" in exported(dataset, tmp_path / "out", "jacquard", "yumi")
