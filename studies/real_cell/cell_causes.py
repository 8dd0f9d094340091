"""The table of README.md that takes trials of GG-CNN closer to the robot of EGAD, step by step.

`cell_causes.py FOLDER NETWORK` tries GG-CNN, its grasps executed as published, on the evaluation
set of the release. Each condition changes what differs from the robot's published programs. NETWORK
is a file of weights of GG-CNN or GG-CNN2, or the model that the robot loads (.hdf5, from
dougsm/mvp_grasp). `--objects FOLDER` takes 49 published training objects (`M14_3.ply`, millimetres)
instead. Tables of attempts are kept in FOLDER.
"""

import argparse
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from string import ascii_uppercase
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd
import trimesh
from cell_errors import HAND, percent, table
from scipy.optimize import linear_sum_assignment

import egad
from egad._util.files import atomic_output
from egad.bench import TrialParameters, TrialProtocol, run_attempts
from egad.bench.stats import compare, mean_rate, object_positions, results, trend, trial_grid
from egad.detectors import GGCNN, Grasp, View, camera_above
from egad.detectors.ggcnn import MIN_TIP, MapDetector
from egad.grippers import Gripper
from egad.objects import NamedMesh, named_meshes
from egad.sim import ENGINES
from egad.sim.model import simulated

# where the crop, which lies 40 pixels above the middle of the image, sees the middle of the table
OBLIQUE = np.outer([0, 40 * 0.52 / 373, 0, 0], [0, 0, 0, 1])
CLOSES = {"contact": "close", "stopping_force": 10.0}
SLOW = {"egad.sim.execution.DESCENT_SPEED": 0.05}
VIEW = {
    "field_of_view": 81.3,  # degrees across 640 pixels if 480 span 65.5: a focal length of 373
    "camera_height": 0.52,
    "egad.bench.trial_runner.camera_above": lambda height: camera_above(height) - OBLIQUE,
    "crop_up": 40,
    "width": 0.928,  # 373 times the published 2 tan(65.5 degrees x 300 / 480 / 2) / 300
}
FILTERED = {"depth_noise": 0.025}  # each new image counts by 0.1: 0.23 times the noise
DOCUMENTED = CLOSES | SLOW | VIEW | FILTERED
NINE, TWENTY_ONE = ({"deeper": metres} for metres in (0.009, 0.021))
CONDITIONS: dict[str, dict[str, Any]] = {
    "baseline": {},
    "no errors of the cell": {"errors": "none"},
    "hand opens 100 mm": {"opening": 0.1},
    "view and crop": VIEW,
    "noise filtered": FILTERED,
    "contact closes": CLOSES,
    "descent 50 mm/s": SLOW,
    "fingertips 9 mm deeper": NINE,
    "fingertips 21 mm deeper": TWENTY_ONE,
    "force 2 N": {"force": 2.0},
    "friction 0.4": {"friction": 0.4},
    "longest side 75 mm": {"rule": "egad-script"},
    "always dropped anew": {"reset": "redrop"},
    "dropped upright": {"egad.bench.trial_runner.TILT": 0.0},
    "documented": DOCUMENTED,
    "documented, 9 mm deeper": DOCUMENTED | NINE,
    "documented, 21 mm deeper": DOCUMENTED | TWENTY_ONE,
    "documented, 21 mm deeper, 2 N": DOCUMENTED | TWENTY_ONE | {"force": 2.0},
    "documented, 21 mm deeper, friction 0.4": DOCUMENTED | TWENTY_ONE | {"friction": 0.4},
    "documented, 21 mm deeper, 75 mm": DOCUMENTED | TWENTY_ONE | {"rule": "egad-script"},
}
TITLES = ["success", "difference", "row A", "row G", "C-G: simple", "C-G: others", "rho"]
TITLES += ["no aborts", "widths cut", "missed", "slipped or dropped"]


class AsOnTheRobot:
    """GG-CNN as published, with the crop, the widths and the fingertips of a condition."""

    def __init__(self, detect: MapDetector, changes: dict[str, Any]) -> None:
        self._detect, self._changes = detect, changes

    def __call__(self, view: View, gripper: Gripper, rng: np.random.Generator) -> list[Grasp]:
        """The grasp that the robot would be sent, with the height that its fingertips reach."""
        rows = len(view.depth) - 2 * self._changes.get("crop_up", 0)  # their middle is the crop
        wide = gripper.model_copy(update={"opening": 1.0})
        grasps = self._detect(replace(view, depth=view.depth[:rows]), wide, rng)
        return [self._executed(grasp, gripper.opening) for grasp in grasps]

    def _executed(self, grasp: Grasp, opening: float) -> Grasp:
        tip = max(grasp.tip - self._changes.get("deeper", 0.0), MIN_TIP)
        width = min(grasp.width * self._changes.get("width", 1.0), opening)
        return replace(grasp, depth=grasp.center[2] - tip, width=width)


