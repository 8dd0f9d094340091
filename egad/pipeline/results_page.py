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
    Artefact("report.html", "Everything at a glance, in one file that opens offline."),
    Artefact("comparison.parquet", "The datasets side by side.", COMPARISON),
    Artefact("comparison.svg", "A small map of each dataset: objects a cell, all on one scale."),
    Artefact("D/archive.parquet", "The elites of evolution, one a row.", ARCHIVE),
    Artefact("D/history.parquet", "How the archive filled, a row a step.", HISTORY),
    Artefact("D/objects.parquet", "The repaired and measured objects.", OBJECTS),
    Artefact("D/rejected.parquet", "What was left out, and why.", REJECTED),
    Artefact("D/meshes/LABEL.obj", "The meshes of these objects, in metres."),
    Artefact("D/rescaled/G/LABEL.obj", "The meshes scaled to gripper G, in metres."),
    Artefact("D/rescaled/G/scales.parquet", "How each was scaled.", SCALES),
    Artefact(
        "D/grasps/G.parquet",
        "Labelled grasps for gripper G, in the frame of `D/rescaled/G/LABEL.obj`. "
        "`G.rejected.parquet` beside it names the objects without any.",
        GRASPS,
    ),
    Artefact(
        "D/grasps/G.tally.parquet",
        "Of each object, how many candidates were tried for these grasps and what became of them.",
        TALLY,
    ),
    Artefact(
        "D/exchange/G.hdf5",
        "The objects and these grasps as a Dex-Net database, if `targets.exports` asks for "
        "`dexnet`. See `docs/exchange.md`.",
    ),
    Artefact(
        "D/exchange/G-acronym/LABEL.h5",
        "These grasps as ACRONYM files, if `targets.exports` asks for `acronym`; the root of their "
        "meshes is `D`. See `docs/exchange.md`.",
    ),
    Artefact(
        "D/exchange/G-jacquard/, D/exchange/G-cornell/, D/exchange/G-gqcnn/",
        "Rendered images with grasps for gripper G laid out as in Jacquard, Cornell and GQ-CNN, if "
        "`targets.exports` asks for `jacquard`, `cornell` or `gqcnn`. See `docs/images.md`.",
    ),
    Artefact("D/eval49.parquet", "The evaluation set.", EVAL49),
    Artefact(
        "D/eval49.rejected.parquet",
        "Candidates for it that cannot be printed, and why.",
        REJECTED,
    ),
    Artefact(
        "D/size_effect/G.parquet",
        "Grasp quality over size for gripper G, of the easiest, the middle and the hardest object "
        "of the evaluation set.",
        SIZE_EFFECT,
    ),
    Artefact("D/eval49/README.md", "Its datasheet: objects, sizes, how to report results."),
    Artefact("D/eval49/contact-sheet.pdf", "Its objects on one page, with names and sizes."),
    Artefact("D/eval49/trials.csv", "A table to fill in with attempts on a real robot."),
    Artefact(
        "D/print/G/LABEL_RULE_OPENING.stl", "The evaluation set for gripper G, in millimetres."
    ),
    Artefact("D/print/G/plate-N.3mf", "Print plates with one named object each, in millimetres."),
    Artefact("D/print/G/manifest.parquet", "What is on which plate.", MANIFEST),
    Artefact(
        "D/bundle/G/LABEL/",
        "The evaluation set for simulators, scaled to gripper G: meshes, URDF, MJCF, poses at "
        "rest. The trials use it. `docs/bundle.md` says what is in it.",
    ),
    Artefact(
        "D/bundle/G/bundle.parquet",
        "The objects in it, their parts and masses. `rejected.parquet` beside it names those "
        "that could not be made ready.",
        BUNDLE,
    ),
    Artefact(
        "D/trials/G/P.parquet",
        "Simulated trials of detector P with gripper G, one attempt a row.",
        TRIALS,
    ),
    Artefact(
        "D/images/G/images-N.parquet",
        "Depth images with grasps for gripper G, if `targets.render` asks for them; "
        "`egad.perception.image_shards.read` opens the folder. `card.md` beside them says what is "
        "in them, `rejected.parquet` which objects have none. See `docs/images.md`.",
        IMAGES,
    ),
    Artefact(
        "D/agreement/G.parquet",
        "A sample of the labelled grasps for gripper G carried out in simulation, if "
        "`targets.agreement` asks for it.",
        AGREEMENT,
    ),
    Artefact(
        "diversity/report.html",
        "The same network taught by different objects, if it is asked for. See "
        "`docs/diversity.md`. `diversity/images/SET/` beside it has what a training set consists "
        "of, as `D/images/G/`.",
    ),
    Artefact(
        "diversity/results.parquet",
        "All attempts of all networks, and of the detectors beside them.",
        COMPARED,
    ),
    Artefact(
        "diversity/networks/SET/SEED/",
        "A network that learnt from a training set: `weights.safetensors`, its model card "
        "`README.md`, and `history.svg`. See `docs/vision.md`.",
    ),
    Artefact(
        "diversity/networks/SET/SEED/history.parquet",
        "How the network learnt, an epoch a row.",
        TRAINING,
    ),
    Artefact(
        "diversity/networks/SET/SEED/score.parquet",
        "What it reached on images of objects that it has not learnt from.",
        SCORE,
    ),
]

INTRODUCTION = """# Results

For a dataset `D`, a gripper `G` and a grasp detector `P`. Lengths are metres and masses kilograms
unless a unit says otherwise. Cells count from 0 = simplest and 0 = easiest, while `difficulty`
itself is a grasp quality: high for easy objects. With measures of one's own (`axes` in the
settings) `complexity` and `difficulty` hold those, and `grasps` is 0. Every table opens with
`pandas.read_parquet`; columns carry their `unit` and `meaning` as Arrow field metadata.

Folders `D/parts` and `D/epochs` hold what jobs hand to each other. They may be deleted once a run
is finished; the pipeline makes again what it needs, which for more epochs is all of them.

`egad provenance FILE` tells where a file comes from, `egad verify results` whether anything was
altered since; for that, folders have a `SHA256SUMS` and files that are no tables a `NAME.sha256`.
See `docs/provenance.md`.

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
