"""A small release, made by the jobs: readers of others open it, and its checksums hold."""

import hashlib
import json
import shutil
import subprocess

import mujoco
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
import release_archive
import release_card
import release_meshes
import release_previews
import release_tables
import trimesh
import yaml
from partial_tables import fill_columns, write_rows
from script_jobs import run_as_job

from egad.errors import UserError
from egad.exchange.release import ReleaseCard, ReleaseTables
from egad.exchange.release import tables as release_files
from egad.geometry import Bundle
from egad.io import write_obj
from egad.sim import SimulationBundle, make_simulation_object, part_rows
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS, EVAL49
from egad.tables.evolution import LINEAGE
from egad.tables.grasping import SCALES, SIMULATED_GRASPS
from egad.tables.objects import OBJECTS
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS
from egad_workflow.settings import Settings, select
from egad_workflow.verify import verify

SETTINGS = Settings.model_validate({"release": {"grasps": 3, "validation": 0.4}})
COUNT, GRASPS = 12, 5
LABELS = [f"{'AB'[number % 2]}{number:02d}_0" for number in range(COUNT)]
ROWS = {"objects": COUNT, "grasps": 3 * COUNT, "evaluation_set": 1}
SCHEMAS = {
    "objects": RELEASED_OBJECTS,
    "grasps": RELEASED_GRASPS,
    "evaluation_set": RELEASED_EVALUATION_SET,
}


