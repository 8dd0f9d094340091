"""datasheet: what there is to know about an evaluation set, for people."""

from pathlib import Path

import pandas as pd

from egad._util.files import replacing, write_text
from egad._util.progress import phase
from egad.evalset.datasheet import ATTEMPTS, ForGripper, page
from egad.evalset.selection import empty_cells
from egad.exchange.meshes import read_mesh
from egad.pipeline.config.stage_settings import DataSheets
from egad.report.evaluation import contact_sheet
from egad.stats.records import template
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, MANIFEST


def run(
    settings: DataSheets,
    dataset: str,
    evaluation: Path,
    manifests: dict[str, Path],
    grasps: dict[str, Path],
    out: Path,
) -> None:
    """Write `README.md`, `contact-sheet.pdf` and `trials.csv`.

    Args:
        settings: Grid and printing.
        dataset: Its name.
        evaluation: Table with the columns of `tables.evaluation.EVAL49`.
        manifests: By gripper; print files lie beside each. Pictures are of the first.
        grasps: Tables with the columns of `tables.grasping.GRASPS` by gripper, as far as known.
        out: Folder.
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
    with replacing(out / "contact-sheet.pdf") as temporary:
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
