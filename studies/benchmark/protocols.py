"""The tables of protocols.md: VGN under the protocols of published benchmarks.

    python studies/benchmark/protocols.py OUT --ycb FOLDER --vgn WEIGHTS [--only published | piles]

clears 100 tables with the published weights of VGN for each row of the tables, twenty rounds of
each row before the next twenty of any, and prints the tables. Results in OUT are not repeated.
`piles` goes from the protocol of egad to that of NeuGraspNet's piles of EGAD objects (Jauhri et al.
2024, table III; repository iROSA-lab/neugraspnet, commit 8716c1c), one factor at a time.
"""

import argparse
import pickle
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from benchmark import COUNT, single, ycb
from scipy import ndimage
from scipy.spatial.transform import Rotation

import egad
from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad.bench import (
    NAMED_PROTOCOLS,
    Clutter,
    ClutterParameters,
    ClutterProtocol,
    SceneCameras,
    rounds_of,
)
from egad.bench.clearing import clear_rounds
from egad.bench.preparation import SceneObject, prepare_objects
from egad.bench.stats import Mean, clearing_rates
from egad.detectors import GraspPoses, Observation, Tsdf
from egad.detectors.vgn import THRESHOLD, Vgn
from egad.grippers import GRIPPERS, Gripper
from egad.objects import NamedMesh, named_meshes
from egad.random import generator
from egad.sim import Model
from egad.tables import parquet
from egad.tables.clutter import CLUTTER

ROUNDS, CHUNK = 100, 20
HAND = GRIPPERS["panda"]
SETS = ("simple", "evolved", "ycb")
OURS = NAMED_PROTOCOLS["egad"]
# Of NeuGraspNet's EGAD objects
EDGE, THIN, VOLUME = 0.15, 0.014, 6e-4  # metres, metres, cubic metres; at scale 1
SCALES = (0.8, 1.4)
MASS = 0.15  # kg
VARIANTS = 6  # sizes of each object
FINE = 64  # voxels along a side of the TSDF


class Setup(NamedTuple):
    """How piles are cleared.

    Attributes:
        objects: Names of the changes to the objects.
        protocol: Changes to the protocol of egad.
        noise: Noise of the depth images.
        engine: Physics engine.
        fine: Whether the TSDF has 64 voxels along a side, resampled to 40.
    """

    objects: tuple[str, ...] = ()
    protocol: Mapping[str, Any] = {}
    noise: str = "stereo"
    engine: str = "mujoco"
    fine: bool = False

    def then(self, change: Mapping[str, Any]) -> "Setup":
        """The same setup with one more factor changed."""
        objects = (*self.objects, *change.get("objects", ()))
        protocol = {**self.protocol, **change.get("protocol", {})}
        return self._replace(**{**change, "objects": objects, "protocol": protocol})


FACTORS: dict[str, dict[str, Any]] = {
    "sizes": {"objects": ("sizes",), "protocol": {"scale": (1.0, 1.0)}},
    "hulls": {"objects": ("hulls",)},
    "mass": {"objects": ("mass",)},
    "placing": {"protocol": {"repetition": True, "drop_height": 0.2, "drop_above": "table"}},
    "hand": {"protocol": {"force": 20.0, "friction": 0.75}},
    "one view": {"protocol": {"cameras": SceneCameras(views=1, image=(640, 480), focal=540.0)}},
    "no noise": {"noise": "none"},
    "contact": {"protocol": {"stopping_force": 0.0, "success": "touched", "removed": "first"}},
    "threshold": {"protocol": {"threshold": 0.5}},
    "skips": {"protocol": {"skips": 3}},
    "tsdf": {"fine": True},
    "pybullet": {"engine": "pybullet"},
}


@dataclass(frozen=True)
class FixedMass(Model):
    """An object of the same mass in any size."""

    fixed: float = MASS

    def scaled(self, factor: float) -> Model:
        """The same object in another size."""
        made = super().scaled(factor)
        return replace(made, mass=self.fixed, inertia=made.inertia * self.fixed / made.mass)


class FineVgn:
    """VGN on a TSDF of 64 voxels along a side, resampled to the 40 that it was trained with."""

    observes = "observation"

    def __init__(self, weights: str, threshold: float) -> None:
        self._vgn = Vgn(weights, threshold)

    def __call__(
        self, observation: Observation, gripper: Gripper, rng: np.random.Generator
    ) -> GraspPoses:
        """Grasps, as from `Vgn`."""
        coarse, fine = observation.tsdf, observation.fuse_views(FINE)
        count = len(coarse.distances)
        places = (np.indices((count,) * 3) + 0.5) * FINE / count - 0.5
        distances, weights = (
            ndimage.map_coordinates(values, places, order=order, mode="nearest")
            for values, order in ((fine.distances, 1), (fine.weights, 0))
        )
        seen = Tsdf(distances, weights, coarse.corner, coarse.voxel, fine.truncation)
        return self._vgn(seen, gripper, rng)