def published(folder: Path) -> Iterator[NamedMesh]:
    """For each cell of a 7 x 7 grid of difficulty and complexity, another object near it."""
    paths = sorted(folder.glob("*.ply"))
    at = np.array([(ascii_uppercase.index(p.stem[0]) / 24, int(p.stem[1:3]) / 26) for p in paths])
    cells = list(np.ndindex(7, 7))
    far = np.linalg.norm((np.array(cells)[:, None] + 0.5) / 7 - at - (1 / 48, 1 / 52), axis=2)
    for (i, j), chosen in zip(cells, linear_sum_assignment(far)[1], strict=True):
        path = paths[chosen]
        yield NamedMesh(f"{ascii_uppercase[i]}{j}", path.stem, partial(_read, path))


def _read(path: Path) -> trimesh.Trimesh:
    mesh = trimesh.load_mesh(path)
    mesh.apply_scale(0.001)
    return mesh


@cache
def models(objects: Path | None, rule: str) -> list[Any]:
    """Label, id and model of all objects."""
    targets = published(objects) if objects else named_meshes(egad.load("evaluation-set"))
    return [(each.label, each.id, simulated(each, HAND, rule)[1]) for each in targets]


def attempts(made: list[Any], detect: MapDetector, changes: dict[str, Any]) -> pd.DataFrame:
    """All attempts at all objects; `changes` of trials, hand, constants and the robot's program."""
    of_trials, of_hand = (
        {key: value for key, value in changes.items() if key in fields}
        for fields in (TrialProtocol.model_fields, Gripper.model_fields)
    )
    hand, trials = HAND.model_copy(update=of_hand), TrialProtocol(**of_trials)
    settings = TrialParameters(seed=0, gripper=hand, trials=trials)
    with ExitStack() as stack:
        for name in filter(lambda name: "." in name, changes):
            stack.enter_context(patch(name, changes[name]))
        robot = AsOnTheRobot(detect, changes)
        return pd.concat([run_attempts(m, label, k, robot, settings) for label, k, m in made])


def figures(found: pd.DataFrame, base: pd.DataFrame, opening: float) -> Iterator[str]:
    """What `TITLES` says, in percent."""
    grid = trial_grid(found, 7, 7)
    yield percent(grid.overall.value, grid.overall.interval)
    difference = compare(*(results(each, "ggcnn") for each in (found, base)))
    yield percent(difference.difference, difference.interval)
    later = found[found["label"].str[0] > "B"]
    simple = later["label"].str[1] < "2"
    groups = (grid.rows[0], grid.rows[-1], *map(mean_rate, (later[simple], later[~simple])))
    yield from (percent(mean.value, mean.interval) for mean in groups)
    places = object_positions(found)
    rho = trend(places["difficulty"].to_numpy(), places["rate"].to_numpy())
    yield f"{rho.rho:.2f} ({rho.ci_low:.2f} to {rho.ci_high:.2f})"
    yield f"{100 * found['success'].sum() / (found['outcome'] != 'collided').sum():.0f}"
    yield f"{100 * (found['width'] > opening - 1e-6).mean():.0f}"
    for beginnings in (("missed",), ("slipped", "dropped")):
        yield f"{100 * found['outcome'].str.startswith(beginnings).mean():.0f}"


def main(given: argparse.Namespace) -> None:
    """Run what is missing, and print the table."""
    if given.network.suffix == ".hdf5":
        from robot_network import keras_network  # noqa: PLC0415 (the others need no HDF5)

        detect = MapDetector(keras_network(given.network), "published")
    else:
        detect = GGCNN(str(given.network), "published")
    folder = given.folder / ("published" if given.objects else "released") / given.network.stem
    folder /= f"{given.engine}-{given.attempts}"
    folder.mkdir(parents=True, exist_ok=True)
    usual = {"engine": given.engine, "attempts": given.attempts}
    usual |= {"errors": "typical", "depth_noise": 0.1}

    def found(name: str) -> pd.DataFrame:
        path, changes = folder / f"{name}.parquet", CONDITIONS[name]
        if not path.exists():
            made = models(given.objects, changes.get("rule", "paper"))
            with atomic_output(path) as out:
                attempts(made, detect, usual | changes).to_parquet(out)
        return pd.read_parquet(path)

    def cells(name: str) -> Iterator[str]:
        opening = CONDITIONS[name].get("opening", HAND.opening)
        return figures(found(name), found("baseline"), opening)

    table(given.conditions, TITLES, cells)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("network", type=Path)
    parser.add_argument("--objects", type=Path)
    parser.add_argument("--engine", choices=ENGINES, default=ENGINES[0])
    parser.add_argument("--attempts", type=int, default=10)
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS))
    main(parser.parse_args())
