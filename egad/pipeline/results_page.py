"""The manual of the result files, generated from the Arrow schemas: `results/README.md`.

`python -m egad.pipeline.results_page` writes it, `--check` says whether it is up to date.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from egad._util.files import write_text
from egad.tables.evaluation import AGREEMENT, BUNDLE, EVAL49, MANIFEST, TRIALS
from egad.tables.evolution import ARCHIVE, HISTORY
from egad.tables.grasping import GRASPS, SCALES, SIZE_EFFECT, TALLY
from egad.tables.images import IMAGES
from egad.tables.objects import COMPARISON, OBJECTS, REJECTED
from egad.tables.training import COMPARED, SCORE
from egad.tables.training import HISTORY as TRAINING

PAGE = Path("results/README.md")


@dataclass(frozen=True)
class Artefact:
    """A file that the pipeline makes; `schema` if it is a table."""

    path: str
    meaning: str
    schema: pa.Schema | None = None


ARTEFACTS = [
    Artefact("report.html", "Overview of a run, in one file that opens offline."),
    Artefact("comparison.parquet", "Comparison of the datasets, one row per dataset.", COMPARISON),
    Artefact("comparison.svg", "A map of each dataset: objects per cell, all on one scale."),
    Artefact("D/archive.parquet", "The elites of evolution, one row per object.", ARCHIVE),
    Artefact("D/history.parquet", "Progress of evolution, one row per step.", HISTORY),
    Artefact(
        "D/objects.parquet", "The repaired and measured objects, one row per object.", OBJECTS
    ),
    Artefact("D/rejected.parquet", "Objects that were rejected, with the reason.", REJECTED),
    Artefact("D/meshes/LABEL.obj", "The meshes of these objects, in metres."),
    Artefact("D/rescaled/G/LABEL.obj", "The meshes scaled to gripper G, in metres."),
    Artefact("D/rescaled/G/scales.parquet", "How each object was scaled.", SCALES),
    Artefact(
        "D/grasps/G.parquet",
        "Labelled grasps for gripper G, in the frame of `D/rescaled/G/LABEL.obj`. "
        "`G.rejected.parquet` beside it lists the objects without any.",
        GRASPS,
    ),
    Artefact(
        "D/grasps/G.tally.parquet",
        "Sampling statistics of these grasps: candidates per object, and what became of them.",
        TALLY,
    ),
    Artefact(
        "D/exchange/G.hdf5",
        "The objects and these grasps as a Dex-Net database, if `targets.exports` names "
        "`dexnet`. See `docs/exchange.md`.",
    ),
    Artefact(
        "D/exchange/G-acronym/LABEL.h5",
        "These grasps as ACRONYM files, if `targets.exports` names `acronym`; the root of their "
        "meshes is `D`. See `docs/exchange.md`.",
    ),
    Artefact(
        "D/exchange/G-jacquard/, D/exchange/G-cornell/, D/exchange/G-gqcnn/",
        "Rendered images with grasps for gripper G in the layout of Jacquard, Cornell and GQ-CNN, "
        "if `targets.exports` names `jacquard`, `cornell` or `gqcnn`. See `docs/images.md`.",
    ),
    Artefact("D/eval49.parquet", "The evaluation set, one row per object.", EVAL49),
    Artefact(
        "D/eval49.rejected.parquet",
        "Candidates for it that cannot be printed, with the reason.",
        REJECTED,
    ),
    Artefact(
        "D/size_effect/G.parquet",
        "Grasp quality over object size for gripper G, for the easiest, the middle and the hardest "
        "object of the evaluation set.",
        SIZE_EFFECT,
    ),
    Artefact("D/eval49/README.md", "Its datasheet: objects, sizes, and how to report results."),
    Artefact("D/eval49/contact-sheet.pdf", "Its objects on one page, with names and sizes."),
    Artefact("D/eval49/trials.csv", "A table to fill in with attempts on a real robot."),
    Artefact(
        "D/print/G/LABEL_RULE_OPENING.stl", "The evaluation set for gripper G, in millimetres."
    ),
    Artefact("D/print/G/plate-N.3mf", "Print plates, each object under its name, in millimetres."),
    Artefact(
        "D/print/G/manifest.parquet",
        "The printed objects and their plates, one row per object.",
        MANIFEST,
    ),
    Artefact(
        "D/bundle/G/LABEL/",
        "The evaluation set for simulators, scaled to gripper G: meshes, URDF, MJCF, stable "
        "poses. The trials use it. See `docs/bundle.md`.",
    ),
    Artefact(
        "D/bundle/G/bundle.parquet",
        "The objects in it, with parts and mass properties. `rejected.parquet` beside it lists "
        "those that could not be converted.",
        BUNDLE,
    ),
    Artefact(
        "D/trials/G/P.parquet",
        "Simulated trials of detector P with gripper G, one row per attempt.",
        TRIALS,
    ),
    Artefact(
        "D/images/G/images-N.parquet",
        "Depth images with grasps for gripper G, if `targets.render` is set. In the world frame, "
        "the table is at z = 0. `egad.perception.image_shards.read` opens the folder. `card.md` "
        "beside them describes them, `rejected.parquet` lists the objects without images. See "
        "`docs/images.md`.",
        IMAGES,
    ),
    Artefact(
        "D/agreement/G.parquet",
        "A sample of the labelled grasps for gripper G executed in simulation, one row per grasp, "
        "if `targets.agreement` is set. See `docs/trials.md`.",
        AGREEMENT,
    ),
    Artefact(
        "diversity/report.html",
        "Comparison of a network trained on different object sets, if it is requested. See "
        "`docs/diversity.md`. `diversity/images/SET/` beside it has the images of a training "
        "set, as `D/images/G/`.",
    ),
    Artefact(
        "diversity/results.parquet",
        "All attempts of all networks, and of the detectors they are compared with.",
        COMPARED,
    ),
    Artefact(
        "diversity/networks/SET/SEED/",
        "A network trained on a training set: `weights.safetensors`, its model card "
        "`README.md`, and `history.svg`. See `docs/vision.md`.",
    ),
    Artefact(
        "diversity/networks/SET/SEED/history.parquet",
        "Progress of the training, one row per epoch.",
        TRAINING,
    ),
    Artefact(
        "diversity/networks/SET/SEED/score.parquet",
        "Its score on images of objects that it was not trained on.",
        SCORE,
    ),
]

INTRODUCTION = """# Results

