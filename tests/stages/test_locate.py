import numpy as np
import pandas as pd
import pytest

from egad import tables
from egad.errors import UserError
from egad.exchange.meshes import read_mesh, write_obj
from egad.measures import reeb
from egad.measures.similarity import similarity
from egad.report.locations import page
from egad.settings import Settings
from egad.stage_settings import Evolve, LocateMeshes, select
from egad.stages import evolve, locate, materialise

SETTINGS = Settings.model_validate(
    {
        "evolution": {"population": 15, "steps_per_epoch": 2},
        "shape": {"resolution": 16},
        "difficulty": {"grasps": 12},
        "similarity": {"vertices": 500, "base_count": 12},
        "postprocess": {"grasps": 40},
        "space": {"neighbours": 3},
    }
)
READ = select(SETTINGS, LocateMeshes)


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A small archive and its meshes."""
    folder = tmp_path_factory.mktemp("located")
    archive, history = folder / "archive.parquet", folder / "history.parquet"
    evolve.run(select(SETTINGS, Evolve), 0, 0, None, archive, history, 1)
    materialise.run(archive, folder / "meshes", SETTINGS.shape)
    return folder


@pytest.fixture(scope="module")
def among(home):
    return locate.reference(home / "archive.parquet", SETTINGS.shape)


@pytest.fixture(scope="module")
def files(home):
    meshes = sorted((home / "meshes").glob("*.obj"))[:3]
    (home / "broken.stl").write_text("solid")
    return {path.stem: path for path in [*meshes, home / "broken.stl"]}


@pytest.fixture(scope="module")
def placed(among, files):
    return locate.run(READ, among, files, "m", 1)


def test_an_object_of_the_archive_is_nearest_to_itself(home, placed):
    table, _ = placed
    archive = tables.read(home / "archive.parquet", tables.ARCHIVE).set_index("id")
    for row in table.head(3).to_dict("records"):
        assert row["nearest"][0][:3] == _cell(archive.loc[row["name"]])
        assert row["distances"][0] < 0.02
        assert row["diversity"] == pytest.approx(np.mean(row["distances"]))


def _cell(row):
    return f"{chr(ord('A') + row['difficulty_cell'])}{row['complexity_cell']:02d}"


def test_neighbours_equal_an_exhaustive_search(among, files, placed):
    table, _ = placed
    graphs = {name: reeb.extract(load(), READ.similarity) for name, load in among.load.items()}
    row = table.iloc[0]
    mine = reeb.extract(read_mesh(files[row["name"]], "m"), READ.similarity)
    distances = {name: 1 - similarity(mine, graph, 0.5) for name, graph in graphs.items()}
    nearest = sorted(distances, key=distances.__getitem__)[:3]
    assert row["distances"] == pytest.approx([distances[name] for name in nearest], abs=0.02)


def test_percentiles_count_what_is_simpler_and_easier(among, placed):
    table, _ = placed
    row, objects = table.iloc[1], among.objects
    simpler = 100 * np.mean([value < row["complexity"] for value in objects["complexity"]])
    easier = 100 * np.mean([value > row["difficulty"] for value in objects["difficulty"]])
    assert row["complexity_percentile"] == pytest.approx(simpler)
    assert row["difficulty_percentile"] == pytest.approx(easier)


def test_what_cannot_be_used_has_a_row_with_the_reason(placed):
    table, shown = placed
    assert table.iloc[3]["reason"] == "no faces"
    assert table.iloc[3].drop(["name", "reason"]).isna().all()
    assert [item.row["name"] for item in shown] == table["name"].head(3).tolist()


def test_workers_leave_no_trace(among, files, placed):
    table, shown = locate.run(READ, among, files, "m", 2)
    pd.testing.assert_frame_equal(table, placed[0])
    assert shown == placed[1]


def test_the_folder_of_a_dataset_does_as_well_as_an_archive(among, tmp_path):
    (tmp_path / "meshes").mkdir()
    frame = among.objects.reindex(columns=tables.OBJECTS.names).fillna(0)
    tables.write(frame, tables.OBJECTS, tmp_path / "objects.parquet")
    label = frame["label"].iloc[0]
    write_obj(among.load[label](), tmp_path / "meshes" / f"{label}.obj")
    other = locate.reference(tmp_path, SETTINGS.shape)
    assert list(other.load) == list(among.load)
    assert np.allclose(other.load[label]().vertices, among.load[label]().vertices)


def test_the_page_shows_places_pictures_and_reasons(among, placed):
    table, shown = placed
    text = page(
        "archive", among.objects, shown, {"broken": "<no> faces"}, SETTINGS.space, SETTINGS.axes
    )
    for row in table.head(3).to_dict("records"):
        assert row["name"] in text
        assert all(label in text for label in row["nearest"])
    assert text.count("data:image/png") == 3 * (1 + 3)
    assert "&lt;no&gt; faces" in text
    assert "http" not in text.replace("http-equiv", "")


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(UserError, match="name an archive"):
        locate.reference(tmp_path / "nothing.parquet", SETTINGS.shape)
