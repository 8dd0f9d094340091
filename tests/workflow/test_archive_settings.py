import pyarrow as pa
import pytest

from egad.errors import TableError, UserError
from egad.evolution import EvolutionParameters
from egad.measures import MeasureMeshes
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, EPOCH
from egad_workflow.archive_settings import check_provenance, provenance
from egad_workflow.settings import Settings, select


def settings(**changes):
    return select(Settings.model_validate(changes), EvolutionParameters)


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, provenance(settings()))
    return path


def test_the_same_settings_pass(archive):
    check_provenance(archive, settings())
    check_provenance(archive, select(Settings(), MeasureMeshes), ("shape",))


def test_the_estimator_and_its_grasps_matter(tmp_path):
    paper = {"estimator": "paper"}
    path = tmp_path / "paper.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, provenance(settings(evolution=paper)))
    check_provenance(path, settings(evolution=paper))
    with pytest.raises(UserError, match=r"evolution\.estimator: paper in the archive, sequential"):
        check_provenance(path, settings())
    with pytest.raises(UserError, match=r"evolution\.grasps: 100 in the archive, 50"):
        check_provenance(path, settings(evolution=paper | {"grasps": 50}))


def test_a_table_with_one_of_the_optional_columns_is_damaged(tmp_path):
    schema = pa.schema([field for field in ARCHIVE if field.name != "graspability_std"])
    parquet.write(parquet.empty(schema), schema, tmp_path / "odd.parquet")
    with pytest.raises(TableError, match="columns are missing: graspability_std"):
        parquet.read(tmp_path / "odd.parquet", ARCHIVE)


def test_an_edited_measure_of_ones_own_is_another_one(tmp_path):
    source = tmp_path / "mine.py"
    source.write_text("def area(mesh): return mesh.area\n")
    own = settings(measures={"complexity": f"{source}:area"})
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, provenance(own))
    check_provenance(path, own)
    source.write_text("def area(mesh): return 2 * mesh.area\n")
    with pytest.raises(UserError, match=r"source\.complexity"):
        check_provenance(path, own)


def test_a_setting_that_the_archive_does_not_know_is_passed_over(tmp_path):
    notes = provenance(settings())
    del notes["shape"]["smoothing_beta"]
    path = tmp_path / "old.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, notes)
    check_provenance(path, settings(shape={"smoothing_beta": 0.5}))


def test_how_it_was_bred_does_not_matter(archive):
    check_provenance(archive, settings(evolution={"population": 7}, neat={"weight_sigma": 2}))


def test_other_measures_are_refused_and_both_are_named(archive):
    other = settings(quality={"friction": 0.8}, complexity={"bins": 64})
    with pytest.raises(UserError) as raised:
        check_provenance(archive, other)
    assert str(raised.value).splitlines()[1:] == [
        "  complexity.bins: 512 in the archive, 64 in the configuration",
        "  quality.friction: 0.5 in the archive, 0.8 in the configuration",
    ]


def test_only_what_is_asked_for_counts(archive):
    check_provenance(archive, settings(quality={"friction": 0.8}), ("shape",))
    with pytest.raises(UserError, match=r"shape\.resolution: 25 in the archive, 16"):
        check_provenance(archive, settings(shape={"resolution": 16}), ("shape",))


def test_an_archive_without_notes_is_taken_as_it_is(tmp_path):
    path = tmp_path / "foreign.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path)
    check_provenance(path, settings(quality={"friction": 0.8}))
