"""Failures and, for each, the most similar object of equal difficulty that the detector grasps.

A failure by itself may be a hard object, and a success an easy one. Of a matched pair, both lie at
about the same complexity and graspability, and look alike. Both are tried on drops that nothing was
chosen by, so what comes of these holds for the pair as it is printed.
"""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment

from egad._util.arrays import Flags, Floats
from egad._util.parameters import check_count
from egad._util.progress import progress
from egad._util.workers import Mapper, workers
from egad.cppn import Shape
from egad.errors import RejectedError, UserError, most_common
from egad.evalset import label_at, print_problems
from egad.failures.atlas import CELL, FailureAtlas
from egad.failures.examine import Examination, ObjectVerdict, by_object, counts_of, pairs_of
from egad.failures.finding import open_detector
from egad.failures.parameters import FailureParameters
from egad.failures.search import elite_of, scaled_surface, surface_of
from egad.failures.store import Detect
from egad.map_elites import Archive
from egad.objects import Dataset, dataset_of
from egad.reeb import Forest, similarities
from egad.reeb import graph as reeb
from egad.sim import ENGINES, EngineName
from egad.stats import Rate
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.failures import FAILURE_ATTEMPTS, MATCHED

MOST_PAIRS = 10  # each is a column of the set: its number is a digit of the labels
WITHIN = 2  # cells, in complexity and in difficulty
SUCCEEDS = 0.8  # success rate of the detector and of the reference at a partner, at least
FORBIDDEN = 1e3  # cost of a pair that is none
ROW = {True: 0, False: 1}  # of the labels: A for failures, B for their partners
Row = dict[str, Any]


class CandidateTrial(NamedTuple):
    """Further attempts at an object.

    Attributes:
        attempts: Columns of `tables.failures.FAILURE_ATTEMPTS`.
        reason: Why the object is no partner of a failure; empty if it is.
    """

    attempts: pd.DataFrame
    reason: str = ""


