import pyarrow as pa
import pytest
import trimesh

from egad.errors import TableError, UserError
from egad.map_elites.parameters import EvolutionParameters
from egad.pipeline.archive_settings import check_provenance, provenance
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import LocateMeshes, select
from egad.pipeline.stages import evolve, merge
from egad.pipeline.stages.merge import Merge
from egad.pipeline.stages.postprocess import PostprocessSolids, from_archive
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, EPOCH


def settings(**changes):
    return select(Settings.model_validate(changes), EvolutionParameters)


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path, provenance(settings()))
    return path


def test_the_same_settings_pass(archive):
    check_provenance(archive, settings())
    check_provenance(archive, select(Settings(), LocateMeshes), ("shape",))


def test_the_budget_of_the_difficulty_matters(archive):
    with pytest.raises(UserError, match=r"evolution\.max_candidates: 16384 in the archive, 300"):
        check_provenance(archive, settings(evolution={"max_candidates": 300}))


@pytest.fixture
def first_edition(tmp_path):
    """An archive with the columns and notes that the first edition had."""
    columns = [field for field in EPOCH if b"optional" not in field.metadata]
    schema = pa.schema(columns)
    notes = provenance(settings(space={"confidence": 0}))
    notes["difficulty"] = {"grasps": 100, "percentile": 75.0}
    notes["evolution"] = {"reevaluation_grasps": 0}
    del notes["space"]["confidence"]
    path = tmp_path / "first.parquet"
    parquet.write(parquet.empty(schema), schema, path, notes)
    return path


def test_the_first_edition_goes_on_by_the_estimator_of_the_paper_alone(first_edition):
    paper = {"evolution": {"estimator": "paper"}}
    check_provenance(first_edition, settings(**paper))
    with pytest.raises(UserError, match=r"evolution\.estimator: paper in the archive, sequential"):
        check_provenance(first_edition, settings())
    with pytest.raises(UserError, match=r"evolution\.grasps: 100 in the archive, 50"):
        check_provenance(first_edition, settings(evolution=paper["evolution"] | {"grasps": 50}))


def test_objects_of_the_first_edition_are_read_and_its_difficulties_explained(
    first_edition, caplog
):
    with caplog.at_level("INFO"):
        from_archive(first_edition, select(Settings(), PostprocessSolids), 0, 1)
    assert "percentiles of few grasps that keep a distance" in caplog.text
    assert parquet.read(first_edition, ARCHIVE)["cell_confidence"].isna().all()


def test_a_table_with_one_of_the_optional_columns_is_damaged(tmp_path):
    schema = pa.schema([field for field in ARCHIVE if field.name != "difficulty_std"])
    parquet.write(parquet.empty(schema), schema, tmp_path / "odd.parquet")
    with pytest.raises(TableError, match="columns are missing: difficulty_std"):
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


def test_the_robust_metric_against_the_plain_one_is_refused(archive):
    with pytest.raises(UserError, match=r"difficulty\.metric: nominal in the archive, robust in"):
        check_provenance(archive, settings(difficulty={"metric": "robust"}))


def test_only_what_is_asked_for_counts(archive):
    check_provenance(archive, settings(quality={"friction": 0.8}), ("shape",))
    with pytest.raises(UserError, match=r"shape\.resolution: 25 in the archive, 16"):
        check_provenance(archive, settings(shape={"resolution": 16}), ("shape",))


def test_an_archive_without_notes_is_taken_as_it_is(tmp_path):
    path = tmp_path / "foreign.parquet"
    parquet.write(parquet.empty(EPOCH), EPOCH, path)
    check_provenance(path, settings(quality={"friction": 0.8}))


def test_notes_travel_from_epoch_to_archive(archive, tmp_path):
    merged, published = tmp_path / "merged.parquet", tmp_path / "published.parquet"
    merge.run(select(Settings(), Merge), [archive], merged)
    merge.publish(merged, published)
    assert parquet.notes(published) == parquet.notes(archive) == provenance(settings())


def test_evolution_refuses_to_go_on_from_a_foreign_archive(archive, tmp_path):
    out = tmp_path / "out.parquet"
    with pytest.raises(UserError, match="made with other settings"):
        evolve.run(
            settings(quality={"friction": 0.8}), 1, 0, out, tmp_path / "h", tmp_path / "l", archive
        )
    assert not out.exists()


def test_difficulties_by_another_gripper_are_not_compared(tmp_path):
    """The objects are taken, what they were selected by is not."""
    path = tmp_path / "archive.parquet"
    parquet.write(parquet.empty(ARCHIVE), ARCHIVE, path, provenance(settings()))
    for gripper, count in (("yumi", 0), ("panda", 0)):
        config = Settings.model_validate({"difficulty": {"gripper": gripper}})
        read = select(config, PostprocessSolids)
        _, known = from_archive(path, read, 0, 1)
        assert len(known) == count
        assert (known.name == "difficulty") == (gripper == "yumi")


def test_an_evolution_that_keeps_nothing_says_why(tmp_path):
    (tmp_path / "mine.py").write_text("def area(mesh): return mesh.aera\n")
    nothing = settings(
        measures={"complexity": f"{tmp_path}/mine.py:area"},
        evolution={"steps_per_epoch": 1, "population": 20},
    )
    with pytest.raises(UserError, match=r"20 offspring was accepted: .*area failed .*AttributeErr"):
        evolve.run(nothing, 0, 0, tmp_path / "out", tmp_path / "h", tmp_path / "l")


def test_a_region_is_one_body(tmp_path):
    two = [trimesh.creation.box(), trimesh.creation.box().apply_translation([3, 0, 0])]
    trimesh.util.concatenate(two).export(tmp_path / "two.stl")
    with pytest.raises(UserError, match="has 2 parts; one is allowed"):
        evolve.mesh_of(str(tmp_path / "two.stl"))
