import re
import time
from types import SimpleNamespace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from egad.evolution import EvolutionParameters
from egad.evolution.voxels import pack
from egad.measures.grid import cell_name, complexity_cells, difficulty_cells
from egad.report import live_map as module
from egad.report.live_map import EpochOfIsland, LiveMap
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(), EvolutionParameters)
STEPS = SETTINGS.evolution.steps
SPACE = SETTINGS.space


EVALUATIONS = STEPS * SETTINGS.evolution.population


def live_map(page, run, epoch, island, islands=None):
    about = EpochOfIsland(run, epoch, island, EVALUATIONS, islands)
    return LiveMap(page, about, SPACE, SETTINGS.shape.resolution)


def elites(count, seed=0):
    rng = np.random.default_rng(seed)
    made = []
    for number in range(count):
        voxels = np.zeros((SETTINGS.shape.resolution,) * 3, dtype=bool)
        low, high = sorted(rng.choice(24, (2, 3), replace=False), key=sum)
        voxels[tuple(slice(min(a, b), max(a, b) + 1) for a, b in zip(low, high, strict=True))] = 1
        complexity = rng.uniform(*SPACE.complexity_range)
        graspability = rng.uniform(*SPACE.graspability_range)
        fields = {"complexity": complexity, "graspability": graspability, "voxels": pack(voxels)}
        made.append(SimpleNamespace(id=f"{seed}-{number}", **fields))
    return made


def cells_of(some):
    return {
        cell_name(
            complexity_cells(each.complexity, SPACE), difficulty_cells(each.graspability, SPACE)
        )
        for each in some
    }


def steps(count):
    return [
        {"offspring": SETTINGS.evolution.population, "coverage": n / 500, "elites": n}
        for n in range(1, count + 1)
    ]


def shown(page):
    """The cells with pictures, by name: how many objects they say that they hold."""
    text = page.read_text()
    titles = re.findall(r"<title>([A-Z]\d\d): (\d+) objects?</title>.*?<image ", text)
    return {name: int(count) for name, count in titles}


@pytest.fixture
def page(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "INTERVAL", 0)
    monkeypatch.setattr(module, "SHARE", 1e9)
    return tmp_path / "logs" / "map.html"


def test_every_cell_with_objects_has_a_picture_and_their_number(page):
    found = elites(40)
    live_map(page, "run", 0, 0)(SimpleNamespace(elites=found), steps(3))
    assert set(shown(page)) == cells_of(found)
    assert sum(shown(page).values()) == 40
    assert "300 of" in page.read_text().replace("\N{NARROW NO-BREAK SPACE}", "")


def test_islands_of_a_run_are_on_one_page_and_others_are_not(page):
    found = [elites(10, seed) for seed in range(3)]
    for island, run in enumerate(("run", "run", "another")):
        live_map(page, run, 0, island)(SimpleNamespace(elites=found[island]), steps(1))
    assert set(shown(page)) == cells_of(found[2])
    for number, text in enumerate(("{ broken", "[]", "{}"), 7):
        (page.with_suffix("") / f"island-{number}.json").write_text(text)
    live_map(page, "run", 0, 0)(SimpleNamespace(elites=found[0]), steps(1))
    assert set(shown(page)) == cells_of(found[0] + found[1])


def test_islands_of_an_earlier_run_are_not_on_the_page(page):
    """There were 4 islands and 2 epochs; now there are 2, and the first has begun again."""
    found = [elites(10, seed) for seed in range(4)]
    for epoch, island in ((0, 0), (1, 1), (0, 2), (0, 3)):
        live = live_map(page, "run", epoch, island)
        live(SimpleNamespace(elites=found[island]), steps(1))
    for island in range(2):
        live = live_map(page, "run", 0, island, islands=2)
        assert set(shown(page)) == (cells_of(found[0]) if island else set())
        live(SimpleNamespace(elites=found[island]), steps(1))
    assert set(shown(page)) == cells_of(found[0] + found[1])
    live_map(page, "run", 1, 0, islands=2)
    assert shown(page) == {}


def test_the_page_needs_no_other_file(page):
    live_map(page, "run", 0, 0)(SimpleNamespace(elites=elites(5)), steps(1))
    sources = re.findall(r'(?:src|href)="([^"]*)"', page.read_text())
    assert sources
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    picture = re.search(r"<svg viewBox.*?role=\"img\".*?</svg>", page.read_text(), re.DOTALL)[0]
    ET.fromstring(picture)  # noqa: S314 (our own)


def test_it_is_written_rarely_but_always_at_the_end(page, monkeypatch):
    monkeypatch.setattr(module, "INTERVAL", 1e6)
    live, found = live_map(page, "run", 0, 0), elites(20)
    for count in (5, 10):
        live(SimpleNamespace(elites=found[:count]), steps(count))
    assert set(shown(page)) == cells_of(found[:5])
    live(SimpleNamespace(elites=found), steps(STEPS))
    assert set(shown(page)) == cells_of(found)


def test_a_picture_is_drawn_once_and_an_elite_that_went_is_not_shown(page, monkeypatch):
    drawn = []

    def picture_of(packed, _):
        drawn.append(packed)
        return "data:image/png;base64,"

    monkeypatch.setattr(module, "picture_of", picture_of)
    live, found = live_map(page, "run", 0, 0), elites(30)
    live(SimpleNamespace(elites=found), steps(1))
    live(SimpleNamespace(elites=found[10:]), steps(2))
    assert set(shown(page)) == cells_of(found[10:])
    assert len(set(drawn)) == len(drawn)


def test_pictures_of_the_epoch_before_do_not_delay_the_second_page_but_new_ones_the_third(
    page, monkeypatch
):
    now = [0.0]

    def picture_of(*_):
        now[0] += 1
        return "data:image/png;base64,"

    clock = SimpleNamespace(monotonic=lambda: now[0], strftime=time.strftime)
    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(module, "picture_of", picture_of)
    monkeypatch.setattr(module, "INTERVAL", 10.0)
    monkeypatch.setattr(module, "SHARE", 0.01)
    live, found = live_map(page, "run", 1, 0), elites(60)
    written = []
    for count in (20, 40, 60):
        live(SimpleNamespace(elites=found[:count]), steps(1))
        written.append(set(shown(page)) == cells_of(found[:count]))
        now[0] += 11
    assert written == [True, True, False]
    now[0] += 3000
    live(SimpleNamespace(elites=found), steps(1))
    assert set(shown(page)) == cells_of(found)


def test_evolution_goes_on_where_the_page_cannot_be_written(page, caplog):
    page.parent.write_text("a file where a folder should be")
    live_map(page, "run", 0, 0)(SimpleNamespace(elites=elites(2)), steps(1))
    assert "map.html" in caplog.text
