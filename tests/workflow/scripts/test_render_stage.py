"""Images of a whole dataset: any shards, held-out objects, what is left out, and the card."""

import image_card
import numpy as np
import pandas as pd
import pytest
import render
import trimesh

from egad.errors import UserError
from egad.io import read_mesh, write_obj
from egad.learning import remove_leftovers
from egad.learning.images import RenderImages, read
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS, EVAL49
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.settings import Settings, select

FAST = {"grasps": 20, "test": 0.2, "validation": 0.2}
NAMES = [f"B{number}" for number in range(8)]


def whole(**render):
    return Settings.model_validate(
        {"render": {"images": 40, **FAST, **render}, "robust": {"samples": 5}}
    )


def settings_of(**render):
    return select(whole(**render), RenderImages, "egad_75mm")


WHOLE, SETTINGS = whole(), settings_of()


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Blocks; but B6 is a bead that no hand can grasp, and the mesh of B7 is flat."""
    folder = tmp_path_factory.mktemp("results") / "mine"
    meshes, parts = folder / "rescaled" / "egad_75mm", []
    for number, name in enumerate(NAMES):
        mesh = trimesh.creation.box(np.array([0.03 + 0.002 * number, 0.05, 0.04]))
        if name == "B6":
            mesh = trimesh.creation.icosphere(subdivisions=1, radius=0.002)
        if name == "B7":
            mesh.vertices[:, 2] = 0
        write_obj(mesh, meshes / f"{name}.obj")
        part = {"vertices": mesh.vertices.ravel(), "faces": mesh.faces.ravel()}
        base = dict.fromkeys(CONVEX_PARTS.names, 0)
        parts.append(base | {"id": f"id-{name}", "label": name, **part})
    parquet.write(pd.DataFrame(parts), CONVEX_PARTS, folder / "parts.parquet")
    rows = [dict.fromkeys(OBJECTS.names, 0) | {"id": f"id-{n}", "label": n} for n in NAMES]
    objects = pd.DataFrame(rows)[OBJECTS.names].assign(complexity=np.arange(8.0))
    parquet.write(objects, OBJECTS, folder / "objects.parquet")
    scales = pd.DataFrame([dict.fromkeys(SCALES.names, 0) | {"label": n, "file": n} for n in NAMES])
    parquet.write(scales.assign(rule="paper"), SCALES, meshes / "scales.parquet")
    chosen = [dict.fromkeys(EVAL49.names, 0) | {"label": "A0", "id": "id-B1", "object_label": "B1"}]
    parquet.write(pd.DataFrame(chosen), EVAL49, folder / "eval49.parquet")
    return folder


def paths(dataset):
    return dataset / "objects.parquet", dataset / "rescaled" / "egad_75mm"


def made(dataset, out, shards=1, settings=SETTINGS, held_out=True, parts=None):
    evaluation = dataset / "eval49.parquet" if held_out else None
    for number in range(shards):
        files = (out / f"images-{number}.parquet", out / f"rejected-{number}")
        render.run(settings, *paths(dataset), (number, shards), *files, evaluation, parts)
    return read(out)


@pytest.fixture(scope="module")
def images(dataset):
    return made(dataset, dataset / "images")


def test_every_object_has_its_images_in_one_split(dataset, images):
    table = images.table
    planned = render.planned(SETTINGS, *paths(dataset), dataset / "eval49.parquet")
    counts = {share.id: share.images for share in planned if share.label not in ("B6", "B7")}
    assert table.groupby("id").size().to_dict() == counts
    assert sum(share.images for share in planned) == 40
    assert table.groupby("id")["split"].nunique().max() == 1
    assert table["image"].is_monotonic_increasing
    assert set(table.loc[table["label"] == "B1", "split"]) == {"test"}
    assert table["objects"].map(list).tolist() == [[name] for name in table["id"]]


def test_any_number_of_shards_gives_the_same_images(dataset, images, tmp_path):
    pd.testing.assert_frame_equal(made(dataset, tmp_path, 5).table, images.table)


def test_objects_without_a_pose_or_a_good_grasp_are_left_out(dataset, images):
    assert not {"id-B6", "id-B7"} & set(images.table["id"])
    left_out = parquet.read(dataset / "images" / "rejected-0", REJECTED).set_index("id")["reason"]
    assert set(left_out.index) == {"id-B6", "id-B7"}
    assert left_out["id-B6"] == "no pose and size with a good grasp was found"
    assert "volume" in left_out["id-B7"]


def test_images_depend_on_their_object_alone(dataset, images, tmp_path):
    """With other splits an object has other numbers, and in each pose the same first views."""
    settings = settings_of(images=90, hold_out=False)
    other = made(dataset, tmp_path, 1, settings, held_out=False).table
    assert not other.groupby("id").size().equals(images.table.groupby("id").size())
    compared = 0
    for (label, pose), rows in by_pose(other):
        before = dict(iter(by_pose(images.table))).get((label, pose), rows.iloc[:0])
        count = min(len(before), len(rows))
        assert before["depth"].tolist()[:count] == rows["depth"].tolist()[:count]
        compared += count
    assert compared > 20


def by_pose(table):
    return table.assign(pose=table["poses"].str[0]).groupby(["label", "pose"])


def test_scenes_show_several_objects_of_a_split_at_rest(dataset, tmp_path):
    settings = settings_of(images=20, packed=0.5, pile=0.5, objects=3, test=0.0, validation=0.0)
    settings = settings.model_copy(
        update={"render": settings.render.model_copy(update={"hold_out": False})}
    )
    found = made(dataset, tmp_path, 1, settings, held_out=False, parts=dataset / "parts.parquet")
    assert set(found.table["scene"]) == {"packed", "pile"}
    assert max(len(picture.objects) for picture in found) > 1
    for picture in found:
        assert len({each.id for each in picture.objects}) == len(picture.objects)
        assert picture.mask.max() == len(picture.objects)
        heights = [lowest(dataset, each) for each in picture.objects]
        assert min(heights) > -0.002
        assert (max if picture.scene == "packed" else min)(heights) < 0.002


def lowest(dataset, imaged):
    """The height of the lowest vertex of an object in an image, in its dataset's size."""
    vertices = read_mesh(paths(dataset)[1] / f"{imaged.id.removeprefix('id-')}.obj", "m").vertices
    return (vertices @ imaged.matrix[2, :3]).min() + imaged.matrix[2, 3]


