"""Failures and, for each, the most similar object of equal difficulty that the detector grasps.

A failure by itself may be a hard object, and a success an easy one. The objects of a matched pair
have about the same complexity and graspability, and look alike. Both are tried on drops that were
not used to choose anything, so the results hold for the pair as it is printed.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Literal

import pandas as pd

from egad._util.parameters import check_count
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.failures.atlas import FailureAtlas
from egad.bench.failures.evidence import counts_of
from egad.bench.failures.examine import Examination
from egad.bench.failures.matching import Matching, PartnerRules, Row
from egad.bench.failures.models import scaled_surface
from egad.bench.failures.parameters import FailureParameters
from egad.bench.failures.search import elite_of
from egad.bench.stats import Rate
from egad.detectors import Detect, opened
from egad.errors import UserError
from egad.evalset import label_at
from egad.evolution import Archive, Shape
from egad.measures.reeb import graph as reeb
from egad.objects import Dataset, dataset_of, load
from egad.sim import FAST_ENGINES, EngineName
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.failures import FAILURE_ATTEMPTS, MATCHED

MAX_PAIRS = 10  # each is a column of the set: its number is a digit of the labels
ROW = {True: 0, False: 1}  # of the labels: A for failures, B for their partners


class MatchedSet:
    """Pairs of a failure and the object matched to it.

    Attributes:
        table: One row per object, columns of `tables.failures.MATCHED`, sorted by label. The counts
            are those of the drops with the purpose `matched`.
        attempts: One row per simulated grasp that was made for the set, columns of
            `tables.failures.FAILURE_ATTEMPTS`.
        replaced: How many objects were chosen as partners but did not qualify, by reason.
        unmatched: How many failures were left out because they have no partner.
        shape: How voxels become meshes.
        rules: Requirements for the partners.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        attempts: pd.DataFrame,
        replaced: dict[str, int],
        unmatched: int,
        shape: Shape,
        rules: PartnerRules,
    ) -> None:
        """Wrap tables."""
        self.table, self.attempts = table.reset_index(drop=True), attempts
        self.replaced, self.unmatched, self.shape = replaced, unmatched, shape
        self.rules = rules

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
        return [each for each in FAST_ENGINES if self.table[f"n_pairs_{each}"].sum()]

    @property
    def objects(self) -> Dataset:
        """All objects as a dataset, with meshes, voxels and genomes."""
        return dataset_of(self.table, self.shape)

    def success_rate(
        self, engine: str, *, failures: bool, who: Literal["detector", "reference"] = "detector"
    ) -> Rate:
        """How often objects, the failures or their partners, were held on the fresh drops."""
        rows = self.table[self.table["is_failure"] == failures]
        successes, attempts = rows[f"{who}_successes_{engine}"], rows[f"n_pairs_{engine}"]
        return Rate(int(successes.sum()), int(attempts.sum()))

    def _percent(self, failures: bool, engine: str) -> str:
        return percent(self.success_rate(engine, failures=failures))

    def save(self, folder: str | Path) -> None:
        """Write `pairs.parquet`, which `egad.load` reads as a dataset, and `attempts.parquet`."""
        path = Path(folder)
        notes = {
            "shape": self.shape.model_dump(mode="json"),
            "replaced": self.replaced,
            "unmatched": self.unmatched,
            "rules": self.rules._asdict(),
        }
        parquet.write(self.table, MATCHED, path / "pairs.parquet", notes)
        parquet.write(self.attempts, FAILURE_ATTEMPTS, path / "attempts.parquet")

    @classmethod
    def load(cls, folder: str | Path) -> "MatchedSet":
        """Read a set written by `save`; TableError if a table is missing or damaged."""
        path = Path(folder)
        notes = parquet.notes(path / "pairs.parquet")
        return cls(
            parquet.read(path / "pairs.parquet", MATCHED),
            parquet.read(path / "attempts.parquet", FAILURE_ATTEMPTS),
            notes.get("replaced", {}),
            notes.get("unmatched", 0),
            Shape.model_validate(notes.get("shape", {})),
            PartnerRules(**notes.get("rules", {})),
        )


