"""rescale: meshes scaled to a gripper."""

import logging
from pathlib import Path

import pandas as pd

from egad import tables
from egad.errors import RejectedError
from egad.exchange.meshes import object_names, read_mesh, write_obj, write_stl_mm
from egad.files import replacing
from egad.progress import progress
from egad.shapes.scale import rescale
from egad.stage_settings import RescaleMeshes
from egad.stages.shards import rejection

log = logging.getLogger(__name__)
WRITERS = {"obj": write_obj, "stl": write_stl_mm}


def run(
    settings: RescaleMeshes, files: list[Path], units: str, out: Path, ending: str = "obj"
) -> int:
    """Scale every mesh by the rule and write it, with a table of what was done.

    Args:
        settings: Gripper and rule.
        files: Meshes in any format that can be read.
        units: Unit of their coordinates.
        out: Folder for `NAME.obj` (metres) or `NAME.stl` (millimetres) and `scales.parquet`.
        ending: `obj` or `stl`.

    Returns:
        How many files could not be read; `rejected.parquet` names them.
    """
    scales, left_out = [], []
    rule = settings.rescale
    with replacing(out) as folder:
        folder.mkdir()
        for name, path in progress(object_names(files).items(), "scaling", len(files)):
            try:
                mesh = read_mesh(path, units)
                scaled, row = rescale(mesh, rule.rule, settings.gripper.opening, rule.side_fraction)
            except RejectedError as reason:
                left_out.append(rejection(path.name, "rescale", reason))
            else:
                WRITERS[ending](scaled, folder / f"{name}.{ending}")
                scales.append({"label": name, **row})
        tables.write(pd.DataFrame(scales), tables.SCALES, folder / "scales.parquet")
        tables.write(pd.DataFrame(left_out), tables.REJECTED, folder / "rejected.parquet")
    log.info("%d meshes scaled by rule %s, %d rejected", len(scales), rule.rule, len(left_out))
    return len(left_out)
