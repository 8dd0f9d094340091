"""Success rates of objects from any source: tables of attempts, or published rates."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from egad.bench.stats.rates import by_object
from egad.bench.stats.records import TEXT, csv_cells, read
from egad.errors import UserError

ATTEMPT_COLUMNS = {"attempt", "success"}
RATE_COLUMNS = ("label", "success_rate", "successes", "attempts", "detector")
WHOLE = re.compile(r"[0-9]{1,9}")
NUMBER = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)( ?%)?")


def object_rates(trials: pd.DataFrame) -> pd.DataFrame:
    """Columns rate and attempts of each object, by its label, from attempts."""
    counts = by_object(trials)
    return pd.DataFrame(
        {"rate": counts["successes"] / counts["attempts"], "attempts": counts["attempts"] + 0.0}
    )


def read_rates(path: Path) -> dict[str, pd.DataFrame]:
    """Columns rate and attempts (NaN if unknown) by label, for each detector in a file.

    The file has attempts, see `read`; or it is a CSV file with a row for each object: label and
    success_rate (0 to 1, or with a percent sign), or label, successes and attempts; and optionally
    detector, by default the name of the file. Rows without a result are left out. UserError says
    which row cannot be used, and what is allowed; TableError: not a Parquet file of results.
    """
    if path.suffix.lower() not in TEXT:
        return {name: object_rates(table) for name, table in read(path).items()}
    (_, names), *lines = csv_cells(path, RATE_COLUMNS, ["success_rate"])
    names = [name.lower() for name in names]
    if ATTEMPT_COLUMNS & set(names):
        return {name: object_rates(table) for name, table in read(path).items()}
    _check_columns(path, names)
    blank = dict.fromkeys(RATE_COLUMNS, "")
    filled = [(line, blank | dict(zip(names, cells, strict=True))) for line, cells in lines]
    result = "success_rate" if "success_rate" in names else "successes"
    rows = [_row(path, line, row, result == "success_rate") for line, row in filled if row[result]]
    if not rows:
        raise UserError(f"{path}: no row has a success rate")
    frame = pd.DataFrame(rows)
    twice = frame[frame.duplicated(["detector", "label"])]
    if len(twice):
        raise UserError(f"{path}: the object {twice.iloc[0]['label']} occurs twice")
    return {
        str(name): table.set_index("label")[["rate", "attempts"]].sort_index()
        for name, table in frame.groupby("detector")
    }


def _check_columns(path: Path, names: list[str]) -> None:
    missing = [] if "label" in names else ["label"]
    if "success_rate" not in names:
        missing += [name for name in ("successes", "attempts") if name not in names]
    if missing:
        raise UserError(
            f"{path}: the column {missing[0]} is missing; needed: label, attempt and success for "
            "attempts; label and success_rate, or label, successes and attempts, for objects"
        )
    if repeated := [name for name in RATE_COLUMNS if names.count(name) > 1]:
        raise UserError(f"{path}: the column {repeated[0]} occurs twice")


def _row(path: Path, line: int, row: Mapping[str, str], has_rate: bool) -> dict[str, object]:
    """One object; `line` is its line in the file, for error messages."""

    def wrong(column: str, wanted: str) -> UserError:
        return UserError(f"{path}, line {line}: {column} is {row[column]!r}; allowed: {wanted}")

    if not row["label"]:
        raise wrong("label", "the name of an object")
    attempts = np.nan
    if row["attempts"] or not has_rate:
        if not WHOLE.fullmatch(row["attempts"]) or not int(row["attempts"]):
            raise wrong("attempts", "a whole number, at least 1, of at most 9 digits")
        attempts = float(row["attempts"])
    if has_rate:
        found = NUMBER.fullmatch(row["success_rate"])
        rate = float(found[1]) / (100 if found[2] else 1) if found else np.nan
        if not 0 <= rate <= 1:
            raise wrong("success_rate", "0 to 1, or a percentage with a percent sign, such as 85 %")
    else:
        if not WHOLE.fullmatch(row["successes"]) or int(row["successes"]) > attempts:
            raise wrong("successes", f"a whole number, at most the {attempts:.0f} attempts")
        rate = int(row["successes"]) / attempts
    return {
        "label": row["label"],
        "rate": rate,
        "attempts": attempts,
        "detector": row["detector"] or path.stem,
    }
