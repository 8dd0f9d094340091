"""Results of trials from any source: tables of the simulation, or a CSV file of a real robot.

The CSV file has one row per attempt and the columns label, attempt and success, and optionally
outcome, quality, detector and valid. Rows with an empty success have not been tried yet and are
left out, as are those that are not valid.

A file with a column session is a log, as exported by the page of `egad log-sheet`, and has the
columns `LOG_COLUMNS`. Rows of a log that cannot be used are left out with a warning; in other files
they are errors.
"""

import logging
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.input_limits import MAX_COLUMNS
from egad.errors import UserError, most_common
from egad.evalset import SelectEval, in_grid, labels_of
from egad.io import csv_lines
from egad.tables import parquet
from egad.tables.columns import INITIAL
from egad.tables.evaluation import RESULTS, TRIALS
from egad.tables.outcomes import Outcome

log = logging.getLogger(__name__)

NEEDED = ("label", "attempt", "success")
COLUMNS = (*NEEDED, "outcome", "quality", "detector")
LOG_SCHEMA = "1"  # version of the following columns
LOG_COLUMNS = (
    *("schema", "session", "order", "time", "label", "id", "attempt", "detector", "version"),
    *("success", "outcome", "valid", "reason", "note"),
    *("operator", "robot", "gripper", "pads", "camera", "calibration", "prints"),
    *("blind", "seed", "record"),
)
READ = (*COLUMNS, "id", "valid", "reason", "session", "schema", "record")
# Also as spreadsheets write truth values in languages of Europe
TRUE = "1 1.0 true yes y wahr ja vrai oui verdadero vero verdadeiro waar prawda sant sand sann tosi"
TRUE += " pravda igaz doğru adevărat cert истина істина"
FALSE = "0 0.0 false no n falsch nein faux non falso onwaar fałsz falskt falsk usann epätosi"
FALSE += " nepravda hamis yanliş fals ложь хибність"
TEXT = (".csv", ".txt", ".tsv")
WORDS = {**dict.fromkeys(TRUE.split(), True), **dict.fromkeys(FALSE.split(), False)}
MAX_TOLD = 5  # warnings of one kind about a log
ATTEMPT = re.compile(r"[0-9]{1,9}")
ATTEMPT_KEY = ["detector", "label", "attempt"]


def template(labels: Sequence[str], attempts: int, detector: str) -> pd.DataFrame:
    """A table to fill in: a row for each attempt at each object, with the success left empty."""
    rows = [(label, number) for label in labels for number in range(attempts)]
    frame = pd.DataFrame(rows, columns=["label", "attempt"])
    return frame.assign(success="", outcome="", quality="", detector=detector)


def read(path: Path) -> dict[str, pd.DataFrame]:
    """Read results.

    Args:
        path: `.parquet`, written by the simulation or by `egad trials report`; or text: `.csv`,
            or `.txt` and `.tsv` of spreadsheets.

    Returns:
        Columns of `tables.evaluation.RESULTS`, by detector. Tables of the simulation and rows
        without a detector get the name of the file.

    Raises:
        UserError: The file cannot be used; the message says which row, and what is allowed.
        TableError: The file is not a Parquet file with these columns.
    """
    frame = _csv(path) if path.suffix.lower() in TEXT else _parquet(path)
    return {str(name): table.reset_index(drop=True) for name, table in frame.groupby("detector")}


def gather(paths: Sequence[Path]) -> dict[str, pd.DataFrame]:
    """The results of several files by detector; equal names get their folder, else UserError."""
    found: dict[str, pd.DataFrame] = {}
    for path in paths:
        for name, table in read(path).items():
            key = name if name not in found else f"{path.parent.name}/{name}"
            if key in found:
                raise UserError(f"{path}: two tables have the same detector {key}; rename one")
            found[key] = table
    return found


def _parquet(path: Path) -> pd.DataFrame:
    if "detector" in parquet.columns(path):
        return parquet.read(path, RESULTS)
    return results(parquet.read(path, TRIALS), path.stem)


