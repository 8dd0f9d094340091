"""Objects for training images, placed on a table and grasped in simulation."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad.bench import SceneKind, make_scene
from egad.bench.scenes import BOX
from egad.geometry import mass_properties
from egad.grasps import ContactPairs
from egad.sim import (
    EngineName,
    Model,
    SimulatedLabelParameters,
    UnstableError,
    model_of,
    open_world,
)
from egad.sim.simulated_labels import simulate_grasps
from egad.tables.columns import vector_names


def model_at_size(
    mesh: trimesh.Trimesh, parts: Sequence[trimesh.Trimesh], factor: float, density: float
) -> Model:
    """A resized object for the engine, in the frame of the scaled mesh; the density is in kg/m3."""
    sized = mesh.copy().apply_scale(factor)
    scaled = [part.copy().apply_scale(factor) for part in parts]
    return model_of(sized, scaled, mass_properties(sized, density), 0.0)


def settle_scene(
    models: Sequence[Model], kind: SceneKind, engine: EngineName, rng: np.random.Generator
) -> list[tuple[int, Floats]]:
    """Put objects on a table: number and (4, 4) from the model's frame to the world, or none."""
    with open_world(engine, models, None, BOX if kind == "pile" else None) as world:
        try:
            present = make_scene(world, kind, rng)
        except UnstableError:
            return []
    return [(number, pose.matrix @ models[number].to_principal) for number, pose in present]


def simulate_contacts(
    model: Model, contacts: ContactPairs, approaches: Floats, settings: SimulatedLabelParameters
) -> list[bool | None]:
    """Whether grasps hold, each closed on the floating object and shaken; None if not known."""
    vectors = {"center": contacts.centers, "axis": contacts.axes, "approach": approaches}
    columns = {
        name: values[:, part]
        for key, values in vectors.items()
        for part, name in enumerate(vector_names(key))
    }
    grasps = pd.DataFrame({**columns, "width": contacts.widths})
    return [each.success for each in simulate_grasps(model, grasps, settings)]
