"""Choose failures of an atlas and the object matched to each."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from egad._util.arrays import Flags, Floats
from egad._util.progress import progress
from egad._util.workers import Mapper
from egad.bench.failures.atlas import CELL, FailureAtlas
from egad.bench.failures.evidence import ObjectVerdict, by_object, pairs_of
from egad.bench.failures.examine import Examination
from egad.bench.failures.models import scaled_surface, surface_of
from egad.bench.failures.parameters import FailureParameters
from egad.detectors import Detect, FailureMonitor, opened
from egad.errors import RejectedError, UserError, most_common
from egad.evalset import print_problems
from egad.measures import cell_of
from egad.measures.reeb import Forest, similarities
from egad.measures.reeb import graph as reeb
from egad.sim import FAST_ENGINES
from egad.tables import parquet
from egad.tables.failures import FAILURE_ATTEMPTS

REFERENCE = 0.8  # minimum success rate of the reference at a partner
FORBIDDEN = 1e3  # cost of a pair that is not allowed
PATIENCE = 12  # objects tried as the partner of a failure
Row = dict[str, Any]


class PartnerRules(NamedTuple):
    """Requirements for the partner of a failure."""

    within: int = 2  # maximum distance in complexity and in difficulty, cells
    succeeds: float = 0.8  # minimum success rate of the detector, 0 to 1


class CandidateTrial(NamedTuple):
    """Further attempts at an object."""

    attempts: pd.DataFrame  # columns of `tables.failures.FAILURE_ATTEMPTS`
    reason: str = ""  # why the object does not qualify as a partner; empty if it does


def spread(cells: Floats, difference: Floats) -> list[int]:
    """Order all objects by farthest neighbor in cells, (n, 2); ties by the highest difference."""
    away = np.full(len(cells), np.inf)
    order: list[int] = []
    for _ in range(len(cells)):
        away[order] = -1
        farthest = np.flatnonzero(away == away.max())
        order.append(int(farthest[difference[farthest].argmax()]))
        away = np.minimum(away, np.linalg.norm(cells - cells[order[-1]], axis=1))
    return order


def assign(similarity: Floats, allowed: Flags) -> list[int]:
    """The most partners, (n,), -1 for none, with the largest sum of similarities, (n, m)."""
    rows, columns = linear_sum_assignment(np.where(allowed, 1 - similarity, FORBIDDEN))
    partners = np.full(len(similarity), -1)
    partners[rows] = np.where(allowed[rows, columns], columns, -1)
    return [int(each) for each in partners]


class Matching:
    """Looks for pairs, and keeps what it has computed and tried, by id of an object."""

    def __init__(
        self,
        atlas: FailureAtlas,
        archive: pd.DataFrame,
        rules: PartnerRules,
        count: int,
        detect: Detect,
        settings: FailureParameters,
        mapper: Mapper,
    ) -> None:
        """Prepare; an object qualifies as a partner with `count` attempts in each engine."""
        self._failures = atlas.table.sort_values("id", ignore_index=True)
        self._candidates = _candidates(atlas, archive, settings)
        self.rows = {
            row["id"]: row | {"verdict": ObjectVerdict.FAILURE.value, "step": row["epoch"]}
            for row in parquet.records(self._failures)
        } | {row["id"]: row for row in parquet.records(self._candidates)}
        self._settings, self._mapper, self._rules = settings, mapper, rules
        self._known = by_object(atlas.attempts)
        self._qualify = partial(
            _qualify, rules=rules, count=count, detect=detect, settings=settings
        )
        self.graphs: dict[str, reeb.ReebGraph] = {}
        self._similar: dict[int, Floats] = {}
        self._tried: dict[str, CandidateTrial] = {}
        self._in_vain: Counter[int] = Counter()  # partners that did not qualify, by failure
        self._monitor = FailureMonitor(None, keep_going=False, quiet=True, remedy="")
        self.unmatched = 0
        apart = _cells(self._failures)[:, None] - _cells(self._candidates)[None]
        self._near: Flags = np.asarray((np.abs(apart) <= rules.within).all(axis=2))

    @property
    def replaced(self) -> dict[str, int]:
        """How many objects were chosen as partners but did not qualify, by reason."""
        reasons = Counter(each.reason for each in self._tried.values() if each.reason)
        return dict(sorted(reasons.items()))

    @property
    def attempts(self) -> list[pd.DataFrame]:
        """Attempts that decided whether candidates became partners."""
        return [each.attempts for each in self._tried.values()]

    def past(self, name: str) -> pd.DataFrame:
        """All attempts at an object, those of the search first."""
        made = [self._tried[name].attempts] if name in self._tried else []
        return pd.concat([self._of_search(name), *made])

    def _of_search(self, name: str) -> pd.DataFrame:
        return self._known.get(name, parquet.empty(FAILURE_ATTEMPTS))

    def similarity(self, pair: tuple[str, str]) -> float:
        """Similarity of the shapes of two objects that were compared."""
        graphs = [self.graphs[name] for name in pair]
        weight = self._settings.breeding.similarity.weight
        return float(similarities(Forest(weight, graphs), np.array([[0, 1]]))[0])

    def best(self, most: int) -> list[tuple[str, str]]:
        """Ids of failures and of their partners; UserError if there is no pair."""
        some = np.flatnonzero(self._near.any(axis=1))
        self.unmatched = len(self._near) - len(some)
        names = [f"difference_{engine}" for engine in FAST_ENGINES]
        difference = self._failures[names].min(axis=1).fillna(0)
        order = some[spread(_cells(self._failures)[some], difference.to_numpy()[some])].tolist()
        chosen, waiting = order[:most], order[most:]
        while chosen:
            alike = np.array([self._similarities(each) for each in chosen])
            partners = assign(alike, self._near[chosen])
            alone = [each for each, partner in zip(chosen, partners, strict=True) if partner < 0]
            if alone:
                chosen.remove(alone[-1])
                self.unmatched += 1
                chosen += waiting[:1]
                waiting = waiting[1:]
                continue
            bad = self._unqualified(partners)
            self._in_vain.update(
                each for each, partner in zip(chosen, partners, strict=True) if partner in bad
            )
            if not bad:
                names = self._failures.loc[chosen, "id"].tolist()
                others = self._candidates.loc[partners, "id"].tolist()
                return list(zip(names, others, strict=True))
            self._near[:, bad] = False
            self._near[[each for each, times in self._in_vain.items() if times >= PATIENCE]] = False
        raise UserError(self._nothing())

    def _nothing(self) -> str:
        reasons = most_common(Counter(self.replaced))
        tried = f"; of {len(self._tried)} that were tried again, none qualifies: {reasons}"
        return (
            f"none of {len(self._failures)} failures has an object within {self._rules.within} "
            f"cells that the detector succeeds at{tried if self._tried else ''}; give an atlas of "
            "more attempts, allow more cells, or require a lower success rate"
        )

    def _similarities(self, failure: int) -> Floats:
        """Similarities of a failure and all candidates, (m,); NaN for those that are not near."""
        if failure not in self._similar:
            near = np.flatnonzero(self._near[failure])
            name = str(self._failures.loc[failure, "id"])
            names = [name, *self._candidates.loc[near, "id"].tolist()]
            self._read_graphs(names)
            self._similar[failure] = np.full(len(self._candidates), np.nan)
            self._similar[failure][near] = [self.similarity((name, each)) for each in names[1:]]
        return self._similar[failure]

    def _read_graphs(self, names: Iterable[str]) -> None:
        missing = [self.rows[name] for name in names if name not in self.graphs]
        work = partial(_graph, settings=self._settings)
        packed = progress(self._mapper(work, missing), "comparing objects", len(missing))
        for row, graph in zip(missing, packed, strict=True):
            self.graphs[row["id"]] = reeb.unpack(graph)

    def _unqualified(self, partners: Sequence[int]) -> list[int]:
        """The partners that do not qualify; those not tried before are tried now."""
        names = {each: str(self._candidates.loc[each, "id"]) for each in partners}
        fresh = [name for name in names.values() if name not in self._tried]
        items = [(self.rows[name], self._of_search(name)) for name in fresh]
        found = progress(self._mapper(self._qualify, items), "trying partners", len(items))
        for name, each in zip(fresh, found, strict=True):
            self._tried[name] = each
            self._monitor.check(each.attempts[each.attempts["who"] == "detector"])
        return [each for each, name in names.items() if self._tried[name].reason]


def _candidates(
    atlas: FailureAtlas, archive: pd.DataFrame, settings: FailureParameters
) -> pd.DataFrame:
    """Objects that the detector succeeds at, and those that it has not been tried at."""
    solved = atlas.examined["verdict"] == ObjectVerdict.DETECTOR_SUCCEEDS
    tried = set(atlas.attempts["id"])
    cells = [
        cell_of(*values, settings.breeding.space)
        for values in zip(archive["complexity"], archive["graspability"], strict=True)
    ]
    others = archive.assign(**dict(zip(CELL, np.array(cells).reshape(-1, 2).T, strict=True)))
    others = others.assign(verdict="", step=archive["epoch"], objective=0.0)
    found = pd.concat([atlas.examined[solved], others[~others["id"].isin(tried)]])
    return found.drop_duplicates("id").sort_values("id", ignore_index=True)


def _cells(table: pd.DataFrame) -> Floats:
    return table[CELL].to_numpy(dtype=np.float64)


def _graph(row: Row, settings: FailureParameters) -> bytes:
    surface = surface_of(row["voxels"], settings)
    return reeb.pack(reeb.extract(surface, settings.breeding.similarity))


def _qualify(
    item: tuple[Row, pd.DataFrame],
    rules: PartnerRules,
    count: int,
    detect: Detect,
    settings: FailureParameters,
) -> CandidateTrial:
    """Try a candidate, and decide whether it may be a partner."""
    row, past = item
    mesh, name = scaled_surface(row["voxels"], settings), row["id"]
    nothing = parquet.empty(FAILURE_ATTEMPTS)
    if print_problems(mesh, settings.print_check):
        return CandidateTrial(nothing, "it cannot be printed")
    rates = {"detector": rules.succeeds, "reference": REFERENCE}
    least = math.ceil(round(min(rates.values()) * count, 6))
    with opened(detect, settings.planning_time) as asked:
        examination = Examination(mesh, name, asked, settings)
        try:
            attempts = examination.paired("qualify", count, past, least)
        except RejectedError as problem:
            return CandidateTrial(nothing, str(problem))
    for engine in settings.failures.engines:
        pairs = pairs_of(attempts, engine, "qualify")
        for who, rate in rates.items():
            if sum(getattr(pair, who) for pair in pairs) / count < rate:
                return CandidateTrial(
                    attempts, f"the {who} succeeds in less than {100 * rate:.0f} %"
                )
    return CandidateTrial(attempts)
