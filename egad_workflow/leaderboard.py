"""The leaderboard: verify submitted tables of attempts in simulation, and rank them on a page.

`python -m egad_workflow.leaderboard` reads the folder `leaderboard/`: `protocols/NAME.yaml`, each a
configuration, and `entries/ENTRY/`, each with an `entry.yaml` (`Entry`) and a table
`PROTOCOL.parquet` for every protocol that it names.
"""

import argparse
import logging
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Annotated

import pandas as pd
from pydantic import AfterValidator, Field, StringConstraints

from egad._util.files import atomic_output, write_text
from egad._util.parameters import Name, Parameters, from_file
from egad.bench import (
    ClutterParameters,
    Models,
    TrialParameters,
    film_attempt,
    film_clearing,
    gaps,
    groups_of,
    refusal,
    verify_groups,
)
from egad.errors import EgadError, UserError
from egad.exchange import evaluation_set_models
from egad.grippers import Gripper
from egad.objects import EVALUATION_SET, load
from egad.report.leaderboard import Board, Protocol, Refusal, SubmittedTable, page
from egad.sim import check_engine
from egad.tables import parquet
from egad.tables.clutter import CLUTTER, ROUND
from egad.tables.evaluation import TRIALS
from egad.tables.outcomes import Outcome
from egad_workflow.check import check
from egad_workflow.config_files import defaults, merged, read_values
from egad_workflow.settings import Settings, select

log = logging.getLogger(__name__)

FOLDER, OUT = Path("leaderboard"), Path("build/leaderboard")
SHOWN = 5  # problems of a table that are told
PROTOCOLS, ENTRIES, ENTRY, FILMS = "protocols", "entries", "entry.yaml", "films"
NAME = "[a-z0-9][a-z0-9_-]*"  # of an entry
Text = Annotated[str, StringConstraints(min_length=1, max_length=200, strip_whitespace=True)]


def _is_address(text: str) -> str:
    if not re.fullmatch(r"https?://\S+", text):
        raise ValueError(f"link is {text!r}; allowed: an address, http://... or https://...")
    return text


class Entry(Parameters):
    """What is known of the detector that made the tables of an entry."""

    detector: Text
    """name of the detector"""
    by: Text
    """who submits the entry"""
    hardware: Text
    """processor and operating system that the tables were made on"""
    protocols: tuple[Name, ...] = Field(min_length=1)
    """names of the protocols, each with a table PROTOCOL.parquet"""
    paper: Text | None = None
    """paper that describes the detector"""
    link: Annotated[Text, AfterValidator(_is_address)] | None = None
    """web address of the code or weights"""
    sees: Text | None = None
    """what the detector gets, e.g. one depth image"""
    seconds: float | None = Field(None, gt=0)
    """median time from the images to the grasps, on that hardware"""
    license: Text = "CC-BY-4.0"
    """license of the tables"""
    reference: Text | None = None
    """why the entry does not compete: it is then shown, but not ranked"""


@dataclass(frozen=True)
class Checks:
    """How tables are verified."""

    sample: int | None = None  # objects or rounds of each table to simulate again; all if None
    jobs: int = 1  # processes; the result does not depend on them


def read_entry(path: Path) -> Entry:
    """The file of an entry; a `UserError` has a line for each value that is missing or wrong."""
    if not path.is_file():
        raise UserError(f"{path} is missing")
    values = read_values(path)
    if not isinstance(values, dict):
        raise UserError(f"{path}: not a table of values; needed: {', '.join(Entry.model_fields)}")
    try:
        return from_file(Entry, values)
    except UserError as error:
        raise UserError("\n".join(f"{path}: {each}" for each in str(error).split("\n"))) from error


def read_protocol(path: Path) -> tuple[Protocol, Settings]:
    """A protocol: a configuration with a section `trials` or `clutter` and one gripper."""
    try:
        values = read_values(path)
        if not {"trials", "clutter"} & set(values or ()):
            raise UserError("a protocol needs a section trials or clutter")
        settings = check(merged(defaults(), values))
        is_clutter = "clutter" in values
        section = settings.clutter if is_clutter else settings.trials
        check_engine(section.engine)
    except (OSError, UserError) as error:
        raise UserError(f"{path}: {error}") from error
    text = path.read_text(encoding="utf-8")
    same = settings.model_dump(mode="json")
    same["clutter" if is_clutter else "trials"]["engine"] = ""
    return Protocol(path.stem, section.engine, is_clutter, text, repr(same)), settings


