import pytest

from egad import tables
from egad.evolution.archive import Archive
from egad.evolution.evaluation import Solid, measure
from egad.evolution.island import evolve
from egad.evolution.reproduction import breed
from egad.settings import Difficulty, Evolution, Settings, Shape, Similarity
from egad.stage_settings import Evolve, select
from egad.workers import workers

SETTINGS = select(
    Settings(
        evolution=Evolution(steps_per_epoch=2, population=12),
        shape=Shape(resolution=16),
        difficulty=Difficulty(grasps=8),
        similarity=Similarity(vertices=300, ranges=16, base_count=8),
    ),
    Evolve,
)


def evolved(worker_count, **names):
    archive = Archive(SETTINGS.space, SETTINGS.similarity)
    with workers(worker_count) as mapper:
        counts = evolve(archive, SETTINGS, **names, mapper=mapper)
    return archive, counts


@pytest.fixture(scope="module")
def island():
    return evolved(1, epoch=0, island=0)


def test_every_offspring_is_accounted_for(island):
    _, counts = island
    assert counts.total() == 2 * 12
    assert counts["evaluated"] > 5
    assert counts["empty"] > 0


def test_two_workers_give_the_same_bytes_as_one(island, tmp_path):
    one, _ = island
    two, _ = evolved(2, epoch=0, island=0)
    tables.write(one.to_frame(), tables.EPOCH, tmp_path / "one")
    tables.write(two.to_frame(), tables.EPOCH, tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_another_island_and_another_epoch_find_other_objects(island):
    ids = {each.id for each in island[0].elites}
    assert {each.id for each in evolved(1, epoch=0, island=1)[0].elites} != ids
    assert {each.id for each in evolved(1, epoch=1, island=0)[0].elites} != ids


def test_offspring_of_an_archive_have_parents_from_it(island):
    elites = island[0].elites
    ids = {each.id for each in elites}
    offspring = breed(elites, SETTINGS, 0, 0, 5)
    assert len(offspring) == 12
    assert {parent for each in offspring for parent in each.parents} <= ids
    assert {len(each.parents) for each in offspring} == {1, 2}


def test_without_elites_offspring_are_random():
    assert [each.parents for each in breed([], SETTINGS, 0, 0, 0)] == [()] * 12


def test_a_solid_has_the_same_measures_whoever_bred_it(island):
    for each in island[0].elites[:3]:
        again = measure(Solid(each.id, each.voxels), SETTINGS)
        assert (again.complexity, again.difficulty) == (each.complexity, each.difficulty)
