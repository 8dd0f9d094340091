"""The files of a set of images: `images-0.parquet`, `images-1.parquet` and so on in a folder."""

from pathlib import Path

from egad.errors import UserError
from egad.tables import parquet


def files(folder: Path) -> list[Path]:
    """The shards of a folder, in the order of their images.

    Raises:
        UserError: Some are missing, or are not all of one set.
        TableError: One is damaged.
    """
    found = sorted(folder.glob("images-*.parquet"))
    if not found:
        raise UserError(f"{folder}: no images here; `egad render` and the workflow make them")
    notes = {path.name: parquet.notes(path) for path in found}
    totals = {each.get("shards") for each in notes.values()}
    if len(totals) > 1 or not isinstance(total := totals.pop(), int):
        raise UserError(f"{folder}: its shards are of several sets; render them again")
    made = [parquet.origin_of(path) for path in found]
    if any(each.get(key) != made[0].get(key) for each in made for key in ("settings", "inputs")):
        raise UserError(f"{folder}: its shards are of several sets; render them again")
    whole = [f"images-{number}.parquet" for number in range(total)]
    if missing := [name for name in whole if name not in notes]:
        raise UserError(f"{folder}: half written, {_listed(missing)} of {total} shards missing")
    return [folder / name for name in whole]


def _listed(names: list[str]) -> str:
    few = ", ".join(names[:3])
    return few if len(names) <= 3 else f"{few} and {len(names) - 3} more"
