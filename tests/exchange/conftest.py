"""A small dataset on disk: three objects scaled to a gripper, two of them with grasps."""

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.exchange import RescaleMeshes, rescale_files
from egad.geometry import Bundle, RayCaster, center_of_mass
from egad.geometry.mass import mass_properties
from egad.grasps import LabelParameters, sample_for_labels
from egad.grasps.labels import rate_grasps
from egad.grippers import hand_body
from egad.io import read_mesh, write_obj
from egad.random import generator
from egad.sim import (
    SimulatedLabelParameters,
    make_simulation_object,
    model_of,
    part_rows,
    simulate_labels,
)
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.grasping import SIMULATED_GRASPS
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings, select

GRIPPER = "yumi"
HELD = ("A00_0", "B01_0")


@pytest.fixture(scope="session")
def settings():
    return Settings.model_validate(
        {
            "grasp_label": {"grasps": 20},
            "robust": {"samples": 3},
            "simulated_label": {"grasps": 12},
        }
    )


def object_row(label, mesh, density):
    """A row of OBJECTS with true mass properties and made-up measures."""
    mass = mass_properties(mesh, density)
    parts = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return {
        **dict.fromkeys(OBJECTS.names, 0),
        "id": f"id-{label}",
        "label": label,
        "watertight": True,
        "repaired": False,
        "shell_thickness": 0.0,
        "complexity": 1.5,
        "graspability": 0.002,
        "complexity_cell": 3,
        "difficulty_cell": 14,
        "diversity": 0.25,
        "mass": mass.mass,
        "volume": mass.volume,
        "area": mass.area,
        **{f"com_{part}": value for part, value in zip("xyz", mass.com, strict=True)},
        **{f"inertia_{part}": mass.inertia[place] for part, place in parts.items()},
    }


@pytest.fixture(scope="session")
def meshes():
    """The objects before they are scaled; the last is too wide for any grasp."""
    bar = trimesh.creation.box((0.03, 0.05, 0.08))
    bar.apply_translation((0.01, 0.02, 0.03))
    return {
        "A00_0": bar,
        "B01_0": trimesh.creation.icosphere(subdivisions=3, radius=0.018),
        "C02_0": trimesh.creation.box((0.2, 0.2, 0.2)),
    }


@pytest.fixture(scope="session")
def dataset(meshes, settings, tmp_path_factory):
    """The folder of the dataset."""
    folder = tmp_path_factory.mktemp("exchange") / "tiny"
    for label, mesh in meshes.items():
        write_obj(mesh, folder / "meshes" / f"{label}.obj")
    density = settings.material.density
    rows = pd.DataFrame([object_row(*each, density) for each in meshes.items()])
    parquet.write(rows, OBJECTS, folder / "objects.parquet")
    scaled = folder / "rescaled" / GRIPPER
    rule = select(settings, RescaleMeshes, GRIPPER)
    rule = rule.model_copy(update={"rescale": rule.rescale.model_copy(update={"side_fraction": 1})})
    rescale_files(rule, sorted((folder / "meshes").glob("*.obj")), "m", scaled)
    wide = trimesh.creation.box((0.2, 0.2, 0.2))
    write_obj(wide, scaled / "C02_0.obj")
    found = {label: read_mesh(scaled / f"{label}.obj", "m") for label in meshes}
    parts = pd.concat([convex_parts(label, mesh, settings) for label, mesh in found.items()])
    parquet.write(parts, CONVEX_PARTS, folder / "convex_parts" / f"{GRIPPER}.parquet")
    grasps = pd.concat([simulated_grasps(label, found[label], settings) for label in HELD])
    parquet.write(grasps, SIMULATED_GRASPS, folder / "grasps" / f"{GRIPPER}.parquet")
    return folder


def convex_parts(label, mesh, settings):
    """Rows of CONVEX_PARTS."""
    made = make_simulation_object(mesh, settings.material.density, settings.bundle, label)
    return part_rows(made).assign(label=label, id=f"id-{label}")


def simulated_grasps(label, mesh, settings):
    """Rows of SIMULATED_GRASPS."""
    wanted = select(settings, LabelParameters, GRIPPER)
    caster, rng = RayCaster(mesh), generator(wanted.seed, "grasps", f"id-{label}")
    sampled, _ = sample_for_labels(caster, wanted, rng)
    body, com = hand_body(wanted.gripper), center_of_mass(mesh)
    rows = rate_grasps(caster, com, sampled, wanted, rng, body).assign(
        label=label, id=f"id-{label}"
    )
    made = make_simulation_object(mesh, settings.material.density, settings.bundle, label)
    model = model_of(made.mesh, made.parts, made.physics, made.volume_error)
    return simulate_labels(model, rows, select(settings, SimulatedLabelParameters, GRIPPER))


@pytest.fixture(scope="session")
def labelled(dataset):
    """The table of its grasps."""
    frame = pd.read_parquet(dataset / "grasps" / f"{GRIPPER}.parquet")
    assert set(frame["label"]) == set(HELD)
    assert np.all(frame["grasp"] >= 0)
    return frame


@pytest.fixture(scope="session")
def made():
    """An object of two convex parts, away from the origin, as simulators need it."""
    arms = [((0.06, 0.02, 0.02), (0.05, 0, 0)), ((0.02, 0.02, 0.06), (0.03, 0, 0.02))]
    slabs = [
        trimesh.creation.box(size, trimesh.transformations.translation_matrix(at))
        for size, at in arms
    ]
    ell = trimesh.boolean.union(slabs, engine="manifold")
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    return make_simulation_object(ell.apply_transform(turn), 400.0, Bundle())
