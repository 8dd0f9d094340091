"""Objects in 3D with their labelled grasps: packed data, and a page with one object.

Each object is one block of bytes, compressed, as base64. Coordinates are whole steps of its box.
Vertices and faces are differences from the one before, which compress well. `scene3d.js` unpacks
them.
"""

import base64
import html
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import trimesh
from numpy.typing import NDArray

from egad._util.files import as_path, write_text
from egad.errors import UserError
from egad.geometry import check_mesh
from egad.grasps import Grasps
from egad.grippers import Gripper, as_gripper
from egad.io import read_mesh
from egad.report.hand_shape import best_grasp
from egad.report.page import render_template
from egad.tables import parquet
from egad.tables.columns import ID, LABEL
from egad.tables.grasping import GRASPS
from egad.tables.objects import REJECTED
from egad.tables.parquet import empty

STEPS = 2**13 - 1  # a hundredth of a millimetre for an object of 10 cm
UNIT = 2**15 - 1
METRICS = {"quality": "quality", "robust_quality": "robust quality"}
LABELS = ("not simulated", "held in simulation", "failed in simulation", "in collision")
NEARBY = 0.01  # of the longest side; contacts may be this far outside the box
TOP = 0.98  # quantile of the quality that gets the last color


@dataclass(frozen=True)
class GraspScene:
    """An object, metres, as it is grasped, with its grasps."""

    name: str
    title: str
    mesh: trimesh.Trimesh
    # columns contact0, contact1, approach (each with x, y and z), quality, robust_quality and
    # collision_free of `tables.grasping.GRASPS`, in the frame of the mesh; `simulated_success`, if
    # it is there, is packed too
    grasps: pd.DataFrame
    note: str = ""  # a remark, such as why it has no grasps
    # number of a color in `scene3d.js` for each face; all are gray if None
    paint: NDArray[np.uint8] | None = None


def viewer_data(scenes: Sequence[GraspScene], gripper: Gripper) -> dict[str, Any]:
    """What the script of the viewer reads, ready for JSON; `finger` is in metres."""
    return {
        "finger": -gripper.kind.span[0],
        "objects": [pack(scene) for scene in scenes],
        "metrics": [[key, name, _top(scenes, key)] for key, name in METRICS.items()],
    }


def pack(scene: GraspScene) -> dict[str, Any]:
    """One object for the viewer.

    `name`, `title`, `note`; `counts` of vertices, faces and grasps; `origin` and `step`, which
    convert coordinates to metres; and `data`: the following little-endian arrays, one after the
    other, compressed by zlib, as base64. Faces and vertices (see `_zigzag`), each metric (32-bit
    float), contacts (16 bit), approaches (signed 16 bit, in 1 / 32767), whether the grasp is free
    of collision (8 bit), colors of faces (8 bit), if it is `painted`, and positions in `LABELS` (8
    bit), if the grasps are `labelled` by simulation.
    """
    vertices, faces = np.asarray(scene.mesh.vertices), np.asarray(scene.mesh.faces)
    origin = vertices.min(axis=0)
    step = float(np.ptp(vertices, axis=0).max()) / STEPS
    contacts = scene.grasps[_columns("contact0", "contact1")].to_numpy().reshape(-1, 3)
    approach = scene.grasps[_columns("approach")].to_numpy()
    blocks = [
        _zigzag(faces),
        _zigzag(_steps(vertices, origin, step)),
        *(scene.grasps[key].to_numpy().astype("<f4") for key in METRICS),
        _steps(contacts, origin, step),
        np.round(approach * UNIT).astype("<i2"),
        scene.grasps["collision_free"].to_numpy().astype("u1"),
        *([] if scene.paint is None else [scene.paint]),
    ]
    labelled = "simulated_success" in scene.grasps
    if labelled:
        blocks.append(label_codes(scene.grasps))
    compressed = zlib.compress(b"".join(block.tobytes() for block in blocks), 9)
    return {
        "name": scene.name,
        "title": scene.title,
        "note": scene.note,
        "counts": [len(vertices), len(faces), len(scene.grasps)],
        "painted": scene.paint is not None,
        "labelled": labelled,
        "origin": origin.tolist(),
        "step": step,
        "data": base64.b64encode(compressed).decode(),
    }


def label_codes(grasps: pd.DataFrame) -> NDArray[np.uint8]:
    """Positions in `LABELS` of grasps, (n,); without an outcome, and if not free: not simulated."""
    free, held = grasps["collision_free"], grasps["simulated_success"]
    codes = np.select([~free.astype(bool), held.isna(), held.eq(True)], [3, 0, 1], 2)
    return codes.astype(np.uint8)


def page(scene: GraspScene, name: str | None, gripper: Gripper) -> str:
    """An HTML page with one object by itself, the hand at its best grasp, its name if any."""
    scenes = [scene]
    if (held := best_grasp(scene.mesh, scene.grasps, gripper)) is not None:
        mesh, paint = held
        scenes.append(GraspScene("hand at best grasp", "", mesh, empty(GRASPS), paint=paint))
    data = viewer_data(scenes, gripper)
    return render_template("view.html.j2", scene=scene, name=name, gripper=gripper, viewer=data)