def results(trials: pd.DataFrame, detector: str) -> pd.DataFrame:
    """Simulated `tables.evaluation.TRIALS` of a detector as `tables.evaluation.RESULTS`."""
    poses = trials[list(INITIAL)].to_numpy(np.float64)
    starts = ["" if np.isnan(pose).any() else pose.tobytes().hex() for pose in poses]
    return trials.assign(detector=detector, initial_pose=starts).loc[:, list(RESULTS.names)]


def _csv(path: Path) -> pd.DataFrame:
    (_, names), *lines = csv_cells(path, READ, ["quality"])
    names = [name.lower() for name in names]
    if missing := [name for name in NEEDED if name not in names]:
        raise UserError(
            f"{path}: the column {missing[0]} is missing; needed: {', '.join(NEEDED)}; "
            f"allowed: {', '.join(COLUMNS)}"
        )
    if repeated := [name for name in READ if names.count(name) > 1]:
        raise UserError(f"{path}: the column {repeated[0]} occurs twice")
    blank = dict.fromkeys(READ, "")
    cells = [(line, blank | dict(zip(names, row, strict=True))) for line, row in lines]
    is_log = "session" in names
    rows = _rows(path, cells, is_log)
    if not rows:
        raise UserError(f"{path}: no row says whether the attempt was a success")
    frame = pd.DataFrame(rows)
    frame = _joined_sessions(path, frame) if is_log else frame
    twice = frame.duplicated(ATTEMPT_KEY)
    if twice.any():
        first = frame[twice].iloc[0]
        raise UserError(f"{path}: attempt {first['attempt']} at {first['label']} occurs twice")
    return frame.loc[:, list(RESULTS.names)]


def _rows(
    path: Path, cells: Sequence[tuple[int, Mapping[str, str]]], is_log: bool
) -> list[dict[str, object]]:
    """The attempts that were made and are valid, as from `_row`; a warning counts invalid ones."""
    rows, problems, not_valid = [], [], Counter[str]()
    labels = {row["label"] for _, row in cells} - {""}
    alike = {label for label in labels if label.upper() in _cells()}
    grid = alike == labels and not in_grid(labels)
    if alike and alike != labels and not in_grid(labels):
        names = ", ".join(sorted(labels - alike)[:MAX_TOLD])
        log.warning("%s: labels are taken as names, not cells of the grid, due to %s", path, names)
    if cells and is_log and not {row["schema"] for _, row in cells} & {"", LOG_SCHEMA}:
        line, row = cells[0]
        raise _wrong(path, line, row, "schema", f"{LOG_SCHEMA}; a newer egad may know it")
    for line, row in cells:
        try:
            if not _is_valid(path, line, row):
                not_valid[row["reason"] or "no reason given"] += 1
            elif row["success"]:
                rows.append(_row(path, line, row, grid))
        except UserError as problem:
            if not is_log:
                raise
            problems.append(str(problem))
    if not_valid:
        count = not_valid.total()
        log.warning("%s: %d attempts are not valid: %s", path, count, most_common(not_valid))
    _tell(path, problems)
    return rows


@cache
def _cells() -> frozenset[str]:
    """The labels of an evaluation set of the usual size."""
    return frozenset(labels_of(SelectEval().rows, SelectEval().columns))


def _is_valid(path: Path, line: int, row: Mapping[str, str]) -> bool:
    """Whether an attempt counts; by default it does."""
    if row["session"] and row["schema"] not in ("", LOG_SCHEMA):
        raise _wrong(path, line, row, "schema", LOG_SCHEMA)
    valid = WORDS.get(row["valid"].lower() or "1")
    if valid is None:
        raise _wrong(path, line, row, "valid", "1, 0, true, false, yes or no, or nothing")
    return valid


