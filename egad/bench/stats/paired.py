"""Compare two detectors that tried the same objects: is one better, or is the difference noise?"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import scipy  # scipy.stats is loaded when it is used
from numpy.typing import NDArray

from egad._util.arrays import Ints
from egad._util.display import facts_html
from egad.bench.stats.rates import Interval, Rate, bootstrap, by_object
from egad.errors import UserError

ENOUGH_OBJECTS = 6  # fewer cannot differ significantly: 2 / 2^5 = 0.06
MAX_EXACT = 400  # attempts of a detector: Boschloo's test takes 1 s; with 1000 it takes 17 s


class NothingInCommonError(UserError):
    """Two detectors made no attempt that can be compared."""


@dataclass(frozen=True, repr=False)
class Comparison:
    """The first of two detectors against the second, over the attempts that both made.

    Attributes:
        objects: Objects that both tried.
        attempts: Attempts that both made.
        difference: Success rate of the first minus that of the second.
        interval: 95 % confidence interval of the difference, by resampling objects.
        p_objects: Sign-flip test over the objects; see `sign_flip`.
        alike: Attempts that had the same initial pose for both detectors.
        only_first: Alike attempts in which only the first succeeded.
        only_second: Alike attempts in which only the second succeeded.
        p_attempts: Exact McNemar test over the alike attempts; NaN if there are none.
        p_rates: Boschloo's exact test of the numbers of successes, for cases where the other two
            say nothing: fewer than 6 objects, and no alike attempts. NaN otherwise, and for more
            than 400 attempts. It treats attempts as independent, so it holds for these objects
            only.
    """

    objects: int
    attempts: int
    difference: float
    interval: Interval
    p_objects: float
    alike: int
    only_first: int
    only_second: int
    p_attempts: float
    p_rates: float

    def __repr__(self) -> str:
        """The difference and its interval in percentage points, and the tests."""
        facts = self._facts()
        of = f"{self.attempts} attempts at {self.objects} objects"
        tests = "; ".join(f"{name}: {facts[name]}" for name in list(facts)[1:])
        return f"Comparison({facts['difference']}, {of}; {tests})"

    def _repr_html_(self) -> str:
        """The same as a table, for notebooks."""
        counts = {"objects": self.objects, "attempts": self.attempts}
        return facts_html("Comparison: first minus second", self._facts() | counts)

    def _facts(self) -> dict[str, object]:
        value, low, high = (100 * each for each in (self.difference, *self.interval))
        between = "no interval" if np.isnan(low) else f"95 % interval {low:+.1f} to {high:+.1f}"
        facts: dict[str, object] = {
            "difference": f"{value:+.1f} percentage points ({between})",
            "test over the objects": f"p = {self.p_objects:.3g}",
        }
        if self.alike:
            facts["test over the attempts with the same initial pose"] = (
                f"p = {self.p_attempts:.3g}, of {self.alike} only the first succeeded in "
                f"{self.only_first}, only the second in {self.only_second}"
            )
        if not np.isnan(self.p_rates):
            facts["test over the attempts at these objects"] = f"p = {self.p_rates:.3g}"
        return facts


def compare(first: pd.DataFrame, second: pd.DataFrame) -> Comparison:
    """Compare two detectors on the same attempts.

    Prefer the test over the objects. Attempts at one object resemble each other: a detector that is
    better at a shape is better in all 20 attempts at it. McNemar's test treats attempts as
    independent, so its result holds for these objects only.

    If attempts start where the previous one ended, two detectors face the same state in only some
    attempts; McNemar's test uses these. On a real robot these are never known, and a few objects
    cannot differ significantly; then Boschloo's test compares the numbers of successes.

    Args:
        first: Columns label, id, attempt, success and initial_pose; id and initial_pose are empty
            where objects are known by their label only and drops cannot be repeated.
        second: The same for the other detector.

    Raises:
        NothingInCommonError: They have no attempt in common.
        UserError: A label stands for one object in the first table and for another in the second.
    """
    pairs = match_attempts(first, second)
    one, other = (pairs[f"success_{i}"].to_numpy(dtype=np.int64) for i in (1, 2))
    objects = by_object(pairs.assign(success=one - other))
    gains, counts = objects["successes"].to_numpy(), objects["attempts"].to_numpy()
    alike = np.logical_and.reduce([_same(pairs, key) for key in ("id", "initial_pose")])
    only_rates = len(objects) < ENOUGH_OBJECTS and not alike.any() and len(pairs) <= MAX_EXACT
    rates = (Rate(int(each.sum()), len(each)) for each in (one, other))
    only_first, only_second = (int((alike & each).sum()) for each in (one > other, other > one))
    return Comparison(
        objects=len(objects),
        attempts=len(pairs),
        difference=float((one - other).mean()),
        interval=bootstrap(lambda drawn: gains[drawn].sum(1) / counts[drawn].sum(1), len(objects)),
        p_objects=sign_flip(gains),
        alike=int(alike.sum()),
        only_first=only_first,
        only_second=only_second,
        p_attempts=mcnemar(only_first, only_second) if alike.any() else float("nan"),
        p_rates=boschloo(*rates) if only_rates else float("nan"),
    )


def match_attempts(first: pd.DataFrame, second: pd.DataFrame) -> pd.DataFrame:
    """Attempts that both made, columns with _1 and _2, as pairs became complete."""
    one, other = (table.assign(place=np.arange(len(table))) for table in (first, second))
    pairs = one.merge(other, on=["label", "attempt"], suffixes=("_1", "_2"))
    if pairs.empty:
        raise NothingInCommonError(
            "the two tables have no attempt in common: same labels and numbers"
        )
    _check_objects(pairs)
    complete = np.maximum(pairs["place_1"], pairs["place_2"]).argsort(kind="stable")
    return pairs.iloc[complete].drop(columns=["place_1", "place_2"])


def _same(pairs: pd.DataFrame, key: str) -> NDArray[np.bool_]:
    """Where both tables have a value and agree on it."""
    one, other = (pairs[f"{key}_{i}"].to_numpy(dtype=str) for i in (1, 2))
    same: NDArray[np.bool_] = (one != "") & (one == other)
    return same


def _check_objects(pairs: pd.DataFrame) -> None:
    one, other = pairs["id_1"], pairs["id_2"]
    differ = pairs[(one != "") & (other != "") & (one != other)]
    if len(differ):
        label, first, second = differ.iloc[0][["label", "id_1", "id_2"]]
        raise UserError(
            f"{label} is the object {first} in one table and {second} in the other: "
            "only trials of the same evaluation set can be compared"
        )


def sign_flip(gains: Ints) -> float:
    """P-value of the exact two-sided permutation test that gains by object, (n,), prefer no sign.

    If neither detector is better, each object could just as well have favored the other one by the
    same amount. The p-value is the fraction of all 2^n ways to choose the signs whose sum is at
    least as far from 0. It is computed by adding one object after the other to the distribution of
    the sum.
    """
    sizes = np.abs(gains)
    reach = int(sizes.sum())
    chance = np.zeros(2 * reach + 1)
    chance[reach] = 1.0  # index = sum + reach
    for size in sizes[sizes > 0]:
        chance = (np.roll(chance, size) + np.roll(chance, -size)) / 2  # what wraps around is 0
    sums = np.arange(-reach, reach + 1)
    return float(min(chance[np.abs(sums) >= abs(gains.sum())].sum(), 1.0))


def mcnemar(only_first: int, only_second: int) -> float:
    """P-value of McNemar's exact two-sided test: attempts that only one won favor neither."""
    differing = only_first + only_second
    return float(scipy.stats.binomtest(only_first, differing).pvalue) if differing else 1.0


def boschloo(first: Rate, second: Rate) -> float:
    """P-value of the exact two-sided test that two success rates are equal, for unpaired attempts.

    Boschloo's test is never weaker than Fisher's, since it does not fix the total number of
    successes; nor does a robot. Attempts must be independent, and their number fixed before the
    first one. It is 1 if either detector has no attempts.
    """
    if not first.attempts or not second.attempts:
        return 1.0
    rates = (first, second)
    table = [[each.successes for each in rates], [e.attempts - e.successes for e in rates]]
    return float(min(scipy.stats.boschloo_exact(table).pvalue, 1.0))