def scale_factor(vertices: Floats, scale: float) -> float:
    """What NeuGraspNet multiplies an EGAD object by, from units of its file to metres.

    It starts with the scale, and shrinks by 0.8 until the second longest side of the box around the
    object, turned as it is dropped, is at most 0.15 m at scale 1, then by 0.85 until the volume of
    that box is at most 0.6 litres, and grows by 1 / 0.95 while the shortest side is below 14 mm.

    Args:
        vertices: (n, 3) as the object is dropped, some 100 units long.
        scale: Sampled for the object; the limits are larger by this factor.
    """
    sides = np.sort(np.ptp(vertices, axis=0))
    factor = scale
    for _ in range(1000):
        shortest, second, _ = factor * sides
        if second > EDGE * scale:
            factor *= 0.8
        elif np.prod(factor * sides) > VOLUME * scale**3:
            factor *= 0.85
        elif shortest < THIN * scale:
            factor /= 0.95
        else:
            return factor
    raise ValueError("no size is allowed")


def changed(objects: Iterable[SceneObject], changes: tuple[str, ...]) -> Iterator[SceneObject]:
    """Objects as in NeuGraspNet in some respects: sizes, hulls, mass.

    For `sizes`, each object appears six times, each time in another random size.
    """
    for each in objects:
        models = [each.model]
        if "sizes" in changes:
            models = [_resized(each, number) for number in range(VARIANTS)]
        for number, model in enumerate(models):
            made = model
            if "hulls" in changes:
                made = replace(made, parts=(made.mesh.convex_hull,))
            if "mass" in changes:
                made = FixedMass(**vars(made)).scaled(1.0)
            yield SceneObject(
                f"{each.id}-{number}" if len(models) > 1 else each.id, made, each.grasps
            )


def _resized(this: SceneObject, number: int) -> Model:
    rng = generator(0, "neugraspnet", this.id, number)
    turn, scale = Rotation.random(rng=rng), rng.uniform(*SCALES)
    unit = np.cbrt(np.linalg.det(this.model.to_principal[:3, :3])) / 1000  # files are in mm
    vertices = turn.apply(this.model.mesh.vertices / unit)
    return this.model.scaled(scale_factor(vertices, scale) / unit)


def prepared(path: Path, given: argparse.Namespace) -> list[SceneObject]:
    """The objects of a set, made once."""
    if not path.exists():
        targets = {
            "evolved": lambda: named_meshes(egad.load("evaluation-set")),
            "ycb": lambda: ycb(Path(given.ycb)),
            "simple": lambda: [
                NamedMesh(*[f"s{n:02}"] * 2, partial(single, n)) for n in range(COUNT)
            ],
        }[path.stem]()
        made = prepare_objects(targets, HAND, "none" if path.stem == "simple" else "paper")
        with atomic_output(path) as out:
            out.write_bytes(pickle.dumps(made))
    return pickle.loads(path.read_bytes())  # type: ignore[no-any-return]  # noqa: S301 (this file is ours)


class Run(NamedTuple):
    """One row of a table: where its attempts are, and what they are made with."""

    folder: Path
    objects: str
    changes: tuple[str, ...]
    clutter: Clutter
    fine: bool = False


def clear(run: Run, first: int, objects: list[SceneObject], given: argparse.Namespace) -> None:
    """Clear twenty tables of each kind of scene, if that was not done."""
    path = run.folder / f"{first:02}.parquet"
    if path.exists():
        return
    settings = ClutterParameters(seed=0, gripper=HAND, clutter=run.clutter)
    known = list(changed(objects, run.changes))
    todo = [
        each
        for each in rounds_of([one.id for one in known], settings)
        if first <= each.number < first + CHUNK
    ]
    given_threshold = run.clutter.protocol.threshold
    threshold = THRESHOLD if given_threshold is None else given_threshold
    detect = (FineVgn if run.fine else Vgn)(given.vgn, threshold)
    table, _ = clear_rounds(todo, {each.id: each for each in known}, detect, settings)
    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write(table, CLUTTER, path)
    print(run.folder, first, flush=True)