class MatchedSet:
    """Pairs of a failure and the object that is matched to it.

    Attributes:
        table: One row per object, columns of `tables.failures.MATCHED`, sorted by label. The counts
            are those of the drops with the purpose `matched`.
        attempts: One row per simulated grasp that was made for the set, columns of
            `tables.failures.FAILURE_ATTEMPTS`.
        replaced: How many objects were chosen as partners and turned out to be none, by the reason.
        unmatched: How many failures were left out because no object is a partner of theirs.
        shape: How voxels become meshes.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        attempts: pd.DataFrame,
        replaced: dict[str, int],
        unmatched: int,
        shape: Shape,
    ) -> None:
        """Wrap tables."""
        self.table, self.attempts = table.reset_index(drop=True), attempts
        self.replaced, self.unmatched, self.shape = replaced, unmatched, shape

    def __len__(self) -> int:
        return int(self.table["is_failure"].sum())

    def __repr__(self) -> str:
        rates = [
            f"{engine}: detector {self._percent(True, engine)} at failures and "
            f"{self._percent(False, engine)} at their partners"
            for engine in self.engines
        ]
        return f"MatchedSet({len(self)} pairs; {'; '.join(rates)})"

    @property
    def engines(self) -> list[EngineName]:
        """Engines in which all were tried."""
        return [each for each in ENGINES if self.table[f"n_pairs_{each}"].sum()]

    @property
    def objects(self) -> Dataset:
        """All objects as a dataset, with meshes, voxels and genomes."""
        return dataset_of(self.table, self.shape)

    def success_rate(
        self,
        engine: str,
        *,
        failures: bool,
        who: Literal["detector", "reference"] = "detector",
    ) -> Rate:
        """How often objects were held on the drops that nothing was chosen by.

        Args:
            engine: The physics engine.
            failures: At the failures, or at their partners.
            who: Whose grasps.
        """
        rows = self.table[self.table["is_failure"] == failures]
        successes, attempts = rows[f"{who}_successes_{engine}"], rows[f"n_pairs_{engine}"]
        return Rate(int(successes.sum()), int(attempts.sum()))

    def _percent(self, failures: bool, engine: str) -> str:
        return percent(self.success_rate(engine, failures=failures))

    def save(self, folder: str | Path) -> None:
        """Write `pairs.parquet` and `attempts.parquet`.

        `egad.load("FOLDER/pairs.parquet")` reads the objects as a dataset.
        """
        path = Path(folder)
        notes = {
            "shape": self.shape.model_dump(mode="json"),
            "replaced": self.replaced,
            "unmatched": self.unmatched,
        }
        parquet.write(self.table, MATCHED, path / "pairs.parquet", notes)
        parquet.write(self.attempts, FAILURE_ATTEMPTS, path / "attempts.parquet")

    @classmethod
    def load(cls, folder: str | Path) -> "MatchedSet":
        """Read what `save` wrote.

        Raises:
            TableError: A table is missing or damaged.
        """
        path = Path(folder)
        notes = parquet.notes(path / "pairs.parquet")
        return cls(
            parquet.read(path / "pairs.parquet", MATCHED),
            parquet.read(path / "attempts.parquet", FAILURE_ATTEMPTS),
            notes.get("replaced", {}),
            notes.get("unmatched", 0),
            Shape.model_validate(notes.get("shape", {})),
        )


def match_failures(
    atlas: FailureAtlas,
    detect: Detect,
    *,
    pairs: int = 5,
    attempts: int = 20,
    jobs: int = 1,
) -> MatchedSet:
    """Choose failures of an atlas, match objects to them, and try both on fresh drops.

    The failures are spread over the map. Each gets the object that is most similar in shape among
    those that the search found the detector to succeed at, and that lie at most two cells away in
    complexity and in graspability; no object is used twice, and the sum of the similarities is the
    largest. An object becomes a partner only if it can be printed, and if detector and reference
    hold it in 80 % of as many attempts as are asked for. Then all are tried on other drops.

    Args:
        atlas: What `egad.find_failures` returned.
        detect: The detector of the search.
        pairs: At most so many, 1 to 10; fewer if too few failures have a partner.
        attempts: Of the detector and of the reference each, at each object and in each engine.
        jobs: Processes; the result does not depend on them.

    Raises:
        UserError: No failure has a partner, a number is out of bounds, or the atlas was not made by
            a search.
    """
    settings = atlas.searched_with()
    if check_count("pairs", pairs) > MOST_PAIRS:
        raise UserError(f"pairs is {pairs}; allowed: 1 to {MOST_PAIRS}, a digit of the labels each")
    check_count("attempts", attempts)
    known = by_object(atlas.attempts)
    with workers(jobs) as mapper:
        matching = _Matching(atlas, known, attempts, detect, settings, mapper)
        chosen = matching.best(pairs)
        both = [name for pair in chosen for name in pair]
        past = {name: pd.concat([known[name], *matching.further(name)]) for name in both}
        work = partial(_try_fresh, count=attempts, detect=detect, settings=settings)
        items = [(matching.rows[name], past[name]) for name in both]
        fresh = list(progress(mapper(work, items), "trying pairs", len(items)))
    tables = dict(zip(both, fresh, strict=True))
    table = _table(chosen, tables, matching, settings)
    made = pd.concat([*matching.attempts, *fresh], ignore_index=True)
    return MatchedSet(table, made, matching.replaced, matching.unmatched, atlas.shape)


def percent(rate: Rate) -> str:
    """A rate, rounded."""
    return f"{100 * rate.value:.0f} %"


def spread(cells: Floats, regret: Floats) -> list[int]:
    """All objects, those first that are spread over the map.

    The first one has the highest regret; each further one lies farthest, in cells, from the nearest
    one before it, and of those that lie as far it has the highest regret.

    Args:
        cells: (n, 2) cells of the objects.
        regret: (n,) what decides between equals; of equals in this, too, the first one is taken.
    """
    away = np.full(len(cells), np.inf)
    order: list[int] = []
    for _ in range(len(cells)):
        away[order] = -1
        farthest = np.flatnonzero(away == away.max())
        order.append(int(farthest[regret[farthest].argmax()]))
        away = np.minimum(away, np.linalg.norm(cells - cells[order[-1]], axis=1))
    return order


def assign(similarity: Floats, allowed: Flags) -> list[int]:
    """The partner of each row, a column of its own; -1 if none is left for it.

    As many as possible get one; of all ways to do so, the sum of the similarities is the largest.

    Args:
        similarity: (n, m), 0 to 1.
        allowed: (n, m) whether the two may be partners.
    """
    rows, columns = linear_sum_assignment(np.where(allowed, 1 - similarity, FORBIDDEN))
    partners = np.full(len(similarity), -1)
    partners[rows] = np.where(allowed[rows, columns], columns, -1)
    return [int(each) for each in partners]


class _Matching:
    """Looks for pairs; what it has computed and tried is kept.

    Attributes:
        rows: What is known of each failure and of each candidate, by id.
        graphs: Reeb graphs of those that were compared, by id.
        replaced: As of `MatchedSet`.
        unmatched: As of `MatchedSet`.
    """

    def __init__(
        self,
        atlas: FailureAtlas,
        known: dict[str, pd.DataFrame],
        count: int,
        detect: Detect,
        settings: FailureParameters,
        mapper: Mapper,
    ) -> None:
        solved = atlas.examined["verdict"] == ObjectVerdict.DETECTOR_SUCCEEDS
        candidates = atlas.examined[solved].drop_duplicates("id").sort_values("id")
        self._failures = atlas.table.sort_values("id", ignore_index=True)
        self._candidates = candidates.reset_index(drop=True)
        self.rows = {
            row["id"]: row for row in map(_as_examined, parquet.records(self._failures))
        } | {row["id"]: row for row in parquet.records(self._candidates)}
        self._settings, self._mapper = settings, mapper
        self._known = known
        self._qualify = partial(_qualify, count=count, detect=detect, settings=settings)
        self.graphs: dict[str, reeb.ReebGraph] = {}
        self._similar: dict[int, Floats] = {}
        self._tried: dict[str, CandidateTrial] = {}
        self.unmatched = 0
        apart = _cells(self._failures)[:, None] - _cells(self._candidates)[None]
        self._near: Flags = np.asarray((np.abs(apart) <= WITHIN).all(axis=2))

    @property
    def replaced(self) -> dict[str, int]:
        reasons = Counter(each.reason for each in self._tried.values() if each.reason)
        return dict(sorted(reasons.items()))

    @property
    def attempts(self) -> list[pd.DataFrame]:
        """Those by which candidates became partners or did not."""
        return [each.attempts for each in self._tried.values()]

    def further(self, name: str) -> list[pd.DataFrame]:
        """The attempts that were made at a candidate."""
        return [self._tried[name].attempts] if name in self._tried else []

    def similarity(self, pair: tuple[str, str]) -> float:
        """Of the shapes of two objects that were compared."""
        graphs = [self.graphs[name] for name in pair]
        weight = self._settings.breeding.similarity.weight
        return float(similarities(Forest(weight, graphs), np.array([[0, 1]]))[0])

    def best(self, most: int) -> list[tuple[str, str]]:
        """Ids of failures and of their partners.

        Raises:
            UserError: There is no pair.
        """
        some = np.flatnonzero(self._near.any(axis=1))
        self.unmatched = len(self._near) - len(some)
        regret = self._failures[[f"regret_{engine}" for engine in ENGINES]].min(axis=1).fillna(0)
        order = some[spread(_cells(self._failures)[some], regret.to_numpy()[some])].tolist()
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
            if not bad:
                names, others = (
                    table.loc[places, "id"].tolist()
                    for table, places in ((self._failures, chosen), (self._candidates, partners))
                )
                return list(zip(names, others, strict=True))
            self._near[:, bad] = False
        raise UserError(self._nothing())

    def _nothing(self) -> str:
        reasons = most_common(Counter(self.replaced))
        tried = f"; of {len(self._tried)} that were tried again, none is: {reasons}"
        return (
            f"none of {len(self._failures)} failures has an object within {WITHIN} cells that the "
            f"detector succeeds at{tried if self._tried else ''}; give an atlas of more attempts"
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
        """Those partners that turn out to be none; they are tried if they have not been."""
        names = {each: str(self._candidates.loc[each, "id"]) for each in partners}
        fresh = [name for name in names.values() if name not in self._tried]
        items = [(self.rows[name], self._known[name]) for name in fresh]
        found = progress(self._mapper(self._qualify, items), "trying partners", len(items))
        self._tried |= dict(zip(fresh, found, strict=True))
        return [each for each, name in names.items() if self._tried[name].reason]


def _cells(table: pd.DataFrame) -> Floats:
    return table[CELL].to_numpy(dtype=np.float64)


def _as_examined(row: Row) -> Row:
    """A failure with what an examined object has besides."""
    return row | {"verdict": ObjectVerdict.FAILURE.value, "step": row["epoch"]}


def _graph(row: Row, settings: FailureParameters) -> bytes:
    surface = surface_of(row["voxels"], settings)
    return reeb.pack(reeb.extract(surface, settings.breeding.similarity))


def _qualify(
    item: tuple[Row, pd.DataFrame], count: int, detect: Detect, settings: FailureParameters
) -> CandidateTrial:
    """Try a candidate; whether it may be a partner."""
    row, past = item
    mesh, name = scaled_surface(row["voxels"], settings), row["id"]
    nothing = parquet.empty(FAILURE_ATTEMPTS)
    if print_problems(mesh, settings.print_check):
        return CandidateTrial(nothing, "it cannot be printed")
    least = math.ceil(SUCCEEDS * count)
    with open_detector(detect, settings) as asked:
        examination = Examination(mesh, name, asked, settings)
        try:
            attempts = examination.paired("qualify", count, past, least)
        except RejectedError as problem:
            return CandidateTrial(nothing, str(problem))
    for engine in settings.failures.engines:
        pairs = pairs_of(attempts, engine, "qualify")
        for who in ("detector", "reference"):
            if sum(getattr(pair, who) for pair in pairs) < least:
                return CandidateTrial(
                    attempts, f"the {who} succeeds in less than {100 * SUCCEEDS:.0f} %"
                )
    return CandidateTrial(attempts)


def _try_fresh(
    item: tuple[Row, pd.DataFrame], count: int, detect: Detect, settings: FailureParameters
) -> pd.DataFrame:
    """The attempts at an object that nothing is chosen by."""
    row, past = item
    with open_detector(detect, settings) as asked:
        examination = Examination(
            scaled_surface(row["voxels"], settings), row["id"], asked, settings
        )
        return examination.paired("matched", count, past)


def _table(
    chosen: Sequence[tuple[str, str]],
    fresh: dict[str, pd.DataFrame],
    matching: _Matching,
    settings: FailureParameters,
) -> pd.DataFrame:
    """Columns of `tables.failures.MATCHED`: pairs by the complexity of the failure."""
    names = [name for pair in chosen for name in pair]
    space = settings.breeding.space.model_copy(update={"elites_per_cell": len(names)})
    archive = Archive(space, settings.breeding.similarity)
    archive.add(
        elite_of(matching.rows[name] | {"graph": reeb.pack(matching.graphs[name])})
        for name in names
    )
    elites = archive.to_frame().set_index("id", drop=False)[ARCHIVE.names]
    order = sorted(chosen, key=lambda pair: (elites.loc[pair[0], "complexity"], pair))
    rows = [
        {
            "label": label_at(ROW[is_failure], number),
            "pair": number,
            "is_failure": is_failure,
            "similarity": matching.similarity(pair),
            **elites.loc[name].to_dict(),
            **counts_of(fresh[name], "matched"),
        }
        for number, pair in enumerate(order)
        for is_failure, name in zip((True, False), pair, strict=True)
    ]
    return pd.DataFrame(rows).sort_values("label", ignore_index=True)
