"""acronym: labelled grasps as ACRONYM files."""

import logging
from pathlib import Path
from typing import Any

import numpy as np

from egad._util.files import atomic_output, check_not_file
from egad.errors import UserError
from egad.exchange import Body, Jaws, check_key, is_ours, write_acronym
from egad.exchange.exports._simulated import check_simulated, simulated_by_object
from egad.exchange.parameters import AcronymFiles
from egad.grippers import finger_span
from egad.tables import parquet
from egad.tables.columns import inertia_tensor
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS

log = logging.getLogger(__name__)


def run(
    settings: AcronymFiles,
    gripper: str,
    objects: Path,
    scales: Path,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write a file for each object that has grasps.

    Args:
        settings: Settings of this format.
        gripper: Name of the gripper.
        objects: Table with the columns of `tables.objects.OBJECTS`.
        scales: Table with the columns of `tables.grasping.SCALES`.
        simulated_grasps: Table with the columns of `tables.grasping.SIMULATED_GRASPS`, sorted by
            label.
        out: The labelled grasps for gripper G as ACRONYM files; the root of their meshes is `D`.
            Made if `targets.exports` contains `acronym`. See `docs/exchange.md`.

    Raises:
        UserError: A name is not allowed, tables do not match, the grasps have no simulated labels,
            or the folder has other files.
    """
    check_not_file(out)
    if foreign := [path.name for path in sorted(out.glob("*")) if not is_ours(path)]:
        raise UserError(
            f"--out {out}: {foreign[0]} is no earlier export and would be lost; "
            "name a folder of its own"
        )
    check_key(gripper, "gripper")
    check_simulated(simulated_grasps)
    table = parquet.read(objects, OBJECTS)
    factors = parquet.read(scales, SCALES).set_index("label")["factor"].to_dict()
    known = {row["label"]: row for row in parquet.records(table) if row["label"] in factors}
    jaws = Jaws(gripper, settings.gripper.opening, finger_span(settings.gripper)[1])
    written = 0
    with atomic_output(out, keep=False) as folder:
        folder.mkdir()
        for label, found in simulated_by_object(simulated_grasps):
            if label not in known:
                raise UserError(
                    f"{simulated_grasps}: object {label!r} is not in {objects} and {scales}"
                )
            body = scaled_body(known[label], factors[label], settings.quality.friction)
            path = folder / f"{check_key(label)}.h5"
            write_acronym(path, body, jaws, found, settings.acronym.min_robust_success_rate)
            written += 1
    log.info("%d objects", written)


def scaled_body(row: dict[str, Any], factor: float, friction: float) -> Body:
    """The object of a row of `tables.objects.OBJECTS`, scaled about the origin of its mesh."""
    return Body(
        file=f"meshes/{row['label']}.obj",
        scale=factor,
        volume=row["volume"] * factor**3,
        mass=row["mass"] * factor**3,
        com=factor * np.array([row[f"com_{part}"] for part in "xyz"]),
        inertia=inertia_tensor(row) * factor**5,
        friction=friction,
    )