def _joined_sessions(path: Path, rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts of a log, each once; later sessions count on, duplicates are left out."""
    rows = rows.drop_duplicates(["session", *ATTEMPT_KEY, "outcome", "record"])
    differ = rows.duplicated(["session", *ATTEMPT_KEY], keep=False)
    groups = rows[differ].groupby(["session", *ATTEMPT_KEY], sort=False)
    _tell(
        path,
        [
            f"{path}, lines {' and '.join(map(str, group['line']))}: session {session} has "
            f"several results of attempt {attempt} at {label} by {detector}: "
            f"{' and '.join(group['outcome'])}"
            for (session, detector, label, attempt), group in groups
        ],
    )
    rows = rows[~differ].reset_index(drop=True)
    if rows.empty:
        raise UserError(f"{path}: no attempt is left")
    before = rows.groupby(ATTEMPT_KEY).cumcount()
    if before.any():
        first = rows["attempt"].max() + 1
        rows["attempt"] += before * first
        log.warning(
            "%s: %d attempts were made in an earlier session, too; they are numbered from %d on",
            path,
            (before > 0).sum(),
            first,
        )
    return rows


def _tell(path: Path, problems: Sequence[str]) -> None:
    """Warn about what is left out of a log."""
    for problem in problems[:MAX_TOLD]:
        log.warning("%s; left out", problem)
    if len(problems) > MAX_TOLD:
        log.warning("%s: %d more like these are left out", path, len(problems) - MAX_TOLD)


def csv_cells(
    path: Path, columns: Collection[str], numbers: Collection[str]
) -> list[tuple[int, list[str]]]:
    """The lines of a CSV file (`egad.io.csv_lines`), each as long as the first."""
    filled = csv_lines(path, columns, numbers)
    if not filled:
        raise UserError(f"{path}: not a CSV file: it is empty")
    width = len(filled[0][1])
    if width > MAX_COLUMNS:
        raise UserError(f"{path}: {width} columns; at most {MAX_COLUMNS} are read")
    for line, row in filled:
        if any(row[width:]):
            raise UserError(f"{path}, line {line}: {len(row)} cells; the first line has {width}")
    return [(line, [*row, *[""] * width][:width]) for line, row in filled]


def _row(path: Path, line: int, row: Mapping[str, str], grid: bool) -> dict[str, object]:
    """One attempt, with the line and session that it comes from; `grid`: cells are meant."""
    wrong = partial(_wrong, path, line, row)
    success = WORDS.get(row["success"].lower())
    if success is None:
        raise wrong("success", "1, 0, true, false, yes or no")
    if not row["label"] or (grid and row["label"] not in _cells()):
        raise wrong("label", row["label"].upper() or "a name")
    if not ATTEMPT.fullmatch(row["attempt"]):
        raise wrong("attempt", "a whole number of at most 9 digits")
    outcome = row["outcome"].lower().replace(" ", "_") or (
        Outcome.SUCCESS if success else Outcome.OTHER
    )
    if outcome not in list(Outcome):
        raise wrong("outcome", ", ".join(Outcome))
    if (outcome == Outcome.SUCCESS) != success:
        raise wrong("outcome", "success if and only if success is 1")
    try:
        quality = float(row["quality"]) if row["quality"] else np.nan
    except ValueError as error:
        raise wrong("quality", "a number, or nothing") from error
    return {
        "label": row["label"],
        "id": row["id"] if row["session"] else "",
        "attempt": int(row["attempt"]),
        "success": success,
        "outcome": Outcome(outcome).value,
        "quality": quality,
        "detector": row["detector"] or path.stem,
        "initial_pose": "",
        **dict.fromkeys(("engine", "errors", "contact"), ""),
        "line": line,
        "session": row["session"],
        "record": row["record"],
    }


def _wrong(path: Path, line: int, row: Mapping[str, str], column: str, wanted: str) -> UserError:
    return UserError(f"{path}, line {line}: {column} is {row[column]!r}; allowed: {wanted}")