def simulated(labels):
    """Grasps of some objects: the last of each was not simulated, the second did not hold."""
    count = len(labels) * GRASPS
    number = np.tile(np.arange(GRASPS), len(labels))
    rng = np.random.default_rng(count)
    frames = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    columns = {f"axis_{part}": frames[:, i, 0] for i, part in enumerate("xyz")}
    columns |= {f"approach_{part}": frames[:, i, 2] for i, part in enumerate("xyz")}
    was = number < GRASPS - 1
    held = np.where(was, number != 1, None)
    outcome = np.where(was, np.where(number == 1, "missed", "success"), None)
    columns |= {
        "id": [f"id-{label}" for label in labels for _ in range(GRASPS)],
        "label": [label for label in labels for _ in range(GRASPS)],
        "grasp": number,
        "simulated_outcome": outcome,
        "simulated_success": held,
        "simulated_engine": np.where(was, "mujoco", None),
    }
    return fill_columns(SIMULATED_GRASPS, pd.DataFrame(columns))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The results of a run that the release is made from."""
    folder = tmp_path_factory.mktemp("run")
    ids = [f"id-{label}" for label in LABELS]
    named = pd.DataFrame({"id": ids, "label": LABELS})
    write_rows(OBJECTS, named, folder / "objects.parquet")
    scales = named[["label"]].assign(factor=0.5, opening=0.08)
    write_rows(SCALES, scales, folder / "scales.parquet")
    chosen = [{"label": "A0", "id": ids[0], "object_label": LABELS[0]}]
    write_rows(EVAL49, chosen, folder / "eval49.parquet")
    # every third object is a founder; the others descend from the one before
    parents = [[] if number % 3 == 0 else [ids[number - 1]] for number in range(COUNT)]
    lineage = pd.DataFrame({"id": ids, "parents": parents})
    write_rows(LINEAGE, lineage, folder / "ancestry.parquet")
    for number in (0, 1):
        table = simulated(LABELS[number::2])
        parquet.write(table, SIMULATED_GRASPS, folder / f"grasps-{number}.parquet")
    parquet.write(simulated(LABELS), SIMULATED_GRASPS, folder / "grasps.parquet")
    parts = []
    for number, label in enumerate(LABELS):
        box = trimesh.creation.box((0.1, 0.1 + number / 100, 0.2))
        write_obj(box, folder / "meshes" / f"{label}.obj")
        if number > 0:  # one object has no convex parts
            made = make_simulation_object(box, 400, Bundle())
            parts.append(part_rows(made).assign(label=label, id=f"id-{label}"))
    table = pd.concat(parts).sort_values(["label", "part"])
    parquet.write(table, CONVEX_PARTS, folder / "convex_parts.parquet")
    return folder


def make(run, folder, grasps=("grasps-0.parquet", "grasps-1.parquet")):
    """Make the release by the jobs of the workflow."""
    release, objects, meshes = folder / "release", run / "objects.parquet", run / "meshes"
    run_as_job(
        release_tables.run,
        "release_tables",
        reads={
            "objects": objects,
            "scales": run / "scales.parquet",
            "evaluation": run / "eval49.parquet",
            "grasps": [run / name for name in grasps],
            "ancestry": [run / "ancestry.parquet"],
        },
        writes={"out": release / "data"},
        params={"settings": select(SETTINGS, ReleaseTables).model_dump(mode="json")},
    )
    for name, script in (("meshes", release_meshes), ("previews", release_previews)):
        run_as_job(
            script.run,
            f"release_{name}",
            reads={"objects": objects, "meshes": meshes},
            writes={"out": release / name},
        )
    archive = release / "archives" / "mjcf.zip"
    run_as_job(
        release_archive.run,
        "release_archive",
        reads={"scales": run / "scales.parquet", "convex_parts": run / "convex_parts.parquet"},
        writes={"out": archive},
        params={
            "settings": select(SETTINGS, SimulationBundle).model_dump(mode="json"),
            "format_name": "mjcf",
            "meshes": str(meshes),
        },
        wildcards={"format": "mjcf"},
    )
    run_as_job(
        release_card.run,
        "release_card",
        reads={
            "pieces": [release / name for name in ("data", "meshes", "previews")],
            "archives": [archive],
            "gallery": [],
        },
        writes={"card": release / "README.md", "sums": release / "SHA256SUMS"},
        params={
            "settings": select(SETTINGS, ReleaseCard).model_dump(mode="json"),
            "out": str(release),
        },
    )
    return release


@pytest.fixture(scope="module")
def release(run, tmp_path_factory):
    return make(run, tmp_path_factory.mktemp("made"))


def tables(release, name):
    return [pd.read_parquet(path) for path in sorted((release / "data" / name).glob("*.parquet"))]


def test_the_checksums_are_those_that_another_program_computes(release):
    words = ["sha256sum", "--check", "--strict", "SHA256SUMS"]
    done = subprocess.run(words, cwd=release, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    listed = {line.partition(": ")[0] for line in done.stdout.splitlines()}
    present = {str(path.relative_to(release)) for path in release.rglob("*") if path.is_file()}
    assert listed == present - {"SHA256SUMS"}
    for name in ("ggcnn2-evolved", "vgn-evolved"):
        assert f"networks/{name}/weights.safetensors" in listed
    assert "networks/vgn-evolved/LICENSE-VGN" in listed


def test_the_same_bytes_for_any_number_of_shards(run, release, tmp_path):
    again = make(run, tmp_path, ["grasps-1.parquet", "grasps-0.parquet"])
    assert (
        hashlib.sha256((again / "README.md").read_bytes()).digest()
        == hashlib.sha256((release / "README.md").read_bytes()).digest()
    )
    whole = make(run, tmp_path / "whole", ["grasps.parquet"])
    for name in ("objects", "grasps"):
        for one, other in zip(tables(again, name), tables(release, name), strict=True):
            pd.testing.assert_frame_equal(one, other)
        assert [len(table) for table in tables(whole, name)] == [
            len(table) for table in tables(release, name)
        ]
    twice = make(run, tmp_path / "twice")
    for path in release.rglob("*"):
        if path.is_file():
            assert (twice / path.relative_to(release)).read_bytes() == path.read_bytes(), path


def test_only_simulated_grasps_are_released_and_no_more_than_wanted(release):
    grasps = pd.concat(tables(release, "grasps"))
    assert grasps.groupby("label")["grasp"].apply(list).to_dict() == {
        label: [0, 1, 2] for label in LABELS
    }
    assert grasps["simulated_success"].tolist() == [True, False, True] * COUNT
    objects = pd.concat(tables(release, "objects"))
    assert set(objects["n_grasps"]) == {3}
    # of all simulated ones, also those that are not released
    assert set(objects["n_simulated"]) == {GRASPS - 1}
    assert set(objects["antipodal_success_rate"]) == {(GRASPS - 2) / (GRASPS - 1)}


def test_the_quaternion_turns_the_axes_of_the_hand(release):
    grasps = pd.concat(tables(release, "grasps"))
    for row in grasps.to_dict("records"):
        x, y, z, w = (row[f"hand_q{part}"] for part in "xyzw")
        matrix = trimesh.transformations.quaternion_matrix([w, x, y, z])
        for column, name in ((0, "axis"), (2, "approach")):
            wanted = [row[f"{name}_{part}"] for part in "xyz"]
            assert np.allclose(matrix[:3, column], wanted, atol=1e-12)


def test_every_file_that_a_table_names_is_there(release):
    chosen = pd.read_parquet(release / "data/evaluation_set.parquet")
    for table in (*tables(release, "objects"), chosen):
        assert all((release / path).is_file() for path in [*table["mesh"], *table["preview"]])
    mesh = trimesh.load(release / "meshes" / f"{LABELS[3]}.glb", force="mesh")
    assert np.allclose(mesh.extents, (0.1, 0.2, 0.13))  # z of the box is up, y in the file


def test_whole_tables_have_the_rows_of_the_splits(release):
    for name, keys in (("objects", ["id"]), ("grasps", ["id", "grasp"])):
        frames = pd.read_parquet(release / f"data/{name}.parquet"), pd.concat(tables(release, name))
        whole, splits = (each.sort_values(keys, ignore_index=True) for each in frames)
        pd.testing.assert_frame_equal(whole, splits)


def test_folders_of_a_large_release_are_cut(run, monkeypatch, tmp_path):
    monkeypatch.setattr(release_files, "MAX_FILES", 5)
    objects, meshes = run / "objects.parquet", run / "meshes"
    shards = [run / f"grasps-{number}.parquet" for number in (0, 1)]
    release_tables.run(
        select(SETTINGS, ReleaseTables),
        objects,
        run / "scales.parquet",
        run / "eval49.parquet",
        shards,
        tmp_path / "data",
    )
    release_meshes.run(objects, meshes, tmp_path / "meshes")
    release_previews.run(objects, meshes, tmp_path / "previews")
    table = pd.read_parquet(tmp_path / "data/objects.parquet")
    assert table["mesh"].nunique() == COUNT
    for column in ("mesh", "preview"):
        assert all((tmp_path / path).is_file() for path in table[column])
    chosen = pd.read_parquet(tmp_path / "data/evaluation_set.parquet")
    assert set(chosen["mesh"]) <= set(table["mesh"])
    for folder in ("meshes", "previews"):
        sizes = [len(list(each.iterdir())) for each in (tmp_path / folder).iterdir()]
        assert sorted(sizes) == [2, 5, 5]


def test_a_simulator_loads_objects_of_the_archive(release, tmp_path):
    shutil.unpack_archive(release / "archives/mjcf.zip", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(LABELS[1:])
    label = LABELS[5]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / label / f"{label}.xml"))
    assert np.isclose(sum(model.body_mass), 400 * 0.1 * 0.15 * 0.2)


def test_the_card_names_the_files_and_columns_that_are_there(release):
    _, front, page = (release / "README.md").read_text(encoding="utf-8").split("---\n", 2)
    fields = yaml.safe_load(front)
    assert fields["license"] == "cc-by-4.0"
    assert {config["config_name"] for config in fields["configs"]} == set(SCHEMAS)
    for config in fields["configs"]:
        for data in config["data_files"]:
            paths = sorted(release.glob(data["path"]))
            assert paths
            for path in paths:
                columns = pq.read_schema(path)
                section = page.split(f"## Columns of `{config['config_name']}`")[1]
                rows = [line for line in section.split("\n## ")[0].splitlines() if "| `" in line]
                assert [row.split("`")[1] for row in rows] == columns.names
                if data["split"] != "test" or config["config_name"] != "evaluation_set":
                    assert set(pd.read_parquet(path)["split"]) <= {data["split"]}


def test_citation_and_provenance_are_readable(release):
    cited = yaml.safe_load((release / "CITATION.cff").read_text(encoding="utf-8"))
    assert (cited["type"], cited["license"]) == ("dataset", "CC-BY-4.0")
    assert cited["references"][0]["authors"][0] == {
        "family-names": "Morrison",
        "given-names": "Douglas",
    }
    graph = json.loads((release / "provenance.json").read_text(encoding="utf-8"))["files"]
    assert {graph[name]["stage"] for name in ("data", "meshes", "previews")} == {
        "release_tables",
        "release_meshes",
        "release_previews",
    }
    assert str(release) not in json.dumps(graph)
    assert verify(release).problems == {}


def test_an_archive_of_an_earlier_release_is_refused(release, tmp_path):
    copy = shutil.copytree(release, tmp_path / "copy")
    (copy / "archives/usd.zip").touch()
    archives = [copy / "archives/mjcf.zip"]
    with pytest.raises(UserError, match=r"archives/usd\.zip: from an earlier release"):
        release_card.run(select(SETTINGS, ReleaseCard), [], archives, [], copy)


def test_datasets_streams_it(release):
    datasets = pytest.importorskip("datasets")
    for name, schema in SCHEMAS.items():
        found = datasets.load_dataset(str(release), name, streaming=True)
        rows = [row for split in found.values() for row in split]
        assert len(rows) == ROWS[name]
        assert list(rows[0]) == schema.names
