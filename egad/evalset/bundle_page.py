"""The page that lies in a bundle: what is in it and how to load it."""

from typing import Any

import pandas as pd

from egad.stage_settings import SimulationBundle
from egad.tables import parquet

PAGE = """# Objects for simulators

{count} objects, made by egad. Lengths are metres, masses kilograms, inertias kg m2, angles degrees.

| file | what it is |
| --- | --- |
| `LABEL/LABEL.urdf` | for PyBullet, Gazebo, Isaac and others: one link |
| `LABEL/LABEL.xml` | the same as MJCF for MuJoCo: one free body |
| `LABEL/visual.obj` | the true surface |
| `LABEL/parts/part-NNN.obj` | convex parts that stand for it in contacts |
| `LABEL/poses.json` | how it can rest on a table, the most probable first |
| `bundle.parquet` | parts, errors and mass properties, a row an object |
| `rejected.parquet` | what could not be made ready, and why |
| `SHA256SUMS` | `sha256sum --check SHA256SUMS` |

All files of an object share one frame, that of its mesh; the origin is not the centre of mass. Mass
and inertia are those of the solid at {density:g} kg/m3, not of its parts; the sliding friction is
{friction:g}.

A pose has its `probability` (a drop in a random orientation, without bouncing), the `transform`
from the frame of the mesh to that of the table (4 x 4; the table is z = 0, the centre of mass above
its origin), the outward `face_normal` of the resting face in the frame of the mesh, the `height` of
the centre of mass, and the `margin`, by how many degrees the table must be tilted for it to topple.
Poses less than 5 degrees apart count as one; those with a probability below 0.001 are left out.

## Loading

PyBullet takes the inertia from the file only if it is told to, and keeps 1 mm of air around every
part, so that objects rest 1 mm above their pose:

    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF("A0/A0.urdf", flags=flags)

It multiplies the friction of two bodies; MuJoCo takes the larger one. In MuJoCo:

    model = mujoco.MjModel.from_xml_path("A0/A0.xml")

The visual mesh is in group 2 and collides with nothing, the parts are in group 3.

## The objects

The volume error is the volume of all parts together / that of the object - 1, the deviation how far
they stick out of the object at most. `!` marks a volume error beyond the bound of
{bound:.1%}.

| object | parts | volume error | deviation, mm | mass, g | poses |
| --- | --- | --- | --- | --- | --- |
{rows}
{rejected}"""


def page(table: pd.DataFrame, left_out: list[dict[str, str]], settings: SimulationBundle) -> str:
    """The page as Markdown.

    Args:
        table: Columns of `tables.evaluation.BUNDLE`.
        left_out: Rows of `tables.objects.REJECTED`.
        settings: What the objects were made with.
    """
    rows = map(_line, parquet.records(table))
    missing = [f"- {row['id']}: {row['reason']}" for row in left_out]
    return PAGE.format(
        count=len(table),
        density=settings.material.density,
        friction=settings.bundle.friction,
        bound=settings.bundle.volume_error,
        rows="\n".join(rows),
        rejected="\n".join(["", "## Left out", "", *missing, ""]) if missing else "",
    )


def _line(row: dict[str, Any]) -> str:
    mark = "" if row["within"] else " !"
    return (
        f"| {row['label']} | {row['parts']} | {row['volume_error']:.1%}{mark} |"
        f" {1000 * row['deviation']:.2f} | {1000 * row['mass']:.1f} | {row['poses']} |"
    )
