"""The tables of README.md: detectors clear tables of several objects.

The objects are evolved ones, YCB and primitives.

    python studies/benchmark/benchmark.py OUT --ycb FOLDER --vgn WEIGHTS --ggcnn WEIGHTS --jobs 2

writes OUT/SET/DETECTOR.parquet unless it exists, and prints the tables. With --picture it draws
docs/benchmark.png instead. `simple` is a set of single boxes, cylinders and balls, like those that
VGN was trained on; `simple-one-view` is the same, seen by one camera.
"""

import argparse
import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh
from PIL import Image

import egad
from egad._util.files import atomic_output
from egad.bench import (
    NAMED_PROTOCOLS,
    Clutter,
    ClutterParameters,
    ClutterProtocol,
    SceneCameras,
    picture_of,
    rounds_of,
)
from egad.bench.benchmark import clear_tables
from egad.bench.preparation import prepare_objects
from egad.bench.stats import Clearing, by_difficulty, clearing_rates
from egad.detectors import DetectorConfig, NoiseName
from egad.geometry import joined_primitives
from egad.geometry.manifold import to_mesh
from egad.geometry.primitives import loose_piece, solid_of
from egad.grippers import GRIPPERS
from egad.io import object_names, read_mesh
from egad.objects import NamedMesh, named_meshes
from egad.random import generator
from egad.tables import parquet
from egad.tables.clutter import CLUTTER

WITHOUT_FILES = ("vgn-evolved", "ggcnn2-evolved", "antipodal-cloud", "labels", "random")
ROUNDS = 100
GRIPPER = "panda"
COUNT = 49  # primitives and simple objects, as many as in the evaluation set
LARGEST = 0.075  # side of a simple object, metres
SIMPLE, ONE_VIEW = "simple", "simple-one-view"
SHOWN = 2  # scenes of each kind
CROP = (slice(110, 370), slice(20, 332))
DOCS = Path(__file__).parents[2] / "docs"


def main(given: argparse.Namespace) -> None:
    """Run what is missing, and print the tables."""
    detectors = {
        "vgn": DetectorConfig(detector="vgn", weights=given.vgn),
        "ggcnn2": DetectorConfig(detector="ggcnn", weights=given.ggcnn),
        **{name: DetectorConfig(detector=name) for name in WITHOUT_FILES},
    }
    simple = [NamedMesh(*[f"s{n:02}"] * 2, partial(single, n)) for n in range(COUNT)]
    sets = {
        "evolved": named_meshes(egad.load("evaluation-set")),
        "ycb": ycb(Path(given.ycb)),
        "primitives": [NamedMesh(*[f"p{n:02}"] * 2, partial(joined, n)) for n in range(COUNT)],
        SIMPLE: simple,
        ONE_VIEW: simple,
    }
    if given.picture:
        draw(sets)
        return
    for name, targets in sets.items():
        used = {"vgn": detectors["vgn"]} if name.startswith(SIMPLE) else detectors
        run(Path(given.out) / name, targets, used, given.jobs)
    print_rates(Path(given.out), list(sets))
    print_thirds(Path(given.out) / "evolved")


def ycb(folder: Path) -> list[NamedMesh]:
    """The meshes of a folder, metres."""
    files = object_names(sorted(folder.glob("*.ply")))
    return [NamedMesh(name, name, partial(read_mesh, path, "m")) for name, path in files.items()]


def joined(number: int) -> trimesh.Trimesh:
    """An object of several primitives, as in a dataset of the source `primitives`."""
    return joined_primitives(generator(0, "primitives", number), 0.1)


def single(number: int) -> trimesh.Trimesh:
    """A box, a cylinder or a ball."""
    mesh = to_mesh(solid_of(loose_piece(generator(0, "simple", number))))
    return mesh.apply_scale(LARGEST)


def run(
    folder: Path, targets: list[NamedMesh], detectors: dict[str, DetectorConfig], jobs: int
) -> None:
    """Let the detectors without results clear tables, and print the time that each took."""
    missing = [name for name in detectors if not (folder / f"{name}.parquet").exists()]
    if not missing:
        return
    simple, seed = folder.name.startswith(SIMPLE), settings_of(("none",)).seed
    rule, label_seed = ("none", None) if simple else ("paper", seed)
    protocol = ClutterProtocol(cameras=SceneCameras(views=1 if folder.name == ONE_VIEW else 6))
    objects = prepare_objects(targets, GRIPPERS[GRIPPER], rule, label_seed, jobs)
    for name in missing:
        begin = sum(os.times()[:4])
        settings = settings_of(noise_of(name, simple=simple), protocol)
        found = clear_tables(detectors[name], {each.id: each for each in objects}, settings, jobs)
        parquet.write(found.table, CLUTTER, folder / f"{name}.parquet")
        minutes = (sum(os.times()[:4]) - begin) / 60
        print(
            f"{folder.name}, {name}: {minutes:.1f} CPU min, planning {found.planning_time:.3f} s",
            flush=True,
        )


