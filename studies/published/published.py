"""The tables of README.md: published detectors under their own protocols, and side by side.

    python studies/published/published.py OUT --vgn FILE --ggcnn FILE --ggcnn2 FILE \
        --edge-grasp-repository FOLDER --edge-grasp COMMAND --contact-graspnet COMMAND

clears up to `--rounds` tables for each row, ten rounds of each row before the next ten of any, and
prints the tables. Results in OUT are not repeated; `--show` prints what there is, and `--only`
names the rows to run. OUT/ROW.parquet has a row when all its rounds are done. The repository of
EdgeGrasp has the household scans that VGN, GIGA and EdgeGrasp were tested with.
"""

import argparse
import json
import pickle
import shlex
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh

import egad
from egad._util.files import atomic_output
from egad.bench import Clutter, ClutterParameters, ClutterProtocol, rounds_of
from egad.bench.clearing import clear_rounds
from egad.bench.parameters import NAMED_ERRORS
from egad.bench.preparation import SceneObject, prepare_objects
from egad.bench.stats import Mean, clearing_rates
from egad.detectors import DetectorConfig
from egad.geometry import MassProperties
from egad.grippers import GRIPPERS
from egad.objects import named_meshes
from egad.sim.model import model_of
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.grasping import GRASPS

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmark"))
from protocols import FACTORS, OURS, FixedMass, Setup, changed

CHUNK = 10
HAND = GRIPPERS["panda"]
DETECTORS = ("ggcnn", "ggcnn2", "vgn", "contact-graspnet", "edge-grasp")


