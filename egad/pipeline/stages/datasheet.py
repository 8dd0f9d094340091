"""datasheet: a readable description of an evaluation set."""

from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from egad._util.files import atomic_output, write_text
from egad._util.progress import phase
from egad.evalset import ATTEMPTS, ForGripper, empty_cells
from egad.evalset.datasheet import page
from egad.exchange import read_mesh
from egad.pipeline.config import PrintExport, SelectEval
from egad.pipeline.config.stage_settings import StageSettings
from egad.pipeline.parameters import Evaluation, Input, Output, command
from egad.report.evaluation import contact_sheet
from egad.stats import template
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST


class DataSheets(StageSettings):
    """The datasheet of an evaluation set."""

    select_eval: SelectEval
    print_export: PrintExport


@command()
def run(
    settings: DataSheets,
    dataset: str,
    evaluation: Evaluation,
    manifests: Annotated[dict[str, Path], typer.Option("--manifest"), Input(names="grippers")],
    grasps: Annotated[dict[str, Path], Input()],
    out: Annotated[
        Path,
        Output("D/eval49/README.md"),
        Output("D/eval49/contact-sheet.pdf"),
        Output("D/eval49/trials.csv"),
    ],
) -> None:
    """Write the datasheet of an evaluation set.

    Args:
        settings: Grid and printing.
        dataset: Name of the dataset.
        evaluation: Evaluation set.
        manifests: Tables of print files as GRIPPER=manifest.parquet; pictures show the first.
        grasps: Labelled grasps as GRIPPER=grasps.parquet, where available.
        out: Folder with the datasheet of the evaluation set (objects, sizes, how to report
            results), a contact sheet of its objects with names and sizes, and an empty table for
            attempts with a real robot.
    """
    chosen = parquet.read(evaluation, EVAL49)
    known = {
        gripper: ForGripper(
            parquet.read(path, MANIFEST), _best(grasps[gripper]) if gripper in grasps else {}
        )
        for gripper, path in manifests.items()
    }
    empty = empty_cells(chosen, settings.select_eval)
    text = page(dataset, chosen, empty, known, settings.print_export)
    first = next(iter(manifests))
    picture = _sheet(
        settings,
        f"{dataset}, scaled for {first}",
        chosen,
        known[first].manifest,
        manifests[first].parent,
    )
    write_text(out / "README.md", text)
    empty_results = template(chosen["label"].tolist(), ATTEMPTS, "")
    write_text(out / "trials.csv", empty_results.to_csv(index=False))
    with atomic_output(out / "contact-sheet.pdf") as temporary:
        temporary.write_bytes(picture)


def _best(path: Path) -> dict[str, float]:
    """Quality of the best grasp that the hand reaches, by the name of the object."""
    best: dict[str, float] = {}
    for batch in parquet.batches(path, ["label", "collision_free", "quality"]):
        found = batch[batch["collision_free"]].groupby("label")["quality"].max()
        for label, quality in found.items():
            best[str(label)] = max(float(quality), best.get(str(label), quality))
    return best


def _sheet(
    settings: DataSheets, title: str, chosen: pd.DataFrame, manifest: pd.DataFrame, prints: Path
) -> bytes:
    rows = manifest.set_index("label")
    meshes, captions = {}, {}
    for each in parquet.records(chosen):
        place, row = (each["row"], each["column"]), rows.loc[each["label"]]
        if not row["file"]:
            captions[place] = (each["label"], "no mesh")
            continue
        meshes[place] = read_mesh(prints / row["file"], "mm")
        sides = " x ".join(f"{row[f'extents_{axis}']:.0f}" for axis in "xyz")
        captions[place] = (each["label"], f"{sides} mm\n{row['filament']:.0f} g")
    grid = settings.select_eval
    phase("drawing the contact sheet")
    return contact_sheet(title, grid.rows, grid.columns, meshes, captions)
