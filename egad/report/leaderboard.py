"""The page of the leaderboard: who is ahead, where, and films of attempts."""

import string
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Ints
from egad.bench import Reproduction
from egad.bench.stats import (
    Clearing,
    Lead,
    Mean,
    Ranks,
    TrialGrid,
    by_object,
    clearing_rates,
    leads,
    mean_rate,
    ranks,
    trial_grid,
)
from egad.report.page import render_template, svg_uri
from egad.report.trial_charts import outcome_chart, rate_bars, trial_heat_map
from egad.tables.clutter import ROUND

ROWS, COLUMNS = 7, 7


@dataclass(frozen=True)
class Protocol:
    """What tables that are ranked together share; `same` is equal if only the engine differs."""

    name: str
    engine: str
    is_clutter: bool
    text: str
    same: str

    @property
    def title(self) -> str:
        """What was done, and in which engine."""
        what = "Cleared tables" if self.is_clutter else "Single objects"
        return f"{what}, simulated in {self.engine}"


@dataclass(frozen=True)
class SubmittedTable:
    """A verified table, `TRIALS` or `CLUTTER`, and what came of simulating attempts again."""

    entry: str
    protocol: str
    rows: pd.DataFrame
    reproduction: Reproduction
    films: Mapping[str, str]

    @property
    def is_sample(self) -> bool:
        """Whether some objects or rounds were left out."""
        return self.reproduction.attempts + self.reproduction.skipped < len(self.rows)


class Refusal(NamedTuple):
    """A table that the simulation does not reproduce."""

    entry: str
    protocol: str
    reasons: Sequence[str]


@dataclass(frozen=True)
class Board:
    """All that the page shows: entries by name, tables verified or refused, problems."""

    entries: Mapping[str, Mapping[str, Any]]
    protocols: Mapping[str, Protocol]
    tables: Sequence[SubmittedTable] = ()
    refusals: Sequence[Refusal] = ()
    problems: Sequence[str] = ()


@dataclass(frozen=True)
class Standing:
    """A line of a ranking."""

    entry: str
    ranks: Ranks | None  # ranks that it may have; None if it does not compete, or is the only one
    rate: Mean  # the rate that it is ranked by
    success: Mean  # success rate of the attempts; for single objects, the same


@dataclass(frozen=True)
class Ranking:
    """The entries of a protocol, or of one kind of its scenes, best first."""

    title: str  # kind of scene, or empty
    standings: list[Standing]
    leads: list[Lead]  # differences of all pairs that compete


@dataclass(frozen=True)
class ProtocolView:
    """All entries of a protocol; figures are addresses."""

    protocol: Protocol
    rankings: list[Ranking]  # one; for cleared tables, one for each kind of scene and noise
    outcomes: str
    # success by row and column of the evaluation set; none for cleared tables
    grids: dict[str, TrialGrid] = field(default_factory=dict)
    rows: str = ""  # chart of the success by row
    columns: str = ""  # the same by column


@dataclass(frozen=True)
class SubmittedTableView:
    """A table of an entry."""

    table: SubmittedTable
    title: str
    heat_map: str  # success of each object, empty for cleared tables
    # what can be filmed: a name, the words of the command before and after the number, and
    # the result for each number
    choices: list[tuple[str, str, str, list[str]]]


def page(board: Board) -> str:
    """The page; films are stored next to it."""
    known = sorted(board.protocols.values(), key=lambda each: each.is_clutter)
    order = [each for each in known if _tables(board, each)]
    views = [_view(board, each) for each in order]
    standings = {view.protocol.name: view.rankings for view in views}
    return render_template(
        "leaderboard.html.j2",
        board=board,
        views=views,
        engines=list(_by_engine(board, standings)),
        tables={name: list(_own(board, name)) for name in board.entries},
        letters=string.ascii_uppercase[:ROWS],
        digits=string.digits[:COLUMNS],
        is_sample=any(each.is_sample for each in board.tables),
    )


def _tables(board: Board, protocol: Protocol) -> list[SubmittedTable]:
    return [each for each in board.tables if each.protocol == protocol.name]


