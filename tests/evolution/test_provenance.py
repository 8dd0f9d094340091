import pytest

from egad import tables
from egad.errors import UserError
from egad.evolution.provenance import check_provenance, provenance
from egad.settings import Settings
from egad.stage_settings import Evolve, LocateMeshes, Merge, select
from egad.stages import evolve, merge


def settings(**changes):
    return select(Settings.model_validate(changes), Evolve)


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "archive.parquet"
    tables.write(tables.empty(tables.EPOCH), tables.EPOCH, path, provenance(settings()))
    return path


def test_the_same_settings_pass(archive):
    check_provenance(archive, settings())
    check_provenance(archive, select(Settings(), LocateMeshes), ("shape",))


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
    with pytest.raises(UserError, match=r"difficulty\.metric: plain in the archive, robust in"):
        check_provenance(archive, settings(difficulty={"metric": "robust"}))


def test_only_what_is_asked_for_counts(archive):
    check_provenance(archive, settings(quality={"friction": 0.8}), ("shape",))
    with pytest.raises(UserError, match=r"shape\.resolution: 25 in the archive, 16"):
        check_provenance(archive, settings(shape={"resolution": 16}), ("shape",))


def test_an_archive_without_notes_is_taken_as_it_is(tmp_path):
    path = tmp_path / "foreign.parquet"
    tables.write(tables.empty(tables.EPOCH), tables.EPOCH, path)
    check_provenance(path, settings(quality={"friction": 0.8}))


def test_notes_travel_from_epoch_to_archive(archive, tmp_path):
    merged, published = tmp_path / "merged.parquet", tmp_path / "published.parquet"
    merge.run(select(Settings(), Merge), [archive], merged)
    merge.publish(merged, published)
    assert tables.notes(published) == tables.notes(archive) == provenance(settings())


def test_evolution_refuses_to_go_on_from_a_foreign_archive(archive, tmp_path):
    out = tmp_path / "out.parquet"
    with pytest.raises(UserError, match="made with other settings"):
        evolve.run(settings(quality={"friction": 0.8}), 1, 0, archive, out, tmp_path / "h", 1)
    assert not out.exists()
