"""The page of an atlas: what it is made from, and that it needs no other file."""

import re

import numpy as np
import pandas as pd
import pytest
from partial_tables import fill_columns

import egad
from egad.bench.failures import Examination, FailureAtlas, FailureSearch, Found, features, join
from egad.bench.failures.finding import failure_parameters
from egad.bench.failures.models import scaled_surface
from egad.detectors import Grasp
from egad.errors import UserError
from egad.evolution import evolution_parameters
from egad.evolution.voxels import pack
from egad.report.failure_atlas import write_page
from egad.tables.failures import EXAMINED


def beside(_view, gripper, rng):
    """Proposes what is hardly ever near the object."""
    x, y = rng.uniform(-0.08, 0.08, size=2)
    return [Grasp((x, y, 0.01), 0.0, gripper.opening, 0.0, 1.0)]


@pytest.fixture(autouse=True)
def _rough_features(monkeypatch):
    monkeypatch.setattr(features, "POINTS", 1000)


@pytest.fixture(scope="module")
def atlas():
    """Of two boxes; the second one and its twin count as solved, whatever came of them."""
    search = FailureSearch(
        approach="above", engines=("mujoco",), confirm=6, confidence=0.5, choose=4, screen=4
    )
    settings = failure_parameters(egad.gripper("panda"), search)
    rows, attempts = [], []
    for number, sides in enumerate([(8, 10, 14), (9, 9, 16)]):
        solid = np.zeros((25, 25, 25), bool)
        solid[tuple(slice(4, 4 + side) for side in sides)] = True
        mesh = scaled_surface(pack(solid), settings)
        found = Examination(mesh, f"box-{number}", beside, settings).run()
        attempts.append(found.attempts)
        verdict = "detector_succeeds" if number else "failure"
        rows.append(
            {"id": f"box-{number}", "voxels": pack(solid), "complexity": 1.5 + number}
            | {"graspability": 0.002, "complexity_cell": 3 + number, "difficulty_cell": 14}
            | {"source": "archive", "verdict": verdict, "attempts": len(found.attempts)}
            | {"objective": 0.9, "graph": _graph(mesh), "difference_mujoco": 0.9}
            | {"n_pairs_mujoco": 10, "reference_successes_mujoco": 10}
            | {"detector_successes_mujoco": 1, "difference_pybullet": 0.8}
        )
    rows.append(rows[-1] | {"id": "twin"})
    attempts.append(attempts[-1].assign(id="twin"))
    examined = fill_columns(EXAMINED, rows)
    return join([Found(examined, pd.concat(attempts))], beside, settings)


def _graph(mesh):
    return egad.measures.reeb.graph.pack(
        egad.measures.reeb.graph.extract(mesh, evolution_parameters(0).similarity)
    )


def test_what_a_saved_atlas_knows_comes_back(atlas, tmp_path):
    atlas.save(tmp_path)
    again = FailureAtlas.load(tmp_path)
    assert again.settings == atlas.settings
    assert again.detector == "beside"
    assert again.shape == atlas.shape


def test_a_page_needs_no_other_file(atlas, tmp_path, monkeypatch):
    drawn = np.random.default_rng(0).integers(0, 255, (48, 64, 3), np.uint8)
    monkeypatch.setattr("egad.sim.film.draw", lambda *_: drawn)
    path = tmp_path / "page.html"
    write_page(atlas, path, films=1)
    text = path.read_text(encoding="utf-8")
    addresses = re.findall(r'(?:src|href)="([^"]{1,30})', text)
    assert len(addresses) >= 6
    assert all(address.startswith("data:image/") for address in addresses)
    assert text.count("data:image/webp") == 2
    assert "The search found 1 failure in 1 cell of the map" in " ".join(text.split())
    heads = ["The worst failures", "Why the detector fails", "By outcome", "Where on the map"]
    places = [text.index(f"<h2>{head}") for head in heads]
    assert places == sorted(places)
    assert "By shape" not in text  # one failure says nothing about shapes
    monkeypatch.setattr("egad.report.failure_atlas.MIN_FAILURES", 1)
    write_page(atlas, path, films=0)
    text = path.read_text(encoding="utf-8")
    assert "data:image/webp" not in text
    assert "<h2>By shape" in text


def test_an_atlas_without_settings_has_a_map_but_no_page(atlas, tmp_path):
    bare = FailureAtlas(atlas.table, atlas.examined, atlas.attempts)
    assert bare.plot().svg == atlas.plot().svg
    with pytest.raises(UserError, match="gripper"):
        write_page(bare, tmp_path / "page.html")