def _columns(*names: str) -> list[str]:
    return [f"{name}_{axis}" for name in names for axis in "xyz"]


def _steps(
    points: NDArray[np.float64], origin: NDArray[np.float64], step: float
) -> NDArray[np.uint16]:
    """Points as whole steps from the origin, clipped to the box."""
    return np.clip(np.round((points - origin) / step), 0, STEPS).astype("<u2")


def _zigzag(rows: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Differences of rows, sign in the lowest bit, 32 bit, low bytes first: runs of zeros."""
    steps = rows.astype(np.int64)
    steps[1:] -= rows[:-1]
    folded = ((steps << 1) ^ (steps >> 63)).astype("<u4")
    return np.ascontiguousarray(folded.reshape(-1, 1).view(np.uint8).T)


def _top(scenes: Sequence[GraspScene], key: str) -> float:
    values = np.concatenate([scene.grasps[key].to_numpy(dtype=float) for scene in scenes])
    top = float(np.quantile(values, TOP)) if len(values) else 0.0
    return top if top > 0 else 1e-3


@dataclass(frozen=True, repr=False)
class MeshView:
    """An interactive view in 3D: shown by notebooks, or saved as a page.

    Attributes:
        html: A whole HTML page that needs no other file and no network.
    """

    html: str

    def __repr__(self) -> str:
        return "MeshView: save('view.html') writes a page; a notebook shows it"

    def save(self, path: str | Path) -> None:
        """Write the page, atomically.

        Raises:
            UserError: The path is invalid or cannot be written.
        """
        write_text(as_path("path", path), self.html)

    def _repr_html_(self) -> str:
        page = html.escape(self.html)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 640px; border: 0"></iframe>'


def view(
    mesh: trimesh.Trimesh,
    grasps: Grasps | None = None,
    gripper: Gripper | str | None = None,
    *,
    title: str = "",
) -> MeshView:
    """Show a mesh in 3D, with grasps.

    Args:
        mesh: The mesh, metres.
        grasps: Grasps in the frame of the mesh; none if omitted.
        gripper: The gripper of the grasps, or its name; its fingers are drawn. Needed with grasps.
        title: Shown above the view.

    Raises:
        UserError: There is no gripper of this name, or none is given for grasps; `mesh` is not a
            mesh; `grasps` are not `egad.Grasps`, or are of a mesh in another frame or at another
            scale.
        RejectedError: The mesh is empty or not finite.
    """
    check_mesh(mesh)
    if not isinstance(grasps, Grasps | None):
        raise UserError(
            f"grasps are egad.Grasps, got {type(grasps).__name__}; "
            "`egad.Grasps(table)` makes them from a table"
        )
    _check_contacts(mesh, grasps)
    if grasps is not None and gripper is None:
        raise UserError("grasps are drawn with the fingers of a gripper: name one, such as 'panda'")
    name = gripper if isinstance(gripper, str | None) else ""
    hand = as_gripper("panda" if gripper is None else gripper)  # any, if nothing is drawn of it
    rows = empty(GRASPS) if grasps is None else grasps.to_frame()
    return MeshView(page(GraspScene(title or "mesh", "", mesh, rows), name, hand))


def _check_contacts(mesh: trimesh.Trimesh, grasps: Grasps | None) -> None:
    if grasps is None or len(grasps) == 0:
        return
    low, high = np.asarray(mesh.bounds)
    margin = NEARBY * float((high - low).max())
    contacts = grasps.contacts
    if (contacts < low - margin).any() or (contacts > high + margin).any():
        raise UserError(
            "the grasps do not touch the mesh: were they sampled on it, in the same frame and "
            "at the same scale?"
        )


def scenes(
    folder: Path, gripper: str, evalset: pd.DataFrame, grasps: pd.DataFrame
) -> list[GraspScene]:
    """The objects of an evaluation set that could be scaled to the gripper, named as in the set."""
    meshes = folder / "rescaled" / gripper
    return [
        scene(folder, gripper, label, grasps, name=name)
        for name, label in zip(evalset["label"], evalset["object_label"], strict=True)
        if (meshes / f"{label}.obj").is_file()
    ]


def scene(
    folder: Path, gripper: str, label: str, grasps: pd.DataFrame, name: str | None = None
) -> GraspScene:
    """An object of a dataset, by its label or another name; a note says why it has no grasps."""
    mesh = read_mesh(folder / "rescaled" / gripper / f"{label}.obj", "m")
    own = grasps[grasps["label"] == label]
    note = "" if len(own) else _reason(folder, gripper, label)
    return GraspScene(name or label, label if name else "", mesh, own, note)


def _reason(folder: Path, gripper: str, label: str) -> str:
    """Why an object has no grasp, from the table of rejected objects."""
    objects = parquet.read(folder / "objects.parquet", pa.schema([ID, LABEL]))
    rejected = parquet.read(folder / "grasps" / f"{gripper}.rejected.parquet", REJECTED)
    own = rejected[rejected["id"].isin(objects.loc[objects["label"] == label, "id"])]
    return own["reason"].iloc[0] if len(own) else "no grasp"