def match_failures(
    atlas: FailureAtlas,
    detect: Detect,
    *,
    pairs: int = 5,
    attempts: int = 20,
    within: int = 2,
    succeeds: float = 0.8,
    objects: Dataset | None = None,
    jobs: int = 1,
) -> MatchedSet:
    """Choose failures of an atlas, match objects to them, and try both on fresh drops.

    The failures are spread over the map. Each gets the object that is most similar in shape among
    those in the cells around it that the detector succeeded at in the search, or that were not
    tried. No object is used twice, and the assignment maximizes the sum of the similarities. An
    object becomes a partner only if it can be printed, and if detector and reference hold it often
    enough in the requested number of attempts. A failure is left out after 12 objects that do not
    qualify as its partner. Then all objects are tried on other drops.

    Args:
        atlas: An atlas from `egad.find_failures`.
        detect: The detector of the search.
        pairs: Maximum number of pairs, 1 to 10; fewer if too few failures have a partner.
        attempts: Attempts of detector and reference each, at each object and in each engine.
        within: Maximum distance of a partner in complexity and in graspability, cells.
        succeeds: How often the detector must hold a partner, 0 to 1; the reference must in 80 %.
        objects: Objects with genomes that may become partners besides those of the atlas; by
            default the released ones.
        jobs: Processes; the result does not depend on them.

    Raises:
        OnlyFailuresError: The detector fails in every attempt at the first three objects.
        UserError: No failure has a partner, a number is out of range, the atlas was not made by a
            search, or objects have other voxels than those of the atlas.
    """
    settings = atlas.searched_with()
    if check_count("pairs", pairs) > MAX_PAIRS:
        raise UserError(f"pairs is {pairs}; allowed: 1 to {MAX_PAIRS}, as labels have one digit")
    check_count("attempts", attempts)
    check_count("within", within)
    if not 0 < succeeds <= 1:
        raise UserError(f"succeeds is {succeeds}; allowed: a rate above 0, at most 1")
    rules = PartnerRules(within, succeeds)
    further = load() if objects is None else objects
    if further.shape != atlas.shape:
        raise UserError(
            "the objects and the atlas have different settings of shapes, which turn voxels into "
            "meshes"
        )
    with workers(jobs) as mapper:
        matching = Matching(atlas, further.archive, rules, attempts, detect, settings, mapper)
        chosen = matching.best(pairs)
        both = [name for pair in chosen for name in pair]
        past = {name: matching.past(name) for name in both}
        work = partial(_try_fresh, count=attempts, detect=detect, settings=settings)
        items = [(matching.rows[name], past[name]) for name in both]
        fresh = list(progress(mapper(work, items), "trying pairs", len(items)))
    tables = dict(zip(both, fresh, strict=True))
    table = _table(chosen, tables, matching, settings)
    made = pd.concat([*matching.attempts, *fresh], ignore_index=True)
    return MatchedSet(table, made, matching.replaced, matching.unmatched, atlas.shape, rules)


def percent(rate: Rate) -> str:
    """A rate, rounded."""
    return f"{100 * rate.value:.0f} %"


def _try_fresh(
    item: tuple[Row, pd.DataFrame], count: int, detect: Detect, settings: FailureParameters
) -> pd.DataFrame:
    """Make the attempts at an object that are not used to choose anything."""
    row, past = item
    with opened(detect, settings.planning_time) as asked:
        examination = Examination(
            scaled_surface(row["voxels"], settings), row["id"], asked, settings
        )
        return examination.paired("matched", count, past)


def _table(
    chosen: Sequence[tuple[str, str]],
    fresh: dict[str, pd.DataFrame],
    matching: Matching,
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