def noise_of(detector: str, *, simple: bool) -> tuple[NoiseName, ...]:
    """Kinds of noise of a run; `labels` sees nothing."""
    if detector == "labels":
        return ("none",)
    return ("none", "stereo", "gamma") if simple else ("none", "stereo")


def settings_of(
    noise: tuple[NoiseName, ...], protocol: ClutterProtocol = NAMED_PROTOCOLS["egad"]
) -> ClutterParameters:
    """Settings of all runs, with a protocol."""
    scenes = ("single", "packed", "pile")
    clutter = Clutter(rounds=ROUNDS, noise=noise, scenes=scenes, protocol=protocol)
    return ClutterParameters(seed=0, gripper=GRIPPERS[GRIPPER], clutter=clutter)


def draw(sets: dict[str, list[NamedMesh]]) -> None:
    """Two packed scenes and two piles of each set; a row is a set."""
    settings, rows = settings_of(("none",)), []
    for name, targets in sets.items():
        if name.startswith(SIMPLE):
            continue
        objects = prepare_objects(targets, settings.gripper, "paper", jobs=2)
        models = {each.id: each.model for each in objects}
        todo = rounds_of(list(models), settings)
        shown = [this for this in todo if this.scene != "single" and this.number < SHOWN]
        rows.append([picture_of(this, models, settings)[CROP] for this in shown])
    sheet = Image.fromarray(np.concatenate([np.concatenate(row, axis=1) for row in rows]))
    with atomic_output(DOCS / "benchmark.png") as out:
        sheet.quantize(64).save(out, "png", optimize=True)


def print_rates(out: Path, sets: list[str]) -> None:
    """Print a table for each kind of noise: rates by set, detector and scenes, in percent."""
    found: dict[str, list[str]] = {}
    for path in sorted(out.glob("*/*.parquet"), key=lambda path: sets.index(path.parent.name)):
        for noise, rates in line_of_each_noise(parquet.read(path, CLUTTER)):
            found.setdefault(noise, []).append(f"| {path.parent.name} | `{path.stem}` | {rates} |")
    for noise, lines in found.items():
        print(f"\n{noise}\n\n| objects | detector | single | packed | cleared | pile | cleared |")
        print("| --- " * 7 + "|", *lines, sep="\n")


def line_of_each_noise(table: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Success and share of cleared objects with intervals, percent."""
    rates: dict[str, dict[str, Clearing]] = {}
    for each in clearing_rates(table):
        rates.setdefault(each.noise, {})[each.scene] = each
    for noise, by_scene in rates.items():
        shown = [by_scene["single"].success]
        for scene in ("packed", "pile"):
            shown += [by_scene[scene].success, by_scene[scene].cleared]
        percents = [100 * np.array([rate.value, *rate.interval]) for rate in shown]
        yield noise, " | ".join(f"{v:.0f} ({low:.0f} to {high:.0f})" for v, low, high in percents)


def print_thirds(folder: Path) -> None:
    """Print success and share cleared by thirds of the objects, with noise; percent."""
    print(
        "\n| detector | simple | middle | complex | easy | middle | hard |\n" + "| --- " * 7 + "|"
    )
    objects = egad.load("evaluation-set").table
    for path in sorted(folder.glob("*.parquet")):
        table = parquet.read(path, CLUTTER)
        noise = noise_of(path.stem, simple=False)[-1]
        thirds = by_difficulty(table[table["noise"] == noise], objects)
        rates = [
            " / ".join(f"{100 * row.successes / of:.0f}" for of in (row.attempts, row.present))
            for row in thirds.itertuples()
        ]
        print(f"| `{path.stem}` | {' | '.join(rates)} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    for option in ("--ycb", "--vgn", "--ggcnn"):
        parser.add_argument(option, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--picture", action="store_true", help="draw docs/benchmark.png instead")
    main(parser.parse_args())