def test_simulated_grasps_are_those_that_are_free(dataset, tmp_path):
    settings = settings_of(images=4, simulate=True)
    found = made(dataset, tmp_path, 1, settings, parts=dataset / "parts.parquet")
    outcomes = []
    for picture in found:
        known = [each is not None for each in picture.grasps.simulated_success]
        assert known == picture.grasps.collision_free.tolist()
        outcomes += [each for each in picture.grasps.simulated_success if each is not None]
    assert len(outcomes) > 5
    assert np.mean(outcomes) > 0.8  # of a block, by parallel jaws


def test_what_cannot_be_rendered_is_told(dataset, tmp_path):
    with pytest.raises(UserError, match="need convex parts"):
        made(dataset, tmp_path, 1, settings_of(pile=0.5))
    with pytest.raises(UserError, match=r"the gripper opens 0\.075 m"):
        made(dataset, tmp_path, 1, settings_of(widths=(0.02, 0.2)))


@pytest.mark.parametrize("held_out", [True, False])
def test_holding_out_needs_the_evaluation_set_and_nothing_else_does(dataset, tmp_path, held_out):
    settings = settings_of(hold_out=not held_out)
    with pytest.raises(UserError, match="hold_out is"):
        made(dataset, tmp_path, 1, settings, held_out)


def test_the_card_counts_what_is_there(dataset, images, tmp_path):
    rejected = [dataset / "images" / "rejected-0"]
    out, figure = tmp_path / "card.md", tmp_path / "openings.svg"
    given = (dataset / "images", 1, rejected, out, figure, tmp_path / "r.parquet")
    image_card.run(SETTINGS, "mine", "egad_75mm", *given)
    text = out.read_text()
    grasps = [picture.grasps for picture in images]
    free = sum(int(each.collision_free.sum()) for each in grasps)
    good = sum(int((each.collision_free & (each.quality > 0.001)).sum()) for each in grasps)
    reachable = sum(len(each.collision_free) for each in grasps)
    empty = sum(not each.collision_free.any() for each in grasps)
    assert 0 < good <= free < reachable
    for title, number in (
        ("objects", 6),
        ("images", len(images)),
        ("of them single", len(images)),
        ("of them pile", 0),
        ("images without a free grasp", empty),
        ("reachable grasps", reachable),
        ("free grasps", free),
        ("good grasps", good),
    ):
        line = next(line for line in text.splitlines() if line.startswith(f"| {title} |"))
        cells = [int(cell) for cell in line.split("|")[2:-1]]
        assert cells[-1] == sum(cells[:-1]) == number
    draws = int(images.table["draws"].sum())
    in_vain = f"{100 * (1 - len(images) / draws):.0f} % of the draws"
    assert f"{in_vain} for these images showed none, and 10 of 40" in text
    assert "`id-B7`" in text
    assert "(openings.svg)" in text
    assert figure.read_text().rstrip().endswith("</svg>")
    assert len(parquet.read(tmp_path / "r.parquet", REJECTED)) == 2


def test_leftovers_of_a_larger_set_are_removed(dataset, tmp_path):
    made(dataset, tmp_path, 3)
    made_again = tmp_path / "images-0.parquet"
    with pytest.raises(UserError, match="expected images in 1 shards"):
        remove_leftovers(tmp_path, ["images"], 1)
    assert len(list(tmp_path.glob("images-*"))) == 3
    evaluation = dataset / "eval49.parquet"
    render.run(SETTINGS, *paths(dataset), (0, 1), made_again, tmp_path / "r", evaluation)
    remove_leftovers(tmp_path, ["images"], 1)
    assert list(tmp_path.glob("images-*")) == [made_again]
