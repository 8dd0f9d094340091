import numpy as np
import pytest
import trimesh

from egad.evalset import PrintExport, filament
from egad.evalset.filament import filament_mass

LINE = 0.45 - 0.2 * (1 - np.pi / 4)  # mm, between the middles of neighboring lines


def grams(mesh, **settings):
    return 1000 * filament_mass(mesh, PrintExport(filament_density=1000, **settings))


def box(*sides):
    """Standing on the bed; sides in mm."""
    mesh = trimesh.creation.box(extents=np.array(sides) / 1000)
    return mesh.apply_translation([0, 0, sides[2] / 2000])


def layer(outer, sparse, infill=0.2):
    """Volume of a square layer with a square of sparse infill, mm3."""
    return 0.2 * (outer**2 - sparse**2 + infill * (sparse + 2 * LINE) ** 2)


@pytest.mark.parametrize(("perimeters", "solid_layers"), [(1, 3), (2, 0), (2, 4), (3, 3)])
def test_a_cube_has_solid_ends_and_perimeters_around_sparse_infill(perimeters, solid_layers):
    sparse_layer = layer(20, 20 - 2 * perimeters * LINE)
    expected = 2 * solid_layers * 0.2 * 400 + (100 - 2 * solid_layers) * sparse_layer
    found = grams(box(20, 20, 20), perimeters=perimeters, solid_layers=solid_layers)
    assert found == pytest.approx(expected / 1000, rel=1e-4)


@pytest.mark.parametrize(("top", "sparse"), [(20, 20), (24, 20)])
def test_layers_below_a_shelf_are_solid_and_narrow_strips_are_widened(monkeypatch, top, sparse):
    """The strip beside a top of 24 mm is 2.2 mm wide and becomes 2 mm wider."""
    monkeypatch.setattr(filament, "STEP", 1)
    parts = [box(30, 30, 10), box(top, top, 20)]
    found = grams(trimesh.boolean.union(parts, engine="manifold"))
    low, shelf, high = layer(30, 30 - 4 * LINE), layer(30, sparse), layer(top, top - 4 * LINE)
    solid = 3 * 0.2 * (30**2 + top**2)
    assert found == pytest.approx((solid + 44 * low + 3 * shelf + 47 * high) / 1000, rel=1e-4)


def test_small_islands_and_thin_walls_are_solid():
    for sides in [(9, 9, 20), (1.6, 40, 20), (40, 40, 1)]:
        assert grams(box(*sides)) == pytest.approx(np.prod(sides) / 1000, rel=1e-4)
    assert grams(box(12, 12, 20)) < 0.9 * 12 * 12 * 20 / 1000


def test_more_perimeters_more_solid_layers_and_more_infill_take_more():
    cylinder = trimesh.creation.cylinder(0.015, 0.03)
    for name, values in {
        "perimeters": (1, 2, 3, 5, 20),
        "solid_layers": (0, 1, 3, 10),
        "infill": (0.1, 0.2, 0.5, 1),
    }.items():
        taken = [grams(cylinder, **{name: value}) for value in values]
        assert (np.diff(taken) > 0).all()


def test_a_full_print_takes_its_volume():
    ball = trimesh.creation.icosphere(radius=0.02)
    assert grams(ball, infill=1) == pytest.approx(1e6 * ball.volume, rel=2e-3)


def test_some_layers_stand_for_all(monkeypatch):
    ball = trimesh.creation.icosphere(radius=0.02)
    some = grams(ball)
    monkeypatch.setattr(filament, "STEP", 1)
    assert some == pytest.approx(grams(ball), rel=0.02)