def published(out: Path) -> dict[str, Run]:
    """VGN under the protocols of VGN and GIGA."""
    return {
        f"{protocol}-{name}": Run(
            out / "published" / protocol / name,
            name,
            (),
            Clutter(rounds=ROUNDS, scenes=("packed", "pile"), protocol=protocol),
        )
        for name in SETS
        for protocol in ("vgn", "giga")
    }


def piles(out: Path) -> dict[str, Run]:
    """Piles from our protocol to that of NeuGraspNet: each factor alone, and all up to it."""
    together, alone, last = {}, {}, Setup()
    for name, change in FACTORS.items():
        last = together[f"together-{name}"] = last.then(change)
        alone[f"alone-{name}"] = Setup().then(change)
    alone.pop(f"alone-{next(iter(FACTORS))}")  # the same as together
    setups = {
        "egad": Setup(),
        **together,
        "random": last.then({"protocol": {"threshold": 0.9, "choice": "random"}}),
        "dex": last.then({"noise": "dex"}),
        **alone,
    }
    return {name: _run(out / "piles" / name, setup) for name, setup in setups.items()}


def _run(folder: Path, setup: Setup) -> Run:
    rules = ClutterProtocol(**{**dict(OURS), **setup.protocol})
    clutter = Clutter(
        rounds=ROUNDS,
        scenes=("pile",),
        protocol=rules,
        noise=(setup.noise,),
        engine=setup.engine,
    )
    return Run(folder, "evolved", setup.objects, clutter, setup.fine)


def rates(run: Run, rounds: int = ROUNDS) -> dict[str, tuple[str, str, str]]:
    """Rounds, success and share cleared in percent, by kind of scene; empty without attempts.

    Args:
        run: A row.
        rounds: How many are counted, from the first.
    """
    paths = sorted(run.folder.glob("*.parquet"))[: rounds // CHUNK]
    if not paths:
        return {}
    table = pd.concat([parquet.read(path, CLUTTER) for path in paths])
    return {
        each.scene: (str(each.rounds), _percent(each.success), _percent(each.cleared))
        for each in clearing_rates(table)
    }


def _percent(rate: Mean) -> str:
    value, low, high = 100 * np.array([rate.value, *rate.interval])
    return f"{value:.0f} ({low:.0f} to {high:.0f})"


def print_published(runs: Mapping[str, Run]) -> None:
    """Print a row for each set of objects, protocol and kind of scene."""
    print("| objects | protocol | scenes | rounds | success | cleared |\n" + "| --- " * 6 + "|")
    for name, run in runs.items():
        protocol, _, objects = name.partition("-")
        for scene, shown in rates(run).items():
            print(f"| {objects} | `{protocol}` | {scene} | {' | '.join(shown)} |")


def print_piles(runs: Mapping[str, Run]) -> None:
    """Print a row for each factor, with all before it and alone, over the same rounds."""
    first = next(iter(FACTORS))
    together = {"egad": runs["egad"], first: runs[f"together-{first}"]}
    alone = dict(together)
    for name in list(FACTORS)[1:]:
        together[name], alone[name] = runs[f"together-{name}"], runs[f"alone-{name}"]
    together |= {name: runs[name] for name in ("random", "dex")}
    columns = []
    for each in (together, alone):
        done = min(CHUNK * len(list(run.folder.glob("*.parquet"))) for run in each.values())
        columns.append({name: rates(run, done).get("pile") for name, run in each.items()})
    print("| factor | rounds | together: success | cleared | rounds | alone: success | cleared |")
    print("| --- " * 7 + "|")
    for name in together:
        cells = [column.get(name) or ("", "", "") for column in columns]
        print(f"| `{name}` | {' | '.join(cells[0] + cells[1])} |")


def main(given: argparse.Namespace) -> None:
    """Run what is missing, and print the tables."""
    out = Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    kinds = {"published": published(out), "piles": piles(out)}
    chosen = {name: runs for name, runs in kinds.items() if given.only in (None, name)}
    sets: dict[str, list[SceneObject]] = {}
    for first in range(0, 0 if given.show else ROUNDS, CHUNK):
        for run in (run for runs in chosen.values() for run in runs.values()):
            if run.objects not in sets:
                sets[run.objects] = prepared(out / f"{run.objects}.pickle", given)
            clear(run, first, sets[run.objects], given)
    printed = {"published": print_published, "piles": print_piles}
    for name, runs in chosen.items():
        printed[name](runs)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    for option in ("--ycb", "--vgn"):
        parser.add_argument(option, required=True)
    parser.add_argument("--only", choices=("published", "piles"))
    parser.add_argument("--show", action="store_true", help="only print what there is")
    main(parser.parse_args())
