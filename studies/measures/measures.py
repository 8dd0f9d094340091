"""The numbers and figures of README.md: `python studies/measures/measures.py PUBLISHED`.

PUBLISHED is a folder of published EGAD objects, millimetres, whose names are their cells: M14_3
has difficulty M and complexity 14. The values of other programs come from the tests.
"""

import re
import string
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray
from scipy.stats import spearmanr

from egad._util.files import write_text
from egad._util.progress import progress
from egad._util.workers import workers
from egad.geometry.repair import repair
from egad.grasps import ferrari_canny
from egad.io import mesh_files, read_mesh
from egad.measures import MeasureParameters
from egad.measures.complexity import complexity
from egad.measures.graspability import rough_graspability, spaced_graspability
from egad.measures.reeb import Similarity, similarity_matrix
from egad.measures.reeb import graph as reeb
from egad.random import generator
from egad.report.colors import LINES, SOFT
from egad.report.drawing import new_figure
from egad_workflow.settings import Settings, select

Floats = NDArray[np.float64]
FOLDER = Path(__file__).parent
DATA = FOLDER.parents[1] / "tests" / "data"
NAME = re.compile(r"([A-Y])(\d\d)_\d")
VARIANTS = [(metric, count) for metric in ("nominal", "robust") for count in (512, 2048, 8192)]
BASES = (25, 50, 75, 150)
EVERY = 10**6  # more bases than there are vertices


def main(published: Path) -> None:
    """Print the numbers and write the figures beside this file."""
    labelled = against_labels(published)
    rank = _rank(labelled["number"], labelled["complexity"])
    print(f"{len(labelled)} published objects: complexity against number {rank:.3f}")
    for variant in map(_variant, VARIANTS):
        rank = _rank(labelled["letter"], labelled[variant])
        print(f"graspability ({variant}) against letter {rank:.3f}")
    write_text(FOLDER / "labels.svg", label_figure(labelled))
    ours, theirs = qualities()
    off = np.abs(ours - theirs)[(ours > 0) & (theirs > 0)]
    print(f"{len(off)} qualities: largest difference {off.max():.1e}, median {np.median(off):.1e}")
    for count, cells in spacing().items():
        print(f"graspability by {count} spaced grasps, cells off: {cells.round(2).tolist()}")
    scan, program = similarities()
    off = np.abs(scan - program).mean()
    print(f"{len(scan)} similarities (scan): {_rank(scan, program):.3f}, mean difference {off:.4f}")
    for count, rank, off in bases():
        print(f"{count} even bases against all: {rank:.3f}, mean difference {off:.4f}")
    write_text(FOLDER / "programs.svg", program_figure(ours, theirs, scan, program))


def against_labels(published: Path) -> pd.DataFrame:
    """Label and measures of every object."""
    files = [path for path in mesh_files(published) if NAME.fullmatch(path.stem)]
    with workers(2) as mapper:
        return pd.DataFrame(progress(mapper(_measured, files), "measuring", len(files)))


def _measured(path: Path) -> dict[str, float]:
    letter, number = NAME.fullmatch(path.stem).groups()
    mesh = repair(read_mesh(path, "mm")).mesh
    row = {
        "letter": string.ascii_uppercase.index(letter),
        "number": int(number),
        "complexity": complexity(mesh, 512),
    }
    for metric, candidates in VARIANTS:
        one_draw = {"metric": metric, "candidates": candidates}
        config = Settings.model_validate({"graspability": one_draw})
        rng = generator(0, "labels", path.stem, metric, candidates)
        found = rough_graspability(mesh, select(config, MeasureParameters), rng)
        row[_variant((metric, candidates))] = found.value
    return row


def _variant(key: tuple[str, int]) -> str:
    return f"{key[0]}, {key[1]} candidates"


def qualities() -> tuple[Floats, Floats]:
    """Grasp qualities, ours and those of Dex-Net."""
    with np.load(DATA / "ferrari_canny.npz") as data:
        names = ("points", "normals", "axis", "com")
        return ferrari_canny(*(data[name] for name in names)), data["quality"]


