"""The folder of the datasheet of an evaluation set: a page, a contact sheet, an empty table."""

import math
from pathlib import Path

import pandas as pd

from egad._util.files import atomic_output, write_text
from egad._util.progress import phase
from egad.bench.stats import template
from egad.evalset import ATTEMPTS, DataSheets, ForGripper, empty_cells, in_grid
from egad.evalset.datasheet import page
from egad.io import read_mesh
from egad.report.evaluation import contact_sheet
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST


def write_datasheet(
    settings: DataSheets,
    dataset: str,
    evaluation: Path,
    grippers: list[str],
    manifests: list[Path],
    grasps: list[Path],
    out: Path,
) -> None:
    """Write the datasheet of an evaluation set, a contact sheet, and an empty table of attempts."""
    chosen = parquet.read(evaluation, EVAL49)
    known = {
        gripper: ForGripper(parquet.read(manifest, MANIFEST), _best(labelled))
        for gripper, manifest, labelled in zip(grippers, manifests, grasps, strict=True)
    }
    empty = empty_cells(chosen, settings.select_eval) if in_grid(chosen["label"]) else []
    text = page(dataset, chosen, empty, known, settings.print_export)
    first = grippers[0]
    title = f"{dataset}, scaled for {first}"
    picture = _sheet(settings, title, chosen, known[first].manifest, manifests[0].parent)
    write_text(out / "README.md", text)
    empty_results = template(chosen["label"].tolist(), ATTEMPTS, "")
    write_text(out / "trials.csv", empty_results.to_csv(index=False))
    with atomic_output(out / "contact-sheet.pdf") as temporary:
        temporary.write_bytes(picture)


def _best(path: Path) -> dict[str, float]:
    """Quality of the best grasp that the hand can reach, by name of the object."""
    best: dict[str, float] = {}
    for batch in parquet.batches(path, ["label", "collision_free", "quality"]):
        found = batch[batch["collision_free"]].groupby("label")["quality"].max()
        for label, quality in found.items():
            best[str(label)] = max(float(quality), best.get(str(label), quality))
    return best


def _sheet(
    settings: DataSheets, title: str, chosen: pd.DataFrame, manifest: pd.DataFrame, prints: Path
) -> bytes:
    details = manifest.set_index("label")
    rows, columns = settings.select_eval.rows, settings.select_eval.columns
    if not (grid := in_grid(chosen["label"])):
        columns = min(columns, math.ceil(math.sqrt(len(chosen))))
        rows = math.ceil(len(chosen) / columns)
    meshes, captions = {}, {}
    for number, each in enumerate(parquet.records(chosen)):
        place = (each["row"], each["column"]) if grid else divmod(number, columns)
        row = details.loc[each["label"]]
        if not row["file"]:
            captions[place] = (each["label"], "no mesh")
            continue
        meshes[place] = read_mesh(prints / row["file"], "mm")
        sides = " x ".join(f"{row[f'extents_{axis}']:.0f}" for axis in "xyz")
        captions[place] = (each["label"], f"{sides} mm\n{row['filament']:.0f} g")
    phase("drawing the contact sheet")
    return contact_sheet(title, rows, columns, meshes, captions)
