"""Meshes that users bring: what is wrong with them is said before the first job."""

import pandas as pd
import pytest
import trimesh

MESHES = {"source": "meshes", "units": "mm"}


@pytest.fixture
def own(clean):
    """A clean checkout with a mesh in `parts`; makes configurations that replace that of egad."""
    (clean.folder / "parts").mkdir()
    trimesh.creation.box([60, 40, 30]).export(clean.folder / "parts/box.stl")

    def configs(folder, **targets):
        datasets = {"mine": MESHES | {"folder": folder}}
        settings = {"shards": 1, "datasets": datasets, "targets": {"datasets": [], **targets}}
        return ["config/test.yaml", clean.overlay("own.yaml", settings)]

    return configs


def test_meshes_that_are_only_compared_have_a_report_and_it_stays_until_the_next(clean, own):
    """The section `release`, which names another dataset, was not given by anybody."""
    replaced = "--replace-workflow-config"
    clean.make("--cores", 2, replaced, configs=own("parts"))
    assert clean.planned(replaced, configs=own("parts")) == {}
    report = clean.results / "report.html"
    whole = report.read_bytes()
    assert b'id="objects"' in whole
    assert b'id="map"' not in whole
    table = clean.results / "comparison.parquet"
    compared = table.read_bytes()
    table.write_bytes(compared[:-100])
    report_alone = ("--cores", 1, replaced, "results/report.html")
    status, said = clean.snakemake(*report_alone, configs=own("parts"))
    assert status != 0
    assert "comparison.parquet: not a readable Parquet file" in said
    assert report.read_bytes() == whole
    table.write_bytes(compared)
    clean.make("--cores", 1, replaced, configs=own("parts"))
    assert report.read_bytes() == whole


@pytest.mark.parametrize("selection", ["all", "cells"])
def test_what_is_trained_on_is_not_a_set_that_is_the_whole_dataset(clean, own, selection):
    configs = own("parts", datasets=["mine"])
    chosen = {"datasets": {"mine": {"evaluation_set": selection}}}
    configs.append(clean.overlay("chosen.yaml", chosen))
    jobs = clean.told("results/mine/images/egad_75mm/card.md", configs=configs)
    renders = [job.params["settings"] for job in jobs if job.rule in ("render", "image_card")]
    assert len(renders) > 1
    assert all(f"'hold_out': {selection == 'cells'}" in settings for settings in renders)


@pytest.mark.slow
def test_all_meshes_run_through_the_whole_pipeline_and_what_is_left_out_is_said(clean, own):
    """Two boxes of one shape share a cell; a sheet is too thin to print."""
    for name, sides in {"same box": (30, 20, 15), "sheet": (80, 60, 0.8)}.items():
        trimesh.creation.box(sides).export(clean.folder / f"parts/{name}.stl")
    said = clean.make("--cores", 2, configs=own("parts", datasets=["mine"]))
    names = ["box", "same_box", "sheet"]  # a blank is not kept
    mine = clean.results / "mine"
    assert pd.read_parquet(mine / "eval49.parquet")["label"].tolist() == names
    prints = pd.read_parquet(mine / "print/egad_75mm/manifest.parquet").set_index("label")
    assert prints.index[prints["plate"].isna()].tolist() == ["sheet"]
    assert pd.read_parquet(mine / "bundle/egad_75mm/bundle.parquet")["label"].tolist() == names
    trials = pd.read_parquet(mine / "trials/egad_75mm/antipodal-depth.parquet")
    assert trials.groupby("label").size().to_dict() == dict.fromkeys(names, 2)
    assert "All 3 objects of the dataset" in (mine / "eval49/README.md").read_text()
    reason = "not printable at this size: walls thinner than 1.2 mm"
    assert f"mine: sheet: left out of printing for egad_75mm: {reason}" in said
    assert f"<td>{reason}</td>" in (clean.results / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("replaced", [(), ("--replace-workflow-config",)], ids=["", "replaced"])
def test_a_wrong_folder_stops_a_dry_run_even_where_an_older_report_is(clean, own, replaced):
    """Snakemake makes no file that it cannot, if the file is there."""
    for name in ("links", "results"):
        (clean.folder / name).mkdir()
    (clean.folder / "links/cup.obj").symlink_to("gone.obj")
    (clean.results / "report.html").touch()
    status, said = clean.snakemake("--dry-run", "--cores", 1, *replaced, configs=own("links"))
    assert status != 0
    assert "datasets.mine: links/cup.obj is a link to gone.obj, which does not exist" in said
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("pattern", "rule"),
    [
        ("meshes/*.obj", "collect"),
        ("rescaled/egad_75mm/*.obj", "rescale"),
        ("print/egad_75mm/*.stl", "print_export"),
        ("bundle/egad_75mm/*/*.urdf", "bundle"),
    ],
)
def test_a_file_that_is_deleted_in_a_folder_is_made_again(copy, pattern, rule):
    next((copy.results / "egad").glob(pattern)).unlink()
    planned = copy.planned()
    assert planned[rule] == 1
    assert "postprocess" not in planned
    assert "collect" not in planned or rule == "collect"
