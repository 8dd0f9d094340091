"""The tables of the study of failures as training data: see `curriculum.py`."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import scipy.stats
from failures import unlike
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad._util.markdown import table as markdown
from egad.bench.failures import FailureAtlas, ObjectVerdict
from egad.random import generator

NETWORKS = 3
KINDS = ("failures", "random", "hard")  # of further objects
BEFORE = "before"  # a network before further training
ALONE = "alone"  # one that was trained further on failures alone, by `curriculum_alone.py`
RETRIED = "trained-on"  # the folder of tests at the failures that were trained on
SEARCHES = ("learnt", "held-out", "failures", "random")
TABLE, ATLAS, SPENT, DONE = "table.parquet", "atlas", "cpu.txt", "done"
SEARCHED_AGAIN = 3000  # grasps of each second search
DRAWS = 10_000


def show(folder: Path) -> None:
    """Print the tables of the results so far."""
    tests = {
        "held-out failures unlike training objects": ("held-out", by_new_failure),
        "all held-out failures": ("held-out", by_failure),
        "failures that were trained on": (RETRIED, by_failure),
        "piles of egad": ("cleared-egad", by_round),
        "piles of ycb": ("cleared-ycb", by_round),
    }
    for title, (name, counts) in tests.items():
        found = {
            kind: each
            for kind in (BEFORE, *KINDS, ALONE)
            if len(each := tested(folder / name, kind, counts)) == NETWORKS
        }
        others = [kind for kind in (BEFORE, "random", "hard") if kind in found]
        rows = [
            (kind, percent(each), *(_versus(found, kind, other) for other in others))
            for kind, each in found.items()
        ]
        if rows:
            print(f"\n{title}\n")
            print(markdown(["network", "%", *(f"minus {other}" for other in others)], rows))
    print(f"\nsearches, and the first {SEARCHED_AGAIN} grasps of each\n")
    searched = [
        (name, *yields([path.with_name(ATLAS) for path in paths]))
        for name in SEARCHES
        if (paths := sorted((folder / "searches").glob(f"{name}-*/{DONE}")))
    ]
    titles = ["failures", "different", "grasps", "per 1000"]
    print(
        markdown(["search", "networks", *titles, *(f"first {each}" for each in titles)], searched)
    )
    spent = sum(float(path.read_text()) for path in folder.rglob(SPENT))
    print(f"{spent / 3600:.1f} CPU hours")


def tested(
    folder: Path, kind: str, counts: Callable[[pd.DataFrame], pd.DataFrame]
) -> list[pd.DataFrame]:
    """The counts of each network of a kind that was tested, unless there is nothing to count."""
    tables = [counts(pd.read_parquet(path)) for path in sorted(folder.glob(f"{kind}-*/{TABLE}"))]
    return [table for table in tables if len(table)]


def by_failure(rows: pd.DataFrame) -> pd.DataFrame:
    """Attempts and successes at each held-out failure: `n` and `won`, by object and engine."""
    return rows.set_index(["id", "engine"])[["n", "detector"]].set_axis(["n", "won"], axis=1)


def by_new_failure(rows: pd.DataFrame) -> pd.DataFrame:
    """As `by_failure`, of those without a similar training object."""
    return by_failure(rows[rows["is_new"]])


def by_round(rows: pd.DataFrame) -> pd.DataFrame:
    """Number of objects, and of cleared ones: `n` and `won`, by round."""
    return rows.groupby("round").agg(n=("n_objects", "first"), won=("success", "sum"))


def share(counts: pd.DataFrame) -> float:
    """Fraction of successes, over all rows."""
    return float(counts["won"].sum() / counts["n"].sum())


def percent(networks: Sequence[pd.DataFrame]) -> str:
    """A mean over networks, and each of them."""
    values = [100 * share(each) for each in networks]
    return f"{np.mean(values):.1f} ({', '.join(f'{each:.0f}' for each in values)})"


def _versus(found: Mapping[str, Sequence[pd.DataFrame]], kind: str, other: str) -> str:
    return "" if kind == other else versus(found[kind], found[other])


def versus(networks: Sequence[pd.DataFrame], others: Sequence[pd.DataFrame]) -> str:
    """A mean difference in points, with two intervals of 95 % and a p value.

    The first interval and the p value are those of a paired t test over networks; the second
    interval is for other objects or rounds, by bootstrap.
    """
    first, second = (np.array([share(each) for each in some]) for some in (networks, others))
    test = scipy.stats.ttest_rel(first, second)
    low, high = test.confidence_interval()
    gain = 100 * (first - second).mean()
    least, most = resampled(networks, others)
    return (
        f"{gain:.1f} ({100 * low:.1f} to {100 * high:.1f}), p = {test.pvalue:.3f}; "
        f"others: {100 * least:.1f} to {100 * most:.1f}"
    )


def resampled(
    networks: Sequence[pd.DataFrame], others: Sequence[pd.DataFrame]
) -> tuple[float, float]:
    """The interval of a mean difference, from resampling objects or rounds with replacement."""
    first, second = (
        [each.groupby(level=0, sort=True).sum() for each in some] for some in (networks, others)
    )
    drawn = generator(0, "bootstrap").integers(len(first[0]), size=(DRAWS, len(first[0])))
    values = np.mean([_drawn_shares(each, drawn) for each in first], axis=0)
    values -= np.mean([_drawn_shares(each, drawn) for each in second], axis=0)
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


def _drawn_shares(counts: pd.DataFrame, drawn: NDArray[np.int64]) -> Floats:
    """The fraction of successes in each sample of rows."""
    n, won = (counts[name].to_numpy(np.float64)[drawn].sum(axis=1) for name in ("n", "won"))
    shares: Floats = won / n
    return shares


def yields(atlases: Sequence[Path]) -> tuple[int | str, ...]:
    """Counts of complete searches, in all and in the first grasps of each."""
    examined = [FailureAtlas.load(path).examined for path in atlases]
    first = [
        each[each["attempts"].cumsum() - each["attempts"] < SEARCHED_AGAIN] for each in examined
    ]
    return len(atlases), *counted(examined), *counted(first)


def counted(searches: Sequence[pd.DataFrame]) -> tuple[str, int, int, str]:
    """Failures, in all and by search, how many are different, grasps, and failures per 1000."""
    found = [each["voxels"][each["verdict"] == ObjectVerdict.FAILURE] for each in searches]
    failures, by_search = sum(map(len, found)), ", ".join(str(len(each)) for each in found)
    grasps = sum(int(each["attempts"].sum()) for each in searches)
    rate = f"{1000 * failures / grasps:.1f}"
    return f"{failures} ({by_search})", len(unlike(pd.concat(found))), grasps, rate
