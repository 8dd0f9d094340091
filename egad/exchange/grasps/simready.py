"""SimReady props for Isaac Sim: objects as OpenUSD, with a line for each grasp that held.

They follow the profile Robotics-Prop 4.0.0 of NVIDIA's SimReady Foundation, with its feature of
grasps: a line runs along the closing axis, through both contacts, from pad to pad of the open hand.

    /NAME                              the object, as `egad.exchange.objects.usd` has it
    /NAME/grasps/grasp_identifier_001  a line in the frame of the mesh; the best grasp comes first
"""

import logging
import os
import time
from collections.abc import Hashable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdSemantics, UsdShade, Vt

from egad import __version__
from egad._util.arrays import Singles
from egad._util.display import thumbnail
from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import SIMULATED_COLUMNS, by_object, check_simulated
from egad.exchange.hdf5 import check_key
from egad.exchange.object_files import write_poses
from egad.exchange.objects import usd
from egad.exchange.parameters import AllObjects, NamedGripper
from egad.exchange.whole_sets import write_all
from egad.geometry import Bundle
from egad.grasps import Grasps, hand_poses
from egad.grippers import hand_body
from egad.sim import SimulationObject
from egad.tables.columns import vector_names

THUMBNAIL = 256  # pixels along each side
LINE_WIDTH = 0.001  # metres
LINE_COLOR = Gf.Vec3f(0.1, 0.7, 0.2)
MATERIAL = "plastic"
PHYSICAL_OBJECT = "Q223557"  # of Wikidata

KEYS, LINE = ({"usd"},), "grasp_identifier_"
NEEDED = {"center", "approach", "width", "robust_quality"}  # of a line that is read
log = logging.getLogger(__name__)


def held_at_the_end(grasps: pd.DataFrame) -> pd.DataFrame:
    """The grasps that succeeded in simulation, the most robust first; none without simulation."""
    held = grasps[grasps["simulated_success"].eq(True).fillna(False).to_numpy(dtype=bool)]
    return held.sort_values("robust_quality", ascending=False, kind="stable")


def write_simready(
    folder: Path,
    label: str,
    made: SimulationObject,
    friction: float,
    grasps: pd.DataFrame,
    hand: NamedGripper,
) -> None:
    """Write the folder `LABEL/simready`: USD with grasps that held, thumbnail, poses."""
    held = held_at_the_end(grasps)
    if held.empty:
        log.warning("%s has no grasp that held in simulation: its prop has no grasp lines", label)
    stage = usd.make_stage(label, made, friction)
    _add_semantics(stage, label)
    _add_lines(stage, held, hand)
    _add_metadata(stage, label, made)
    inner = folder / label / "simready"
    thumbnails = inner / f".thumbs/{THUMBNAIL}x{THUMBNAIL}"
    thumbnails.mkdir(parents=True)
    (thumbnails / f"{label}.usd.png").write_bytes(thumbnail(made.mesh, THUMBNAIL))
    usd.save(stage, inner / f"{label}.usd")
    write_poses(inner, made)


