"""`egad export` with formats of objects, for the evaluation set and for all objects."""

import json
import shutil

import pandas as pd
import pytest
import trimesh
from commands import egad

from egad.exchange import write_bundle
from egad.exchange.bundle import Item
from egad.io import read_mesh
from egad.sim import SimulationBundle
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.objects import OBJECTS
from egad_workflow.settings import select

GRIPPER = "yumi"
ALL = ("--objects", "all")


@pytest.fixture(scope="module")
def folder(dataset, settings, tmp_path_factory):
    """The dataset with a bundle of one object, and with the convex parts of all but one."""
    made = tmp_path_factory.mktemp("objects") / "tiny"
    scaled = made / "rescaled" / GRIPPER
    shutil.copytree(dataset / "rescaled" / GRIPPER, scaled)
    items = [Item("A0", "id-A00_0", scaled / "A00_0.obj")]
    write_bundle(select(settings, SimulationBundle), items, "m", made / "bundle" / GRIPPER)
    for name, schema in (
        ("objects.parquet", OBJECTS),
        (f"convex_parts/{GRIPPER}.parquet", CONVEX_PARTS),
    ):
        rows = parquet.read(dataset / name, schema)
        parquet.write(rows[rows["label"] != "C02_0"], schema, made / name)
    return made


def export(folder, style, out, *more):
    done = egad("export", folder, "--gripper", GRIPPER, "--format", style, "--out", out, *more)
    assert "Traceback" not in done.stderr
    return done


def test_the_evaluation_set_is_that_of_the_bundle(folder, tmp_path):
    assert export(folder, "simulation", tmp_path / "out").returncode == 0
    for path in (folder / "bundle" / GRIPPER / "A0").rglob("*.*"):
        file = path.relative_to(folder / "bundle" / GRIPPER)
        assert (tmp_path / "out" / file).read_bytes() == path.read_bytes()
    noted = (tmp_path / "out/SHA256SUMS").read_text().splitlines()[0]
    assert json.loads(noted.partition("egad-origin ")[2])["arguments"]["format"] == "simulation"


def test_all_objects_have_their_parts_from_the_table(folder, tmp_path):
    done = export(folder, "mjcf", tmp_path / "out", *ALL)
    assert done.returncode == 0
    assert "C02_0 is left out: it has no convex parts in" in done.stderr
    table = pd.read_parquet(folder / "convex_parts" / f"{GRIPPER}.parquet")
    for label, rows in table.groupby("label"):
        scaled = read_mesh(folder / "rescaled" / GRIPPER / f"{label}.obj", "m")
        written = trimesh.load_mesh(tmp_path / "out" / label / "visual.obj")
        assert written.volume == pytest.approx(scaled.volume)
        assert len(list((tmp_path / "out" / label / "parts").iterdir())) == len(rows)
        assert json.loads((tmp_path / "out" / label / "poses.json").read_text())


def test_surfaces_of_all_objects_need_no_parts(folder, tmp_path):
    bare = tmp_path / "bare"
    shutil.copytree(folder / "rescaled", bare / "rescaled")
    assert export(bare, "glb", tmp_path / "out", *ALL).returncode == 0
    names = {path.name for path in (tmp_path / "out").glob("*.glb")}
    assert names == {"A00_0.glb", "B01_0.glb", "C02_0.glb"}


@pytest.mark.parametrize(
    ("more", "file"), [((), "bundle/yumi/bundle.parquet"), (ALL, "convex_parts/yumi.parquet")]
)
def test_what_is_not_made_yet_is_named_with_the_command(folder, tmp_path, more, file):
    bare = tmp_path / "bare"
    shutil.copytree(folder / "rescaled", bare / "rescaled")
    done = export(bare, "sdf", tmp_path / "out", *more)
    assert done.returncode == 1
    said = f"{bare / file} is missing; make it first: snakemake --cores 2 {bare / file}"
    assert said in " ".join(done.stderr.split())
    assert not (tmp_path / "out").exists()
