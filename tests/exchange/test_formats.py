"""All formats of objects together, and those of simulated grasps."""

import pytest

import egad
from egad.errors import UserError
from egad.exchange import (
    FORMATS,
    OBJECTS,
    NamedGripper,
    check_format,
    module_of,
    needs_run,
    settings_class,
    sources,
    write_format,
)
from egad.exchange.registry import IMAGES, SURFACES
from egad.grippers import GRIPPERS
from egad.io import WRITERS, write_mesh
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad_workflow.settings import select

HAND = NamedGripper("panda", GRIPPERS["panda"])
SIMULATED = ("acronym", "graspgen", "graspnet", "simready")


def write(name, folder, made):
    if name in SURFACES:
        write_mesh(made.mesh, folder / f"ell.{name}")
    else:
        module_of(name).write(folder, "ell", made, 0.4)


def contents(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_surfaces_are_the_mesh_files_that_can_be_written():
    assert {f".{name}" for name in SURFACES} == set(WRITERS)


@pytest.mark.parametrize("name", [*SURFACES, *OBJECTS])
def test_the_same_object_gives_the_same_bytes(tmp_path, made, name):
    if name == "usd":
        pytest.importorskip("pxr")
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        write(name, folder, made)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert contents(tmp_path / "a")


@pytest.fixture
def export(dataset, settings):
    """Writes the grasps of the dataset, or those of another table."""

    def run(name, out, **instead):
        if name == "simready":
            pytest.importorskip("pxr")
        reads = {each: dataset / file for each, file in sources(name, "yumi").items()}
        chosen = select(settings, settings_class(name), "yumi")
        write_format(name, "evaluation-set", chosen, "yumi", reads | instead, out)
        return contents(out)

    return run


@pytest.mark.parametrize("name", SIMULATED[:-1])
def test_the_same_grasps_give_the_same_bytes(export, tmp_path, name):
    files = export(name, tmp_path / "a")
    assert files == export(name, tmp_path / "b")
    assert len(files) == {"acronym": 2, "graspgen": 2 * 2 + 2 + 3, "graspnet": 3}[name]


@pytest.mark.parametrize("name", SIMULATED)
def test_without_simulated_labels_there_are_no_files(export, labelled, tmp_path, name):
    table = tmp_path / "grasps.parquet"
    parquet.write(labelled, GRASPS, table)
    with pytest.raises(UserError, match=r"no simulated labels.*\{simulated_labels: true\}"):
        export(name, tmp_path / "out", simulated_grasps=table)
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("without_usd")
def test_a_missing_package_is_named():
    with pytest.raises(UserError, match=r"usd needs OpenUSD: pip install 'egad\[usd\]'"):
        check_format("usd", HAND)
    with pytest.raises(UserError, match=r"simready needs OpenUSD: pip install 'egad\[usd\]'"):
        check_format("simready", HAND)
    check_format("sdf", HAND)


def test_a_format_that_reads_results_of_a_run_says_so(tmp_path, made):
    assert {name for name in FORMATS if needs_run(name)} == {"dexnet", *IMAGES}
    with pytest.raises(UserError, match="'dexnet' is written from the results of a run"):
        egad.export({"ball": made.mesh}, "dexnet", "panda", tmp_path / "out")
