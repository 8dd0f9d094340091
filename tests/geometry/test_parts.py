"""Convex parts from the cache, and warnings for those beyond their bounds."""

import warnings

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.geometry import Bundle
from egad.sim import make_simulation_object, part_rows, read_parts, simulation_object

DENSITY = 400.0


def ell():
    parts = [
        trimesh.creation.box(bounds=[[0, 0, 0], [0.06, 0.02, 0.02]]),
        trimesh.creation.box(bounds=[[0, 0, 0], [0.02, 0.06, 0.02]]),
    ]
    return trimesh.boolean.union(parts, engine="manifold")


def contents(parts):
    return [(np.array(p.vertices).tobytes(), np.array(p.faces).tobytes()) for p in parts]


def test_the_cache_changes_nothing(tmp_path, monkeypatch):
    without = make_simulation_object(ell(), DENSITY, Bundle())
    monkeypatch.setenv("EGAD_CACHE_DIR", str(tmp_path))
    first = make_simulation_object(ell(), DENSITY, Bundle())
    files = sorted(tmp_path.rglob("*.npz"))
    assert len(files) == 2
    monkeypatch.setattr("egad.geometry.parts.decompose", None)  # it is not called again
    again = make_simulation_object(ell(), DENSITY, Bundle())
    assert contents(egad.convex_parts(ell())) == contents(list(without.parts))
    for made in (first, again):
        assert contents(list(made.parts)) == contents(list(without.parts))
        pd.testing.assert_frame_equal(part_rows(made), part_rows(without), check_exact=True)
    assert sorted(tmp_path.rglob("*.npz")) == files


def test_other_settings_and_meshes_are_other_entries(tmp_path, monkeypatch):
    monkeypatch.setenv("EGAD_CACHE_DIR", str(tmp_path))
    larger = ell().apply_scale(1.5)
    assert len(egad.convex_parts(ell())) == 2
    with pytest.warns(egad.PartsWarning):
        assert len(egad.convex_parts(ell(), max_parts=1)) == 1
    (first, _), scaled = egad.convex_parts(ell()), egad.convex_parts(larger)
    assert sum(part.volume for part in scaled) == pytest.approx(larger.volume)
    assert len(list(tmp_path.rglob("convex-parts/*.npz"))) == 3
    assert first.volume < larger.volume


def test_everyone_who_takes_parts_beyond_their_bounds_is_told():
    one = Bundle(max_parts=1)
    text = "the convex parts of {} exceed the requested bounds: their volume error is "
    with pytest.warns(egad.PartsWarning, match=text.format("the mesh")):
        egad.convex_parts(ell(), max_parts=1)
    with pytest.warns(egad.PartsWarning, match=text.format("hook")):
        made = make_simulation_object(ell(), DENSITY, one, "hook")
    rows = part_rows(made).assign(label="hook")
    assert not rows["within"].any()
    assert made.deviation_bound > one.deviation
    with pytest.warns(egad.PartsWarning, match=text.format("hook")):
        read_parts(rows)
    with pytest.warns(egad.PartsWarning, match=text.format("hook")):
        simulation_object(ell(), DENSITY, rows)


def test_nobody_is_told_of_parts_within_their_bounds():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        egad.convex_parts(ell())
        made = make_simulation_object(ell(), DENSITY, Bundle())
        simulation_object(ell(), DENSITY, part_rows(made))
    assert made.within
    assert made.deviation_bound == Bundle().deviation
