"""Parts and labelled grasps: `python studies/convex_parts/collision_parts.py results/D G [BUNDLE]`.

Makes the convex parts of the evaluation set of a dataset, scaled to gripper G, with the current
settings, and prints how deep the contacts of collision-free labelled grasps lie in them. BUNDLE is
another simulation bundle of the same objects, e.g. an older one: it is measured as well, and the
steps per second of both in MuJoCo are compared, with every object squeezed by two boxes on a plane.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import mujoco
import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from egad.exchange import write_simulation_object
from egad.geometry import Bundle, buried_share, largest_deviation, to_mesh, to_solid, union_of_parts
from egad.geometry.convex_parts import decompose
from egad.geometry.touchable import depths
from egad.io import read_mesh
from egad.sim import make_simulation_object
from egad.tables import parquet
from egad.tables.columns import vector_names
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import GRASPS

Floats = NDArray[np.float64]

DENSITY = 400.0
WARM_UP, STEPS, ROUNDS = 200, 500, 3
WORLD = """<mujoco><worldbody><geom type="plane" size="1 1 .1"/>
<body name="left" pos="{left} 0 .05"><joint name="l" type="slide" axis="1 0 0"/>
<geom type="box" size=".01 .02 .05" mass="1"/></body>
<body name="right" pos="{right} 0 .05"><joint name="r" type="slide" axis="1 0 0"/>
<geom type="box" size=".01 .02 .05" mass="1"/></body></worldbody>
<actuator><motor joint="l"/><motor joint="r"/></actuator></mujoco>"""


def main(results: Path, gripper: str, other: Path | None = None) -> None:
    """Print figures of the parts made now, and of those in another bundle."""
    chosen = parquet.records(parquet.read(results / "eval49.parquet", EVAL49))
    grasps = parquet.read(results / f"grasps/{gripper}.parquet", GRASPS)
    grasps = grasps[grasps["collision_free"]]
    now, before, speeds = [], [], []
    for row in chosen:
        mesh = read_mesh(results / f"rescaled/{gripper}/{row['object_label']}.obj", "m")
        contacts = _contacts(grasps[grasps["label"] == row["object_label"]])
        now.append({"label": row["label"], **_figures(mesh, contacts, *made(mesh))})
        if other:
            files = sorted((other / row["label"] / "parts").glob("*.obj"))
            parts = [read_mesh(file, "m") for file in files]
            before.append({"label": row["label"], **_figures(mesh, contacts, parts, np.nan)})
            speeds.append(_speeds(row["label"], mesh, other))
    for name, rows in (("now", now), ("other bundle", before)):
        if rows:
            print(f"{name}\n{_summary(pd.DataFrame(rows).set_index('label'))}\n")
    if speeds:
        ratios = np.divide(*np.transpose(speeds))
        total = np.divide(*(1 / np.transpose(speeds)).sum(axis=1)[::-1])
        print(
            f"steps per second, now / other: all {total:.2f}, median {np.median(ratios):.2f},"
            f" from {ratios.min():.2f} to {ratios.max():.2f}"
        )


def made(mesh: trimesh.Trimesh) -> tuple[list[trimesh.Trimesh], float]:
    """Convex parts by the default settings, and the CPU time that they took, s."""
    wanted = Bundle()
    start = process_time()
    found = decompose(
        mesh, wanted.max_parts, wanted.volume_error, wanted.deviation, wanted.max_vertices
    )
    return found.parts, process_time() - start


def _contacts(grasps: pd.DataFrame) -> Floats:
    """The contacts of grasps, (2, n, 3)."""
    return np.stack([grasps[vector_names(f"contact{k}")].to_numpy() for k in (0, 1)])


def _figures(
    mesh: trimesh.Trimesh, contacts: Floats, parts: list[trimesh.Trimesh], seconds: float
) -> dict[str, float]:
    deep = np.full(contacts.shape[:2], -np.inf)
    for part in parts:
        planes = ConvexHull(part.vertices).equations
        found = depths(contacts.reshape(-1, 3), planes).reshape(deep.shape)
        deep = np.maximum(deep, found)
    together = union_of_parts(parts)
    beyond = together - to_solid(mesh.vertices, mesh.faces)
    return {
        "contacts": deep.size,
        "deep": (deep > 0.0005).sum(),
        "very deep": (deep > 0.001).sum(),
        "grasps": deep.shape[1],
        "deep grasps": (deep > 0.0005).any(axis=0).sum(),
        "very deep grasps": (deep > 0.001).any(axis=0).sum(),
        "parts": len(parts),
        "vertices": max(len(part.vertices) for part in parts),
        "volume error": together.volume() / abs(mesh.volume) - 1,
        "deviation": largest_deviation(to_mesh(beyond), mesh),
        "buried": buried_share(mesh, parts, 0.0005),
        "seconds": seconds,
    }


def _summary(found: pd.DataFrame) -> str:
    lines = []
    for kind in ("contacts", "grasps"):
        for depth, name in (("0.5", "deep"), ("1", "very deep")):
            of = found[name if kind == "contacts" else f"{name} grasps"]
            shares = 100 * of / found[kind]
            lines.append(
                f"{kind} more than {depth} mm inside a part:"
                f" {100 * of.sum() / found[kind].sum():.2f} %,"
                f" worst object {shares.max():.1f} % ({shares.idxmax()})"
            )
    factors = {"parts": 1, "vertices": 1, "volume error": 100, "deviation": 1000, "buried": 100}
    for name, factor in factors.items():
        values = factor * found[name]
        lines.append(
            f"{name}: from {values.min():.2f}, median {values.median():.2f},"
            f" to {values.max():.2f} ({values.idxmax()})"
        )
    lines.append(f"parts in all: {found['parts'].sum()}")
    lines.append(f"CPU time: {found['seconds'].sum(skipna=False):.0f} s")
    return "\n".join(lines)


def _speeds(label: str, mesh: trimesh.Trimesh, other: Path) -> tuple[float, float]:
    """Steps per second with the parts made now and with those of another bundle."""
    with TemporaryDirectory() as folder:
        write_simulation_object(
            Path(folder) / label, label, make_simulation_object(mesh, DENSITY, Bundle()), 0.5
        )
        models = [_squeezed(root / label / f"{label}.xml", mesh) for root in (Path(folder), other)]
    seconds = np.array([[_seconds(model) for model in models] for _ in range(ROUNDS)])
    now, before = STEPS / seconds.min(axis=0)
    return now, before


def _squeezed(file: Path, mesh: trimesh.Trimesh) -> mujoco.MjModel:
    """An object on a plane, between two boxes."""
    low, high = np.asarray(mesh.bounds)
    text = WORLD.format(left=low[0] - 0.015, right=high[0] + 0.015)
    world = mujoco.MjSpec.from_string(text)
    frame = world.worldbody.add_frame(pos=[0, -(low[1] + high[1]) / 2, -low[2] + 0.001])
    world.attach(mujoco.MjSpec.from_file(str(file)), prefix="object-", frame=frame)
    return world.compile()


def _seconds(model: mujoco.MjModel) -> float:
    data = mujoco.MjData(model)
    data.ctrl[:] = [5.0, -5.0]
    mujoco.mj_step(model, data, WARM_UP)
    start = perf_counter()
    mujoco.mj_step(model, data, STEPS)
    return perf_counter() - start


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], *map(Path, sys.argv[3:]))