A run writes these files for a dataset `D`, a gripper `G` and a grasp detector `P`. Every table
opens with `pandas.read_parquet`. Columns carry their `unit` and `meaning` as Arrow field metadata.

Lengths are metres and masses kilograms unless a unit says otherwise. Cells count from 0 = simplest
and 0 = easiest, while `difficulty` itself is a grasp quality: high for easy objects. With measures
of your own (`axes` in the settings), `complexity` and `difficulty` hold their values, and `grasps`
is 0.

`egad provenance FILE` shows what a file was made from, and `egad verify results` whether anything
was altered since. For that, folders have a `SHA256SUMS`, and files that are not tables a
`NAME.sha256`. See `docs/provenance.md`.

The folders `D/parts` and `D/epochs` hold what jobs pass to each other. You may delete them once a
run is finished. The pipeline makes what it needs again, which for more epochs is all of them.

This page is generated from the schemas: `python -m egad.pipeline.results_page`.
"""


def page() -> str:
    """The page as Markdown."""
    return "\n".join([INTRODUCTION, *map(_section, ARTEFACTS)])


def _section(artefact: Artefact) -> str:
    lines = [f"## `{artefact.path}`", "", artefact.meaning, ""]
    if artefact.schema is not None:
        lines += ["| column | type | unit | meaning |", "| --- | --- | --- | --- |"]
        lines += [_row(field) for field in artefact.schema]
        lines.append("")
    return "\n".join(lines)


def _row(field: pa.Field) -> str:
    meta = {key.decode(): value.decode() for key, value in field.metadata.items()}
    return f"| `{field.name}` | {field.type} | {meta['unit']} | {meta['meaning']} |"


def main() -> None:
    """Write the page, or with `--check` say whether it is what the schemas give."""
    if "--check" not in sys.argv:
        write_text(PAGE, page())
    elif PAGE.read_text(encoding="utf-8") != page():
        sys.exit(f"{PAGE} is out of date: run python -m egad.pipeline.results_page")


if __name__ == "__main__":
    main()