def _add_lines(stage: Usd.Stage, held: pd.DataFrame, hand: NamedGripper) -> None:
    """A line for each grasp, between the pads of the open hand; a fixed jaw is at its contact."""
    if held.empty:
        return
    scope = UsdGeom.Scope.Define(stage, stage.GetDefaultPrim().GetPath().AppendChild("grasps"))
    grasps, opening = Grasps(held), hand.gripper.opening
    poses, widths = grasps.poses, grasps.widths
    middles = hand_body(hand.gripper).aside(widths, np.full_like(widths, opening))
    ends = middles + opening * np.array([[-0.5], [0.5]])
    reach = ends[:, :, None] * poses[:, :3, 0]
    lines = np.swapaxes(poses[:, :3, 3] + reach, 0, 1)
    for number, (line, row) in enumerate(zip(lines, held.to_dict("records"), strict=True), 1):
        path = scope.GetPath().AppendChild(f"{LINE}{number:03d}")
        curve = _define_line(stage, path, line.astype(np.float32))
        curve.GetPrim().SetCustomDataByKey("egad", _about(row, hand.name))


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps that have a line of `write_simready`, in the frame of the prop.

    Closing axes are those of the lines, in single precision. Lines of others have no approach.
    """
    try:
        stage = Usd.Stage.Open(str(content["usd"]), Usd.Stage.LoadNone)
    except Tf.ErrorException as error:
        raise UserError("it is not a file of OpenUSD, or it is damaged") from error
    prop, cache = stage.GetDefaultPrim(), UsdGeom.XformCache()
    prims = (
        [each for each in Usd.PrimRange(prop) if each.GetName().startswith(LINE)] if prop else []
    )
    about = [prim.GetCustomDataByKey("egad") or {} for prim in prims]
    if not prims:
        raise UserError(f"it has no grasp lines, {LINE}..., under its default prim")
    if lacking := sum(not each.keys() >= NEEDED for each in about):
        raise UserError(
            f"{lacking} of {len(prims)} grasp lines do not say where the hand comes from; lines "
            "that this version of egad exports have it: export it again"
        )
    rows: list[list[Gf.Vec3d]] = []
    for prim, each in zip(prims, about, strict=True):
        placed, _ = cache.ComputeRelativeTransform(prim, prop)
        start, end = map(placed.Transform, UsdGeom.BasisCurves(prim).GetPointsAttr().Get())
        center, ahead = placed.Transform(each["center"]), placed.TransformDir(each["approach"])
        rows.append([center, Gf.Vec3d(end - start).GetNormalized(), ahead])
    centers, axes, approaches = np.moveaxis(np.array(rows, np.float64), 1, 0)
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    return files.file_grasps(
        hand_poses(unit * centers, axes, approaches),
        files.hand_in_frame(options.frame or "x z", options.depth or 0.0),
        widths=[unit * each["width"] for each in about],
        success=1.0,  # grasps that failed have no line
        score=[each["robust_quality"] for each in about],
    )


def _define_line(stage: Usd.Stage, path: Sdf.Path, line: Singles) -> UsdGeom.BasisCurves:
    curve = UsdGeom.BasisCurves.Define(stage, path)
    points = Vt.Vec3fArray.FromNumpy(line)
    curve.CreateTypeAttr(UsdGeom.Tokens.linear)
    curve.CreateCurveVertexCountsAttr([2])
    curve.CreatePointsAttr(points)
    curve.CreateWidthsAttr([LINE_WIDTH])
    curve.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    curve.CreatePurposeAttr(UsdGeom.Tokens.guide)
    curve.CreateDisplayColorAttr([LINE_COLOR])
    curve.CreateExtentAttr(UsdGeom.Curves(curve).ComputeExtent(points, [LINE_WIDTH]))
    return curve


def _about(row: Mapping[Hashable, Any], gripper: str) -> dict[str, object]:
    """What was measured for a grasp. Each was simulated once."""
    center, approach = (
        Gf.Vec3d(*(row[name] for name in vector_names(vector))) for vector in ("center", "approach")
    )
    return {
        "gripper": gripper,
        "grasp": row["grasp"],
        "center": center,
        "approach": approach,
        "width": row["width"],
        "robust_quality": row["robust_quality"],
        "robust_success_rate": row["robust_success_rate"],
        "simulated_outcome": row["simulated_outcome"],
        "simulated_engine": row["simulated_engine"],
        "simulated_attempts": 1,
    }


def _add_semantics(stage: Usd.Stage, label: str) -> None:
    """Say what the object is, and what each material stands for."""
    UsdSemantics.LabelsAPI.Apply(stage.GetDefaultPrim(), "class").CreateLabelsAttr([label])
    for prim in Usd.PrimRange.AllPrims(stage.GetPrimAtPath(usd.MESHES)):
        if prim.IsA(UsdShade.Material):
            UsdSemantics.LabelsAPI.Apply(prim, "material").CreateLabelsAttr([MATERIAL])


def _add_metadata(stage: Usd.Stage, label: str, made: SimulationObject) -> None:
    """Add the origin of the prop, also where profiles before 3.2 read it."""
    about = {
        "author": f"egad {__version__}",
        "asset_name": label,
        "asset_type": "prop",
        "asset_license": "not stated",
        "category": "object to grasp",
        "source_file": f"{label}.obj",
        "usd_date_generated": _today(),
        "qcode": PHYSICAL_OBJECT,
        "rigid_body_count": 1,
        "asset_extents": Gf.Vec3f(*made.mesh.extents.tolist()),
        "mass": made.physics.mass,
    }
    stage.GetRootLayer().customLayerData = {**about, "SimReady_Metadata": about}


def _today() -> str:
    """The date, which the rules require; with SOURCE_DATE_EPOCH, the bytes are the same again."""
    moment = float(os.environ.get("SOURCE_DATE_EPOCH", time.time()))
    return datetime.fromtimestamp(moment, UTC).date().isoformat()


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Write one prop, with the friction of a new configuration: see `egad.exchange.registry`."""
    write_simready(folder, label, made, Bundle().friction, grasps, hand)


def run(
    settings: AllObjects,
    gripper: str,
    meshes: Path,
    convex_parts: Path,
    simulated_grasps: Path,
    out: Path,
) -> None:
    """Write a prop for each object that has convex parts."""
    check_simulated(simulated_grasps)
    hand = NamedGripper(gripper, settings.gripper)
    known = by_object(simulated_grasps, SIMULATED_COLUMNS)
    held = {label: held_at_the_end(rows) for label, rows in known}
    none = pd.DataFrame(columns=SIMULATED_COLUMNS)

    def write_prop(folder: Path, label: str, made: SimulationObject, friction: float) -> None:
        write_simready(folder, check_key(label), made, friction, held.get(label, none), hand)

    write_all(settings, write_prop, meshes, convex_parts, out)
