"""An object for simulators: convex parts, mass properties, stable poses, README."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from egad._util.parameters import ParameterGroup
from egad.geometry import (
    Bundle,
    MassProperties,
    Material,
    StablePose,
    mass_properties,
    resting_poses,
    wind_outwards,
)
from egad.geometry.parts import make_parts, measure_parts, warn_if_beyond
from egad.geometry.stable_poses import group_poses
from egad.tables import parquet

MIN_PROBABILITY = 0.001  # of the poses that are listed
SAME_POSE = np.radians(5)


class SimulationBundle(ParameterGroup):
    """Objects for simulators: their convex parts, mass and friction."""

    material: Material
    bundle: Bundle


@dataclass(frozen=True)
class SimulationObject:
    """An object in the frame of its mesh, metres."""

    mesh: trimesh.Trimesh  # the surface, wound outwards
    parts: tuple[trimesh.Trimesh, ...]  # convex meshes that represent it in contacts
    physics: MassProperties  # mass properties of the solid within the surface, not of the parts
    volume_error: float  # volume of the union of the parts / volume of the object - 1
    deviation: float  # largest distance by which the parts protrude from the surface of the object
    # share of the surface that fingers can touch which lies deeper in a part than the setting
    # `deviation`
    buried: float
    # the deviation that the parts meet at 99 % of that surface, metres: larger than the setting
    # if more than `max_parts` would be needed. NaN for CoACD
    deviation_bound: float
    within: bool  # whether the parts are as close to the object as the settings require

    @cached_property
    def poses(self) -> tuple[StablePose, ...]:
        """Stable poses on a table: 5 degrees apart, and at least 0.1 % probable."""
        poses = group_poses(resting_poses(self.mesh, self.physics.com), SAME_POSE)
        return tuple(pose for pose in poses if pose.probability >= MIN_PROBABILITY)


def make_simulation_object(
    mesh: trimesh.Trimesh, density: float, settings: Bundle, name: str = "the mesh"
) -> SimulationObject:
    """Prepare a closed surface, metres, density in kg/m3, for simulators; or `RejectedError`."""
    solid = wind_outwards(mesh)
    found = make_parts(solid, settings)
    physics = mass_properties(solid, density)
    errors = measure_parts(solid, found.parts, settings)
    within = errors.is_within(settings)
    warn_if_beyond(name, within, errors.volume_error, found.deviation)
    return SimulationObject(
        mesh=solid,
        parts=tuple(found.parts),
        physics=physics,
        deviation_bound=found.deviation,
        within=within,
        **errors._asdict(),
    )


def part_rows(made: SimulationObject) -> pd.DataFrame:
    """The convex parts of an object: columns of `CONVEX_PARTS`, without `label` and `id`."""
    return pd.DataFrame(
        {
            "part": range(len(made.parts)),
            "vertices": [part.vertices.ravel() for part in made.parts],
            "faces": [part.faces.ravel() for part in made.parts],
            "volume_error": made.volume_error,
            "deviation": made.deviation,
            "buried": made.buried,
            "deviation_bound": made.deviation_bound,
            "within": made.within,
        }
    )


def read_parts(rows: pd.DataFrame) -> tuple[trimesh.Trimesh, ...]:
    """The convex parts in rows of `CONVEX_PARTS`, of one object; warns if they exceed bounds."""
    warn_of_row(parquet.records(rows.head(1))[0])
    corners = [np.reshape(vertices, (-1, 3)) for vertices in rows["vertices"]]
    faces = [np.reshape(each, (-1, 3)) for each in rows["faces"]]
    return tuple(trimesh.Trimesh(*part, process=False) for part in zip(corners, faces, strict=True))


def simulation_object(
    mesh: trimesh.Trimesh, density: float, rows: pd.DataFrame
) -> SimulationObject:
    """An object whose convex parts were made before: `make_simulation_object` and `part_rows`."""
    solid = wind_outwards(mesh)
    physics = mass_properties(solid, density)
    first = rows.iloc[0]
    return SimulationObject(
        mesh=solid,
        parts=read_parts(rows),
        physics=physics,
        volume_error=float(first["volume_error"]),
        deviation=float(first["deviation"]),
        buried=float(first["buried"]),
        deviation_bound=float(first["deviation_bound"]),
        within=bool(first["within"]),
    )


def warn_of_row(row: Mapping[str, Any]) -> None:
    """Warn if the convex parts of a row of `CONVEX_PARTS` or `BUNDLE` exceed their bounds."""
    name = row.get("label", row.get("id", "an object"))
    warn_if_beyond(name, bool(row["within"]), row["volume_error"], row["deviation_bound"])
