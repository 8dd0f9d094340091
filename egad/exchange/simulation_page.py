"""The page beside the files of objects for simulators: what they are, and how to load them."""

from typing import Any

import pandas as pd

from egad._util.markdown import table as markdown
from egad.geometry import MAX_BURIED, Bundle
from egad.tables import parquet

PAGE = """# Objects for simulators

{count} objects, made by egad. Lengths are metres, masses kilograms, inertias kg m2, angles degrees.

| file | what it is |
| --- | --- |
| `LABEL/LABEL.urdf` | for PyBullet, Gazebo, Isaac and others: one link |
| `LABEL/LABEL.xml` | the same as MJCF for MuJoCo: one free body |
| `LABEL/visual.obj` | the true surface |
| `LABEL/parts/part-NNN.obj` | convex parts that replace it in contacts |
| `LABEL/poses.json` | how it can rest on a table, the most probable first |
| `bundle.parquet` | parts, errors and mass properties, one row per object |
| `rejected.parquet` | objects that could not be prepared, and why |
| `SHA256SUMS` | `sha256sum --check SHA256SUMS` |

All files of an object share one frame, that of its mesh; the origin is not the center of mass. Mass
and inertia are those of the solid at {density:g} kg/m3, not of its parts; the sliding friction is
{friction:g}.

A pose has its `probability` (a drop in a random orientation, without bouncing), the `transform`
from the frame of the mesh to that of the table (4 x 4; the table is z = 0, the center of mass above
its origin), the outward `face_normal` of the resting face in the frame of the mesh, the `height` of
the center of mass, and the `margin`, the smallest tilt of the table in degrees that topples it.
Poses less than 5 degrees apart count as one; those with a probability below 0.001 are left out.

## Loading

PyBullet uses the inertia from the file only if told to, and keeps a gap of 1 mm around every
part, so that objects rest 1 mm above their pose:

    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF("A0/A0.urdf", flags=flags)

It multiplies the friction of two bodies; MuJoCo takes the larger one. In MuJoCo:

    model = mujoco.MjModel.from_xml_path("A0/A0.xml")

The visual mesh is in group 2 and collides with nothing, the parts are in group 3.

## The objects

The volume error is the volume of all parts together / that of the object - 1. The deviation is how
far the parts stick out of the object at most, mostly in narrow hollows. `buried` is the fraction of
the surface that fingers can touch that lies more than {depth:g} mm inside a part. `!` marks a
volume error above the bound of {bound:.1%}, or a buried fraction above {buried:.0%}.

{objects}{rejected}"""
HEAD = ("object", "parts", "volume error", "deviation, mm", "buried", "mass, g", "poses")


def page(
    table: pd.DataFrame, left_out: list[dict[str, str]], density: float, bundle: Bundle
) -> str:
    """The page as Markdown, from `BUNDLE` and `REJECTED`; the density of objects is in kg/m3."""
    missing = [f"- {row['id']}: {row['reason']}" for row in left_out]
    return PAGE.format(
        count=len(table),
        density=density,
        friction=bundle.friction,
        bound=bundle.volume_error,
        depth=1000 * bundle.deviation,
        buried=MAX_BURIED,
        objects=markdown(HEAD, map(_cells, parquet.records(table))),
        rejected="\n".join(["", "## Left out", "", *missing, ""]) if missing else "",
    )


def _cells(row: dict[str, Any]) -> list[Any]:
    mark = "" if row["within"] else " !"
    return [
        row["label"],
        row["parts"],
        f"{row['volume_error']:.1%}{mark}",
        f"{1000 * row['deviation']:.2f}",
        f"{row['buried']:.1%}",
        f"{1000 * row['mass']:.1f}",
        row["poses"],
    ]