def build(folder: Path, out: Path, checks: Checks) -> list[str]:
    """Write the page and films; a sentence for each table that is missing, broken or refused."""
    problems: list[str] = []
    protocols = dict(_protocols(folder / PROTOCOLS, problems))
    entries = dict(_entries(folder / ENTRIES, problems))
    models = cache(evaluation_set_models)
    tables: list[SubmittedTable] = []
    refusals: list[Refusal] = []
    with atomic_output(out, keep=False) as made:
        (made / FILMS).mkdir(parents=True)
        for name, path in _listed(folder / ENTRIES, entries, problems):
            if path.stem not in protocols:
                if not (folder / PROTOCOLS / f"{path.stem}.yaml").exists():
                    problems.append(f"{path}: there is no protocol {path.stem}")
                continue  # its problems have been reported
            submitted = _Submitted(name, path, *protocols[path.stem])
            try:
                tables.append(_verified(submitted, models, checks, made))
            except _NotVerifiedError as error:
                refusals.append(Refusal(name, path.stem, error.reasons))
            except EgadError as error:
                problems.append(str(error))
        board = Board(
            {name: entry.model_dump() for name, entry in entries.items()},
            {name: protocol for name, (protocol, _) in protocols.items()},
            tables,
            refusals,
            problems,
        )
        write_text(made / "index.html", page(board))
    return problems + [f"{e.entry}, {e.protocol}: {'; '.join(e.reasons)}" for e in refusals]


@dataclass(frozen=True)
class _Submitted:
    """A table of an entry, and the protocol that it says it follows."""

    entry: str
    path: Path
    protocol: Protocol
    settings: Settings

    @property
    def gripper(self) -> str:
        return self.settings.targets.grippers[0]

    @property
    def rules(self) -> TrialParameters | ClutterParameters:
        if self.protocol.is_clutter:
            return select(self.settings, ClutterParameters, self.gripper)
        return select(self.settings, TrialParameters, self.gripper)


class _NotVerifiedError(Exception):
    """The simulation does not reproduce a table."""

    def __init__(self, reasons: list[str]) -> None:
        self.reasons = reasons
        super().__init__(*reasons)


def _protocols(
    folder: Path, problems: list[str]
) -> Iterator[tuple[str, tuple[Protocol, Settings]]]:
    for path in sorted(folder.glob("*.yaml")):
        try:
            yield path.stem, read_protocol(path)
        except UserError as error:
            problems += str(error).split("\n")


def _entries(folder: Path, problems: list[str]) -> Iterator[tuple[str, Entry]]:
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder")
    for path in sorted(each for each in folder.iterdir() if each.is_dir()):
        try:
            if not re.fullmatch(NAME, path.name):
                raise UserError(
                    f"{path}: its name may only have lowercase letters, digits, _ and -"
                )
            yield path.name, read_entry(path / ENTRY)
        except UserError as error:
            problems += str(error).split("\n")


def _listed(
    folder: Path, entries: Mapping[str, Entry], problems: list[str]
) -> Iterator[tuple[str, Path]]:
    """The tables that entries name; other tables are reported as problems."""
    for name, entry in entries.items():
        yield from ((name, folder / name / f"{each}.parquet") for each in entry.protocols)
        problems += [
            f"{path}: {ENTRY} does not name the protocol {path.stem}"
            for path in sorted((folder / name).glob("*.parquet"))
            if path.stem not in entry.protocols
        ]


