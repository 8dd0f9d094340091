"""What evolution and the stages behind it do with archives that they are given."""

import evolve
import merge
import publish
import pyarrow as pa
import pytest
from partial_tables import write_rows
from postprocess import from_archive

from egad.errors import UserError
from egad.evolution import EvolutionParameters, PostprocessSolids
from egad.measures import CellsAndDiversities
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, EPOCH
from egad_workflow.archive_settings import provenance
from egad_workflow.settings import Settings, select


def settings(**changes):
    return select(Settings.model_validate(changes), EvolutionParameters)


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, provenance(settings()))
    return path


def test_an_archive_by_the_estimator_of_the_paper_is_read_and_explained(tmp_path, caplog):
    path = tmp_path / "paper.parquet"
    schema = pa.schema([field for field in ARCHIVE if b"optional" not in field.metadata])
    notes = provenance(settings(evolution={"estimator": "paper"}))
    parquet.write(parquet.empty(schema), schema, path, notes)
    with caplog.at_level("INFO"):
        from_archive(path, select(Settings(), PostprocessSolids), 0, 1)
    assert "percentiles of a few grasps that are kept apart" in caplog.text
    assert parquet.read(path, ARCHIVE)["cell_confidence"].isna().all()


def test_notes_travel_from_epoch_to_archive(archive, tmp_path):
    merged, published = tmp_path / "merged.parquet", tmp_path / "published.parquet"
    merge.run(select(Settings(), CellsAndDiversities), [archive], merged)
    publish.run(merged, published)
    assert parquet.notes(published) == parquet.notes(archive) == provenance(settings())


def test_evolution_refuses_to_go_on_from_a_foreign_archive(archive, tmp_path):
    out = tmp_path / "out.parquet"
    with pytest.raises(UserError, match="made with other settings"):
        evolve.run(
            settings(quality={"friction": 0.8}), 1, 0, out, tmp_path / "h", tmp_path / "l", archive
        )
    assert not out.exists()


def test_a_graspability_by_another_gripper_is_not_compared(tmp_path):
    """The objects are taken, what they were selected by is not."""
    path = tmp_path / "archive.parquet"
    elite = {"id": "a", "graspability": 0.5}
    write_rows(ARCHIVE, [elite], path, provenance(settings()))
    for gripper, expected in (("yumi", {"a": 0.5}), ("panda", {})):
        config = Settings.model_validate({"graspability": {"gripper": gripper}})
        sources, known = from_archive(path, select(config, PostprocessSolids), 0, 1)
        assert list(sources) == ["a"]
        assert known.to_dict() == expected


def test_an_evolution_that_keeps_nothing_says_why(tmp_path):
    (tmp_path / "mine.py").write_text("def area(mesh): return mesh.aera\n")
    nothing = settings(
        measures={"complexity": f"{tmp_path}/mine.py:area"},
        evolution={"evaluations": 20, "population": 20},
    )
    with pytest.raises(UserError, match=r"20 offspring was accepted: .*area failed .*AttributeErr"):
        evolve.run(nothing, 0, 0, tmp_path / "out", tmp_path / "h", tmp_path / "l")
