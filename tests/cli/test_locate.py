import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import percentileofscore

from egad.cli.export_meshes import write_meshes
from egad.cli.locate import locate_files, reference
from egad.errors import TableError, UserError
from egad.evolution import Archive, EvolutionParameters, evolve
from egad.geometry.repair import repair
from egad.io import read_mesh, write_obj
from egad.measures import MeasureMeshes, MeasureSpace
from egad.measures.reeb import graph as reeb
from egad.measures.reeb.similarity import similarity
from egad.report.locations import location_map, page
from egad.tables import parquet
from egad.tables.evolution import EPOCH
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.archive_settings import provenance
from egad_workflow.settings import Settings, select

SETTINGS = Settings.model_validate(
    {
        "evolution": {"population": 15, "evaluations": 30, "max_candidates": 128},
        "shape": {"resolution": 16},
        "graspability": {"candidates": 64},
        "similarity": {"vertices": 500, "base_count": 12},
        "postprocess": {"max_candidates": 128},
        "space": {"neighbors": 3},
    }
)
READ = select(SETTINGS, MeasureMeshes)


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A small archive and its meshes."""
    folder = tmp_path_factory.mktemp("located")
    settings = select(SETTINGS, EvolutionParameters)
    found = Archive(settings.space, settings.similarity)
    evolve(found, settings, 0, 0)
    archive = folder / "archive.parquet"
    parquet.write(found.to_frame(), EPOCH, archive, provenance(settings))
    write_meshes(archive, folder / "meshes", SETTINGS.shape)
    return folder


@pytest.fixture(scope="module")
def among(home):
    return reference(home / "archive.parquet", READ)


@pytest.fixture(scope="module")
def files(home):
    meshes = sorted((home / "meshes").glob("*.obj"))[:3]
    (home / "broken.stl").write_text("solid")
    return {path.stem: path for path in [*meshes, home / "broken.stl"]}


@pytest.fixture(scope="module")
def placed(among, files):
    return locate_files(READ, among, files, "m", 1)


def test_an_object_of_the_archive_is_nearest_to_itself(among, placed):
    table, _ = placed
    ids = dict(zip(among.table["label"], among.table["id"], strict=True))
    for row in table.head(3).to_dict("records"):
        ranked = zip(row["nearest"], row["distances"], strict=True)
        same = [ids[label] for label, distance in ranked if distance == 0]
        assert row["name"] in same  # beside its mirror images
        assert row["diversity"] == pytest.approx(np.mean(row["distances"]))


def test_neighbors_equal_an_exhaustive_search(among, files, placed):
    table, _ = placed
    graphs = {each.label: reeb.extract(each.mesh, READ.similarity) for each in among}
    for row in table.head(3).to_dict("records"):
        mine = reeb.extract(repair(read_mesh(files[row["name"]], "m")).mesh, READ.similarity)
        distances = {name: 1 - similarity(mine, graph, 0.5) for name, graph in graphs.items()}
        nearest = sorted(distances, key=distances.__getitem__)[:3]
        assert row["nearest"] == nearest
        assert row["distances"] == pytest.approx([distances[name] for name in nearest], abs=1e-9)


def test_percentiles_count_what_is_simpler_and_easier(among, placed):
    row, objects = placed[0].iloc[1], among.table
    simpler = percentileofscore(objects["complexity"], row["complexity"], kind="strict")
    easier = percentileofscore(-objects["graspability"], -row["graspability"], kind="strict")
    assert row["complexity_percentile"] == pytest.approx(simpler)
    assert row["difficulty_percentile"] == pytest.approx(easier)


def test_what_cannot_be_used_has_a_row_with_the_reason(placed):
    table, shown = placed
    assert table.iloc[3]["reason"] == "no faces"
    assert table.iloc[3].drop(["name", "reason"]).isna().all()
    assert [item.row["name"] for item in shown] == table["name"].head(3).tolist()


def test_workers_leave_no_trace(among, files, placed):
    table, shown = locate_files(READ, among, files, "m", 2)
    pd.testing.assert_frame_equal(table, placed[0])
    assert shown == placed[1]


def test_the_folder_of_a_dataset_does_as_well_as_an_archive(among, tmp_path):
    (tmp_path / "meshes").mkdir()
    frame = among.table.reindex(columns=OBJECTS.names).fillna(0)
    parquet.write(frame, OBJECTS, tmp_path / "objects.parquet")
    for each in among:
        write_obj(each.mesh, tmp_path / "meshes" / f"{each.label}.obj")
    other = reference(tmp_path, READ)
    assert [each.label for each in other] == [each.label for each in among]
    assert np.allclose(other[each.label].mesh.vertices, each.mesh.vertices)


def test_the_page_shows_places_pictures_and_reasons(among, placed):
    table, shown = placed
    text = page("archive", among.table, shown, {"broken": "<no> faces"}, SETTINGS.space)
    for row in table.head(3).to_dict("records"):
        assert row["name"] in text
        assert all(label in text for label in row["nearest"])
    assert text.count("data:image/png") == 3 * (1 + 3)
    assert "&lt;no&gt; faces" in text
    assert "http" not in text.replace("http-equiv", "")


@pytest.mark.parametrize(("name", "count"), [("released", 2198), ("evaluation-set", 49)])
def test_what_egad_ships_is_found_by_its_name(name, count):
    assert len(reference(Path(name), select(Settings(), MeasureMeshes))) == count


def test_what_does_not_fit_the_configuration_is_refused(home, tmp_path):
    coarse = {"space": {"cells": 2}, "shape": {"resolution": 16}}
    other = select(Settings.model_validate(coarse), MeasureMeshes)
    want = "2 along each axis; give the configuration of that dataset"
    with pytest.raises(UserError, match=want):
        reference(home / "archive.parquet", other)
    parquet.write(parquet.empty(REJECTED), REJECTED, tmp_path / "rejected.parquet")
    with pytest.raises(TableError, match=r"rejected\.parquet"):
        reference(tmp_path / "rejected.parquet", READ)


def test_marks_stand_at_their_cells():
    """Complexity goes to the right, difficulty up; in SVG, y goes down."""
    none = pd.DataFrame({"complexity_cell": [], "difficulty_cell": []}, dtype=int)
    drawn = location_map(none, [(0, 0), (9, 0), (0, 9)], MeasureSpace(cells=10))
    (x0, y0), (x1, y1), (x2, y2) = _marks(drawn)
    assert x1 > x0 + 100
    assert y1 == y0
    assert x2 == x0
    assert y2 < y0 - 100


def _marks(svg):
    """Places of the round marks."""
    uses = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)" style="fill: #d55e00', svg)
    return [(float(x), float(y)) for x, y in uses]