def _view(board: Board, protocol: Protocol) -> ProtocolView:
    tables = {each.entry: each.rows for each in _tables(board, protocol)}
    if protocol.is_clutter:
        kinds = pd.concat(tables.values())[["scene", "noise"]].drop_duplicates()
        rankings = [
            _clearing_ranking(board, tables, scene, noise)
            for scene, noise in kinds.itertuples(index=False)
        ]
        return ProtocolView(protocol, rankings, svg_uri(outcome_chart(tables)))
    ranking = _ranking(board, "", {name: mean_rate(rows) for name, rows in tables.items()}, tables)
    tables = {each.entry: tables[each.entry] for each in ranking.standings}
    grids = {name: trial_grid(rows, ROWS, COLUMNS) for name, rows in tables.items()}
    by_row = {name: [*grid.rows, grid.overall] for name, grid in grids.items()}
    by_column = {name: [*grid.columns, grid.overall] for name, grid in grids.items()}
    return ProtocolView(
        protocol,
        [ranking],
        svg_uri(outcome_chart(tables)),
        grids,
        svg_uri(rate_bars(by_row)),
        svg_uri(rate_bars(by_column, string.digits)),
    )


def _clearing_ranking(
    board: Board, tables: Mapping[str, pd.DataFrame], scene: str, noise: str
) -> Ranking:
    """Ranking by the share of objects that were cleared."""
    own = {
        name: rows[(rows["scene"] == scene) & (rows["noise"] == noise)]
        for name, rows in tables.items()
    }
    found: dict[str, Clearing] = {name: clearing_rates(rows)[0] for name, rows in own.items()}
    return _ranking(
        board,
        f"{scene}, noise {noise}",
        {name: each.cleared for name, each in found.items()},
        own,
        {name: each.success for name, each in found.items()},
    )


def _ranking(
    board: Board,
    title: str,
    rates: Mapping[str, Mean],
    tables: Mapping[str, pd.DataFrame],
    success: Mapping[str, Mean] | None = None,
) -> Ranking:
    competing = [name for name in tables if not board.entries[name]["reference"]]
    units = [_units(tables[name]) for name in competing]
    pairs = []
    if competing:
        successes = {name: won for name, (won, _) in zip(competing, units, strict=True)}
        pairs = leads(successes, units[0][1])
    places = ranks(competing, pairs) if pairs else {}
    order = sorted(tables, key=lambda name: -rates[name].value)
    standings = [
        Standing(name, places.get(name), rates[name], (success or rates)[name]) for name in order
    ]
    return Ranking(title, standings, pairs)


def _units(rows: pd.DataFrame) -> tuple[Ints, Ints]:
    """Successes and attempts of each object, or successes and objects of each round."""
    if "scene" in rows:
        rounds = rows.groupby(ROUND).agg({"success": "sum", "n_objects": "first"})
        return rounds["success"].to_numpy(np.int64), rounds["n_objects"].to_numpy(np.int64)
    objects = by_object(rows)
    return objects["successes"].to_numpy(), objects["attempts"].to_numpy()


def _by_engine(
    board: Board, rankings: Mapping[str, list[Ranking]]
) -> Iterator[tuple[str, dict[str, dict[str, Standing]]]]:
    """Rankings that differ only in the engine: title, then standings by entry and engine."""
    groups: dict[str, list[Protocol]] = {}
    for each in board.protocols.values():
        if each.name in rankings:
            groups.setdefault(each.same, []).append(each)
    for protocols in groups.values():
        for number, ranking in enumerate(rankings[protocols[0].name] if protocols[1:] else []):
            found: dict[str, dict[str, Standing]] = {}
            for each in protocols:
                for standing in rankings[each.name][number].standings:
                    found.setdefault(standing.entry, {})[each.engine] = standing
            what = "Cleared tables" if protocols[0].is_clutter else "Single objects"
            yield ", ".join(filter(None, [what, ranking.title])), found


def _own(board: Board, entry: str) -> Iterator[SubmittedTableView]:
    for table in board.tables:
        if table.entry != entry:
            continue
        protocol, rows = board.protocols[table.protocol], table.rows
        if protocol.is_clutter:
            yield SubmittedTableView(table, protocol.title, "", list(_rounds(rows)))
            continue
        grid = trial_grid(rows, ROWS, COLUMNS)
        heat_map = svg_uri(trial_heat_map(grid, ROWS, COLUMNS, set(rows["label"])))
        choices = [
            (str(label), f"replay {label}", "", own["outcome"].str.replace("_", " ").tolist())
            for label, own in rows.groupby("label")
        ]
        yield SubmittedTableView(table, protocol.title, heat_map, choices)


def _rounds(rows: pd.DataFrame) -> Iterator[tuple[str, str, str, list[str]]]:
    """Rounds of each kind of scene, as in `SubmittedTableView.choices`."""
    for (scene, noise), own in rows.groupby(["scene", "noise"], sort=False):
        rounds = own.groupby("round").agg({"success": "sum", "n_objects": "first"})
        counts = rounds.itertuples(index=False)
        held = [f"{won} of {there} held" for won, there in counts]
        yield f"{scene}, noise {noise}", f"film {scene}", f"--noise {noise}", held
