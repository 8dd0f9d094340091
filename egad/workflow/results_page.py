"""The manual of the results, `results/README.md`: every file, and the columns of every table.

`python -m egad.workflow.results_page` writes it, `--check` says whether it is up to date.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa

from egad._util.files import write_text
from egad._util.markdown import table
from egad.tables import clutter, evaluation, evolution, grasping, images, objects, release
from egad.tables.columns import markdown_table

PAGE = Path("results/README.md")


class Result(NamedTuple):
    """A file or folder that a run writes.

    Attributes:
        path: In `results/`; D stands for a dataset, G for a gripper, P for a grasp detector.
        meaning: What it is.
        columns: Those of a table.
    """

    path: str
    meaning: str
    columns: pa.Schema | None = None


RESULTS = [
    Result("report.html", "overview of all results; works offline"),
    Result("comparison.parquet", "coverage and diversity of all datasets", objects.COMPARISON),
    Result("comparison.svg", "small map of each dataset"),
    Result("D/archive.parquet", "elites of evolution", evolution.ARCHIVE),
    Result("D/history.parquet", "statistics of the archive after each step", evolution.HISTORY),
    Result("D/ancestry.parquet", "elites and all their ancestors", evolution.LINEAGE),
    Result("D/objects.parquet", "repaired and measured objects", objects.OBJECTS),
    Result("D/rejected.parquet", "rejected objects, with reasons", objects.REJECTED),
    Result("D/meshes/LABEL.obj", "meshes of the objects, in metres"),
    Result(
        "D/graspability/G.parquet",
        "measures of the objects for gripper G (`targets.graspability`)",
        objects.GRASPABILITIES,
    ),
    Result("D/rescaled/G/LABEL.obj", "meshes scaled to gripper G, in metres"),
    Result("D/rescaled/G/scales.parquet", "their scales", grasping.SCALES),
    Result("D/rescaled/G/rejected.parquet", "objects that cannot be scaled", objects.REJECTED),
    Result(
        "D/convex_parts/G.parquet",
        "convex parts of the scaled objects (for a release, and exports of all objects)",
        evaluation.CONVEX_PARTS,
    ),
    Result(
        "D/grasps/G.parquet",
        "labelled grasps of the scaled objects; `simulated_*` with `targets.simulated_labels`, or "
        "if an export needs them",
        grasping.SIMULATED_GRASPS,
    ),
    Result(
        "D/grasps/G.sampling.parquet",
        "how many candidates were drawn, and why some were refused",
        grasping.SAMPLING,
    ),
    Result("D/grasps/G.rejected.parquet", "objects without grasps", objects.REJECTED),
    Result(
        "D/simulated/G.parquet",
        "how often the simulated grasps of each object held (`targets.simulated_labels`)",
        grasping.SIMULATED_OBJECTS,
    ),
    Result("D/eval49.parquet", "evaluation set", evaluation.EVAL49),
    Result("D/eval49.rejected.parquet", "candidates that cannot be printed", objects.REJECTED),
    Result("D/eval49/README.md", "datasheet of the evaluation set, with how to report results"),
    Result("D/eval49/contact-sheet.pdf", "pictures of its objects, with names and sizes"),
    Result("D/eval49/trials.csv", "empty table for attempts with a real robot"),
    Result(
        "D/size_effect/G.parquet",
        "grasp quality over size of an easy, a medium and a hard object",
        grasping.SIZE_EFFECT,
    ),
    Result("D/print/G/LABEL_RULE_OPENING.stl", "evaluation set to print, in millimetres"),
    Result("D/print/G/plate-N.3mf", "the same on the plates of a printer"),
    Result("D/print/G/manifest.parquet", "what is on each plate", evaluation.MANIFEST),
    Result("D/bundle/G/LABEL/", "evaluation set for simulators; see docs/bundle.md"),
    Result("D/bundle/G/README.md", "what these files are"),
    Result("D/bundle/G/bundle.parquet", "its objects, parts and masses", evaluation.BUNDLE),
    Result("D/bundle/G/rejected.parquet", "objects that are not in it", objects.REJECTED),
    Result("D/trials/G/P.parquet", "simulated trials, one attempt per row", evaluation.TRIALS),
    Result(
        "D/clutter/G/P.parquet",
        "tables that detector P clears (`targets.clutter`), one attempt per row",
        clutter.CLUTTER,
    ),
    Result(
        "D/agreement/G.parquet",
        "sample of the labelled grasps, executed in simulation (`targets.agreement`)",
        evaluation.AGREEMENT,
    ),
    Result(
        "D/images/G/images-N.parquet",
        "depth images with grasps (`targets.render`); see docs/images.md",
        images.IMAGES,
    ),
    Result("D/images/G/card.md", "their description"),
    Result("D/images/G/openings.svg", "how far the hand opens for the good grasps in them"),
    Result("D/images/G/rejected.parquet", "objects without images", objects.REJECTED),
    Result("D/exchange/G.hdf5", "Dex-Net database (`targets.exports`); see docs/exchange.md"),
    Result("D/exchange/G-FORMAT/", "every other format of `targets.exports`"),
    Result("release/", "dataset that anyone can host; see docs/release.md"),
    Result(
        "release/data/objects/SPLIT.parquet",
        "objects of the splits train, validation and test",
        release.RELEASED_OBJECTS,
    ),
    Result(
        "release/data/grasps/SPLIT-NNNNN-of-NNNNN.parquet",
        "their grasps, in the frame of the object scaled to the gripper of the release",
        release.RELEASED_GRASPS,
    ),
    Result(
        "release/data/evaluation_set.parquet",
        "evaluation set of the release",
        release.RELEASED_EVALUATION_SET,
    ),
]

INTRODUCTION = """# Results

The files of a run, for a dataset `D`, a gripper `G` and a grasp detector `P`. Every table opens
with `pandas.read_parquet`; its columns carry their `unit` and `meaning` as Arrow field metadata.
Lengths are metres and masses kilograms unless a unit says otherwise. Cells count from 0 = simplest
and 0 = easiest.

`egad provenance FILE` shows what a file was made from, and `egad verify results` whether anything
was altered since: [docs/provenance.md](../docs/provenance.md). `D/parts` and `D/epochs` hold what
jobs pass to each other; the pipeline makes what it needs of them again.
"""


def page() -> str:
    """The manual as Markdown."""
    rows = [(f"`{each.path}`", each.meaning) for each in RESULTS]
    parts = [INTRODUCTION, table(["file", "what it is"], rows)]
    known: dict[str, str] = {}
    for each in RESULTS:
        if each.columns is not None:
            text = markdown_table(each.columns)
            known[text] = ", ".join(filter(None, [known.get(text), f"`{each.path}`"]))
    return "\n".join([*parts, *(f"## {paths}\n\n{text}" for text, paths in known.items())])


def main() -> None:
    """Write the manual, or with `--check` say whether it is up to date."""
    if "--check" not in sys.argv:
        write_text(PAGE, page())
    elif PAGE.read_text(encoding="utf-8") != page():
        sys.exit(f"{PAGE} is out of date: run python -m egad.workflow.results_page")


if __name__ == "__main__":
    main()
