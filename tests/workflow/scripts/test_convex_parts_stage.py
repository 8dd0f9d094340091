"""Convex parts of a shard: an object made from its rows is the one that was decomposed."""

import convex_parts
import numpy as np
import pytest
import trimesh
from partial_tables import write_rows

from egad.io import write_obj
from egad.sim import SimulationBundle, make_simulation_object, simulation_object
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(), SimulationBundle)
BOX = trimesh.creation.box((0.04, 0.03, 0.02))
CROSS = trimesh.boolean.union([BOX, trimesh.creation.box((0.02, 0.03, 0.06))], engine="manifold")
OPEN = trimesh.Trimesh(BOX.vertices, BOX.faces[1:], process=False)
SHAPES = {"A00_0": BOX, "A01_0": CROSS, "B00_0": OPEN}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """The parts of a convex solid, of one with hollows, and of a surface that is no solid."""
    folder = tmp_path_factory.mktemp("shard")
    rows = [{"label": label, "id": f"id-{label}"} for label in SHAPES]
    write_rows(OBJECTS, rows, folder / "objects.parquet")
    for label, mesh in SHAPES.items():
        write_obj(mesh, folder / f"{label}.obj")
    out = folder / "parts.parquet"
    convex_parts.run(SETTINGS, folder / "objects.parquet", folder, (0, 1), out)
    return parquet.read(out, CONVEX_PARTS)


def test_what_is_no_solid_has_no_parts(table):
    assert sorted(set(table["label"])) == ["A00_0", "A01_0"]


@pytest.mark.parametrize("label", ["A00_0", "A01_0"])
def test_an_object_made_from_its_rows_is_the_one_that_was_decomposed(table, label):
    density = SETTINGS.material.density
    made = make_simulation_object(SHAPES[label], density, SETTINGS.bundle)
    again = simulation_object(SHAPES[label], density, table[table["label"] == label])
    assert len(again.parts) == len(made.parts)
    for part, other in zip(again.parts, made.parts, strict=True):
        np.testing.assert_array_equal(part.vertices, other.vertices)
        np.testing.assert_array_equal(part.faces, other.faces)
    for value in ("volume_error", "deviation", "buried", "deviation_bound", "within"):
        assert getattr(again, value) == getattr(made, value)
    np.testing.assert_array_equal(again.physics.inertia, made.physics.inertia)
    assert [pose.probability for pose in again.poses] == [pose.probability for pose in made.poses]