class Row(NamedTuple):
    """One row of a table.

    Attributes:
        part: The table: own, piles, piles-meshes (without convex hulls), noise or leaderboard.
        detector: One of the detectors of `detectors`.
        objects: A set of objects, from `sets`.
        clutter: The scenes and rules.
        changes: Changes to the objects, as in studies/benchmark/protocols.py.
    """

    part: str
    detector: str
    objects: str
    clutter: Clutter
    changes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The name of its folder."""
        return f"{self.part}-{self.detector}-{self.objects}"


def rows() -> list[Row]:
    """All rows, in the order in which they are run."""
    made = []
    for detector, protocol in (("vgn", "vgn"), ("edge-grasp", "edgegrasp")):
        for scene in ("packed", "pile"):
            clutter = Clutter(rounds=100, scenes=(scene,), protocol=protocol)
            mass = "500g-" if detector == "edge-grasp" else ""
            made.append(Row("own", detector, f"household-{mass}{scene}", clutter))
    last = Setup()
    for change in FACTORS.values():
        last = last.then(change)
    for detector in ("vgn", "contact-graspnet", "edge-grasp"):
        least = {"vgn": 0.5}.get(detector)
        rules = ClutterProtocol(**{**dict(OURS), **last.protocol, "threshold": least})
        clutter = Clutter(
            rounds=100, scenes=("pile",), protocol=rules, noise=("none",), engine="pybullet"
        )
        made.append(Row("piles", detector, "evolved", clutter, last.objects))
        solid = tuple(change for change in last.objects if change != "hulls")
        made.append(Row("piles-meshes", detector, "evolved", clutter, solid))
    scenes = ("packed", "pile")
    typical = {"noise": ("stereo",), "errors": NAMED_ERRORS["typical"]}
    for detector in DETECTORS:
        clutter = Clutter(rounds=40, scenes=scenes, **typical)
        made.append(Row("leaderboard", detector, "evolved", clutter))
        clutter = Clutter(rounds=100, scenes=scenes, noise=("none", "stereo"))
        made.append(Row("noise", detector, "evolved", clutter))
    return made


def detectors(given: argparse.Namespace) -> dict[str, DetectorConfig]:
    """The detectors by name."""
    return {
        "vgn": DetectorConfig(detector="vgn", weights=given.vgn),
        "ggcnn": DetectorConfig(detector="ggcnn", weights=given.ggcnn),
        "ggcnn2": DetectorConfig(detector="ggcnn", weights=given.ggcnn2),
        "edge-grasp": DetectorConfig(command=tuple(shlex.split(given.edge_grasp))),
        "contact-graspnet": DetectorConfig(command=tuple(shlex.split(given.contact_graspnet))),
    }


def household(folder: Path, mass: float | None = None) -> Iterator[SceneObject]:
    """The scans in a folder of VGN's object set: a URDF, a mesh to see and one to touch for each.

    As in PyBullet, each group of the second mesh is a convex hull, the mass does not depend on the
    size, and the center of mass is the origin of the file. EdgeGrasp gives all the same `mass`.
    """
    for path in sorted(folder.glob("*.urdf")):
        mesh = trimesh.load(path.with_name(f"{path.stem}_visual.obj"), force="mesh", process=False)
        parts = list(groups(path.with_name(f"{path.stem}_collision.obj")))
        kilograms = mass or float(path.read_text().split('mass value="')[1].split('"')[0])
        hull = trimesh.util.concatenate(parts)
        box = np.diag(np.ptp(hull.vertices, axis=0) ** 2)
        inertia = kilograms / 12 * (np.trace(box) * np.eye(3) - box)
        physics = MassProperties(hull.volume, hull.area, np.zeros(3), kilograms, inertia)
        model = FixedMass(**vars(model_of(mesh, parts, physics, 0.0)), fixed=kilograms)
        yield SceneObject(path.stem, model, parquet.empty(GRASPS))


def groups(path: Path) -> Iterator[trimesh.Trimesh]:
    """The convex hull of each group of an OBJ file."""
    vertices: list[list[float]] = []
    faces: list[list[int]] = [[]]
    for line in path.read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append([float(word) for word in words[:3]])
        elif kind in ("o", "g") and faces[-1]:
            faces.append([])
        elif kind == "f":
            faces[-1].extend(int(word.split("/")[0]) - 1 for word in words)
    for used in filter(None, faces):
        yield trimesh.convex.convex_hull(np.array(vertices)[np.unique(used)])


def sets(given: argparse.Namespace) -> dict[str, Callable[[], list[SceneObject]]]:
    """How objects are made."""
    scans = Path(given.edge_grasp_repository) / "data_robot/urdfs"
    return {
        "evolved": lambda: prepare_objects(
            named_meshes(egad.load("evaluation-set")), HAND, "paper"
        ),
        "household-packed": lambda: list(household(scans / "packed/test")),
        "household-pile": lambda: list(household(scans / "pile/test")),
        "household-500g-packed": lambda: list(household(scans / "packed/test", 0.5)),
        "household-500g-pile": lambda: list(household(scans / "pile/test", 0.5)),
    }


def prepared(path: Path, make: Callable[[], list[SceneObject]]) -> list[SceneObject]:
    """The objects of a set, made once."""
    if not path.exists():
        with atomic_output(path) as out:
            out.write_bytes(pickle.dumps(make()))
    return pickle.loads(path.read_bytes())  # type: ignore[no-any-return]  # noqa: S301 (this file is ours)


def clear(row: Row, first: int, objects: list[SceneObject], given: argparse.Namespace) -> None:
    """Clear ten tables of each kind of scene and noise, if that was not done."""
    path = Path(given.out) / row.name / f"{first:02}.parquet"
    if path.exists() or first >= row.clutter.rounds:
        return
    settings = ClutterParameters(
        seed=0, gripper=HAND, clutter=row.clutter, planning_time=given.planning_time
    )
    known = list(changed(objects, row.changes))
    todo = [
        each
        for each in rounds_of([one.id for one in known], settings)
        if first <= each.number < first + CHUNK
    ]
    table, seconds = clear_rounds(
        todo, {each.id: each for each in known}, detectors(given)[row.detector], settings
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".json").write_text(json.dumps(seconds))
    parquet.write(table, CLUTTER, path)
    print(row.name, first, flush=True)


def print_rows(out: Path, chosen: list[Row]) -> None:
    """Print a line for each row, kind of scene and noise."""
    print("| row | scenes | noise | rounds | success | cleared | seconds |\n" + "| --- " * 7 + "|")
    for row in chosen:
        paths = sorted((out / row.name).glob("*.parquet"))
        if not paths:
            continue
        table = pd.concat([parquet.read(path, CLUTTER) for path in paths])
        if len(paths) * CHUNK == row.clutter.rounds:
            order = {name: n for n, name in enumerate((*row.clutter.scenes, *row.clutter.noises))}
            whole = table.sort_values(["scene", "noise"], key=lambda c: c.map(order), kind="stable")
            parquet.write(whole, CLUTTER, out / f"{row.name}.parquet")
        seconds = [s for path in paths for s in json.loads(path.with_suffix(".json").read_text())]
        for each in clearing_rates(table):
            cells = [row.name, each.scene, each.noise, each.rounds]
            cells += [percent(each.success), percent(each.cleared), f"{np.median(seconds):.2g}"]
            print("| " + " | ".join(map(str, cells)) + " |")


def percent(rate: Mean) -> str:
    """A rate and its interval."""
    value, low, high = 100 * np.array([rate.value, *rate.interval])
    return f"{value:.0f} ({low:.0f} to {high:.0f})"


def main(given: argparse.Namespace) -> None:
    """Run what is missing, and print the tables."""
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    chosen = [row for row in rows() if not given.only or row.name in given.only]
    made: dict[str, list[SceneObject]] = {}
    for first in range(0, 0 if given.show else given.rounds, CHUNK):
        for row in chosen:
            name = row.objects
            if name not in made:
                made[name] = prepared(out / f"{name}.pickle", sets(given)[name])
            clear(row, first, made[name], given)
    print_rows(out, chosen)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    names = ("vgn", "ggcnn", "ggcnn2", "edge-grasp-repository", "edge-grasp", "contact-graspnet")
    for name in names:
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--planning-time", type=float, default=60.0)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--show", action="store_true", help="only print what there is")
    main(parser.parse_args())