def _verified(
    this: _Submitted, models_of: Callable[[Gripper, str], Models], checks: Checks, out: Path
) -> SubmittedTable:
    """A table that the simulation reproduces, with films of it; otherwise `_NotVerifiedError`."""
    if not this.path.is_file():
        raise UserError(f"{this.path} is missing: {ENTRY} names this protocol")
    rows = parquet.read(this.path, CLUTTER if this.protocol.is_clutter else TRIALS)
    if reasons := list(_contradictions(this, rows)):
        more = [f"and {len(reasons) - SHOWN} more"] if len(reasons) > SHOWN else []
        raise _NotVerifiedError(reasons[:SHOWN] + more)
    models = models_of(this.settings.grippers[this.gripper], this.settings.rescale.rule)
    groups = groups_of(rows, checks.sample, this.settings.seed)
    try:
        reproduction = verify_groups(groups, models, this.rules, checks.jobs)
    except UserError as error:
        raise _NotVerifiedError([str(error)]) from error
    if reasons := refusal(reproduction, rows):
        raise _NotVerifiedError(reasons)
    log.info("%s, %s: %s", this.entry, this.protocol.name, reproduction)
    films = dict(_films(this, rows, models, out))
    return SubmittedTable(this.entry, this.protocol.name, rows, reproduction, films)


def _contradictions(this: _Submitted, rows: pd.DataFrame) -> Iterator[str]:
    """Problems of a table that can be found without simulating it."""
    if set(rows["engine"]) != {this.protocol.engine}:
        yield f"the engine is not {this.protocol.engine} in all rows"
    if (rows["success"] != (rows["outcome"] == Outcome.SUCCESS)).any():
        yield "success and outcome contradict each other"
    yield from gaps(rows, load(EVALUATION_SET).table, this.rules)


def _films(
    this: _Submitted, rows: pd.DataFrame, models: Models, out: Path
) -> Iterator[tuple[str, str]]:
    """Films of a success and a failure in a table: what they show, and their addresses."""
    films = _clearing_films if this.protocol.is_clutter else _attempt_films
    for title, words, film in films(this, rows, models):
        address = f"{FILMS}/{this.entry}-{this.protocol.name}-{words}.gif"
        try:
            film(out / address)
        except UserError as error:  # it ended otherwise than in the table
            log.warning("%s, %s: %s", this.path, title, error)
        else:
            yield title, address


FilmOf = tuple[str, str, Callable[[Path], object]]  # what it shows, its name, and what makes it


def _attempt_films(this: _Submitted, rows: pd.DataFrame, models: Models) -> Iterator[FilmOf]:
    """The first success, and the first failure of the most frequent kind."""
    started = rows[rows["initial_pose"] != ""]
    lost = started[~started["success"]]
    often = lost[lost["outcome"] == lost["outcome"].mode().get(0)]
    settings = select(this.settings, TrialParameters, this.gripper)
    for row in parquet.records(pd.concat([started[started["success"]].head(1), often.head(1)])):
        label, attempt = row["label"], int(row["attempt"])
        title = f"{label}, attempt {attempt}: {row['outcome'].replace('_', ' ')}"
        film = partial(film_attempt, settings, this.path, models, label, attempt)
        yield title, f"{label}-{attempt}", film


def _clearing_films(this: _Submitted, rows: pd.DataFrame, models: Models) -> Iterator[FilmOf]:
    """For each kind of scene, the first round that was cleared and the first that was not."""
    rounds = rows[rows["n_objects"] > 0].groupby(ROUND, sort=False, as_index=False)
    table = rounds.agg(held=("success", "sum"), there=("n_objects", "first"))
    table = table.assign(cleared=table["held"] == table["there"])
    settings = select(this.settings, ClutterParameters, this.gripper)
    for row in parquet.records(table.groupby(["scene", "noise", "cleared"], sort=False).head(1)):
        name = row["scene"], row["noise"], int(row["round"])
        title = f"{name[0]}, noise {name[1]}, round {name[2]}: {row['held']} of {row['there']} held"
        film = partial(film_clearing, settings, this.path, models, name)
        yield title, "-".join(map(str, name)), film


def main() -> None:
    """Verify the tables and write the page; exit with 1 if an entry is not on it as submitted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument(
        "--sample", type=int, help="number of objects, or rounds, of each table; default: all"
    )
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    if given.sample is not None and given.sample < 1:
        parser.error(f"--sample is {given.sample}; allowed: at least 1")
    checks = Checks(given.sample, given.jobs)
    try:
        problems = build(given.folder, given.out, checks)
    except UserError as error:
        sys.exit(f"Error: {error}")
    print(f"{given.out / 'index.html'}: written")
    sys.exit("\n".join(problems) or 0)


if __name__ == "__main__":
    main()
