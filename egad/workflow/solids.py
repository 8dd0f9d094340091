"""An object of a dataset, repaired and measured."""

from typing import Any

import trimesh

from egad.config.stages import PostprocessSolids
from egad.measures import measure_repeatably
from egad.measures.reeb import graph as reeb
from egad.tables.columns import inertia_columns
from egad.workflow.repair import repaired_body


def solid_row(
    mesh: trimesh.Trimesh, object_id: str, settings: PostprocessSolids, *, resample: bool = True
) -> dict[str, Any]:
    """The row of `tables.objects.SOLIDS` of one object, or `RejectedError`.

    Whether to resample, see `egad.measures.measure_repeatably`; not for evolved objects.
    """
    repaired, mass = repaired_body(mesh, settings.postprocess, settings.material.density)
    solid = repaired.mesh
    most = settings.postprocess.max_candidates
    place = measure_repeatably(solid, settings, most, resample=resample)
    return {
        "id": object_id,
        **place._asdict(),
        "volume": mass.volume,
        "area": mass.area,
        "watertight": bool(solid.is_watertight),
        "repaired": repaired.changed,
        "shell_thickness": repaired.shell_thickness,
        "dropped_bodies": repaired.dropped_bodies,
        "dropped_volume": repaired.dropped_volume,
        **dict(zip(("extents_x", "extents_y", "extents_z"), solid.extents, strict=True)),
        **dict(zip(("com_x", "com_y", "com_z"), mass.com, strict=True)),
        "mass": mass.mass,
        **inertia_columns(mass.inertia),
        "vertices": solid.vertices.ravel(),
        "faces": solid.faces.ravel(),
        "graph": reeb.pack(reeb.extract(solid, settings.similarity)),
    }