def shapes() -> list[trimesh.Trimesh]:
    """The meshes whose similarities by the original program are known."""
    with np.load(DATA / "reeb_reference.npz") as data:
        names = [name for name in data.files if name.startswith("vertices")]
        return [
            trimesh.Trimesh(data[name], data[name.replace("vertices", "faces")], process=False)
            for name in names
        ]


def spacing() -> dict[int, Floats]:
    """Graspability of each shape by spaced grasps, minus that by 32,768 candidates, in cells."""
    space = Settings().space
    low, high = space.graspability_range
    many = Settings.model_validate({"graspability": {"candidates": 32768}})
    settings, meshes = select(many, MeasureParameters), [repair(shape).mesh for shape in shapes()]
    true = [rough_graspability(mesh, settings, generator(0, "true")).value for mesh in meshes]
    result = {}
    for count in (100, 400, 1000, 4000):
        found = [
            [
                spaced_graspability(mesh, settings, count, generator(seed, "spaced")).value
                for seed in range(10)
            ]
            for mesh in meshes
        ]
        result[count] = (np.mean(found, axis=1) - true) * space.cells / (high - low)
    return result


def similarities() -> tuple[Floats, Floats]:
    """Similarities of all pairs, ours with the bases of the original program, and its own."""
    with np.load(DATA / "reeb_reference.npz") as data:
        theirs = data["similarity"]
    ours = _matrix(Similarity(bases="scan"))
    pairs = np.triu_indices(len(theirs), 1)
    return ours[pairs], theirs[pairs]


def bases() -> list[tuple[int, float, float]]:
    """How close evenly spread bases come to one at every vertex: rank and mean difference."""
    pairs = np.triu_indices(len(shapes()), 1)
    ideal = _matrix(Similarity(base_count=EVERY))[pairs]
    found = [(count, _matrix(Similarity(base_count=count))[pairs]) for count in BASES]
    return [(count, _rank(some, ideal), np.abs(some - ideal).mean()) for count, some in found]


def _matrix(settings: Similarity) -> Floats:
    return similarity_matrix([reeb.extract(mesh, settings) for mesh in shapes()], settings.weight)


def _rank(one: ArrayLike, other: ArrayLike) -> float:
    """Absolute value of Spearman's rank correlation."""
    return abs(spearmanr(one, other)[0])


def label_figure(labelled: pd.DataFrame) -> str:
    """Complexity, nominal and robust graspability against the published cells."""
    panels = [
        ("number", "complexity", "complexity, bits", 1),
        ("letter", _variant(("nominal", 8192)), "Ferrari-Canny quality, thousandths", 1000),
        ("letter", _variant(("robust", 8192)), "robust quality, thousandths", 1000),
    ]
    with new_figure(11, 3.6) as drawing:
        for axes, (axis, column, name, factor) in zip(
            drawing.figure.subplots(1, 3), panels, strict=True
        ):
            _scatter(axes, labelled[axis], factor * labelled[column])
            axes.set(xlabel=f"published {axis}", ylabel=name)
            if axis == "letter":
                axes.set_xticks(range(0, 25, 4), string.ascii_uppercase[:25:4])
            axes.set_title(f"Spearman {_rank(labelled[axis], labelled[column]):.2f}", size=10)
    return drawing.svg


def program_figure(ours: Floats, theirs: Floats, scan: Floats, program: Floats) -> str:
    """Grasp quality and similarity against other programs."""
    with new_figure(7.6, 3.7) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        _scatter(left, 1000 * theirs, 1000 * ours)
        left.set(xlabel="quality by Dex-Net, thousandths", ylabel="quality by egad, thousandths")
        _scatter(right, program, scan)
        right.set(xlabel="similarity by the original program", ylabel="similarity by egad (scan)")
        for axes in (left, right):
            low, high = axes.get_xlim()
            axes.plot([low, high], [low, high], color=SOFT, lw=0.8, zorder=0)
    return drawing.svg


def _scatter(axes: Axes, x: ArrayLike, y: ArrayLike) -> None:
    axes.scatter(x, y, s=16, color=LINES[0], alpha=0.6, linewidths=0)
    axes.grid()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
