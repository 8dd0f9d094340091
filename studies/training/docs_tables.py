"""Figures and tables of README.md: `python docs_tables.py RESULTS [SET]`.

RESULTS is the folder `results/training_study` of the study, or of a part of it. The outcomes of all
attempts there go into training.parquet, and those in clutter into
training_clutter.parquet. The figures and tables cover all attempts in these files; a
learning curve also needs the images of all its sets. The first sets of the pre-registered
comparisons are left out until all networks of these comparisons are tested. If a SET is named, more
tables compare it with each other set.
"""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from network_statistics import (
    Spread,
    check_starts,
    compare_sets,
    difference_interval,
    pooled_spread,
    set_or_detector,
)
from numpy.typing import NDArray
from study import Network, Plan, read_study
from study_charts import Row, success_chart
from study_page import learning_curves, panels, rates_by_test
from study_results import attempts, cleared_tables, images_of, made_by
from study_tables import CLEARED, COMPARED

from egad._util.files import atomic_output, write_text
from egad._util.markdown import table
from egad.errors import UserError
from egad.report.page import p_value
from egad.tables import parquet
from egad.tables.columns import INITIAL

CONFIG = Path(__file__).with_name("study.yaml")
FOLDER = Path(__file__).parent
TESTED = ["test", "training_set", "seed", "detector"]
NETWORK = [*TESTED, "noise"]
COLUMNS = [*NETWORK, "label", "attempt", "initial_pose", "success", "outcome"]
CLEARING = [*TESTED, "scene", "noise", "round", "attempt", "objects", "factors", "n_objects"]
CLEARING += ["success", "outcome"]
ROUNDING = 1e-9  # metres, and of a quaternion
OTHER_DROPS = 0.01  # of the drops of a test
Floats = NDArray[np.float64]


def main(
    results: Path, config: Path = CONFIG, docs: Path = FOLDER, baseline: str | None = None
) -> None:
    """Write tables and figure into docs, and print tables; some compare one set with the others."""
    plan = read_study(config).plan
    detectors = made_by(plan.networks, plan.references)
    made = single_objects(results, detectors)
    for _, rows in made.groupby("test"):
        check_starts(rows)
    earlier = kept(docs / "training.parquet", made)
    check_drops(made, earlier)
    trials = merged(made, earlier, NETWORK)
    keep(trials, docs / "training.parquet")
    found = clutter(results, detectors)
    cleared = merged(found, kept(docs / "training_clutter.parquet", found), TESTED)
    if len(cleared):
        keep(cleared, docs / "training_clutter.parquet")
    ready = all_tested(trials, plan)
    if not ready:
        hidden = [first for first, _ in plan.comparisons]
        trials, cleared = (each[~set_or_detector(each).isin(hidden)] for each in (trials, cleared))
    rates = rates_by_test(trials, cleared)
    order = [*plan.sets, *plan.references]
    rates = {key: in_order(found, order) for key, found in sorted(rates.items())}
    trained = {each.training_set for each in plan.trained}
    shown = panels(rates, trained)
    write_text(docs / "training.svg", success_chart(shown))
    draw_curves(shown, results, plan, docs)
    tables = {"success": shown} | {
        f"in clutter, {measure}": panels(rates, trained, clutter=True, measure=measure)
        for measure in ("success", "cleared")
        if len(cleared)
    }
    for title, tests in tables.items():
        print_success(title, tests)
    if baseline:
        print_differences(baseline, tables)
    if ready:
        print_comparisons(trials, plan)
    for key, each in rates.items():
        print_spread(", ".join(key), each)


def check_drops(made: pd.DataFrame, earlier: pd.DataFrame) -> None:
    """Refuse a part of the study whose drops are not those of the parts before.

    On another kind of processor they differ by rounding, which makes a few come to rest elsewhere.

    Raises:
        UserError: More of them differ; the text has how many of which test.
    """
    drop = ["test", "label", "attempt"]
    starts = [
        rows[rows["initial_pose"] != ""].groupby(drop)["initial_pose"].first()
        for rows in (made, earlier)
    ]
    pairs = pd.concat(starts, axis=1, join="inner", ignore_index=True)
    here, there = (
        np.frombuffer(bytes.fromhex("".join(pairs[part]))).reshape(-1, len(INITIAL))
        for part in pairs
    )
    other = pd.Series(np.abs(here - there).max(axis=1, initial=0) > ROUNDING, pairs.index)
    for test, share in other.groupby("test").mean().items():
        if share > OTHER_DROPS:
            raise UserError(
                f"{share:.0%} of the attempts at {test} start with a different drop than those of "
                "the earlier parts: repeat the trials with the same settings"
            )


def in_order(rates: Mapping[str, Floats], names: Sequence[str]) -> dict[str, Floats]:
    """The known rates of these names, in the order of the names."""
    return {name: rates[name] for name in names if name in rates}


def draw_curves(
    shown: Mapping[str, Mapping[str, Row]], results: Path, plan: Plan, docs: Path
) -> None:
    """Draw the learning curves whose sets are tested in all tests and have their images."""

    def is_ready(name: str) -> bool:
        cards = [results / "images" / each / "card.md" for each in plan.image_sets(name)]
        return all(name in found for found in shown.values()) and all(map(Path.is_file, cards))

    curves = plan.curves
    ready = {kind: own for kind, own in curves.items() if all(map(is_ready, own))}
    names = dict.fromkeys(name for own in ready.values() for name in own)
    images = {name: images_of(results, name, plan) for name in names}
    for kind, chart in learning_curves(shown, images, ready).items():
        write_text(docs / f"training-{kind}.svg", chart)


def all_tested(trials: pd.DataFrame, plan: Plan) -> bool:
    """Whether all networks of the pre-registered comparisons have been in all their tests."""
    compared = {name for pair in plan.comparisons for name in pair}
    wanted = {
        (each.training_set, each.seed, test, noise)
        for each in plan.networks
        if each.training_set in compared
        for test in plan.tests
        for noise in plan.noise
    }
    known = trials[["training_set", "seed", "test", "noise"]].drop_duplicates()
    return wanted <= set(known.itertuples(index=False, name=None))


def single_objects(results: Path, detectors: Mapping[str, Network]) -> pd.DataFrame:
    """The attempts at single objects that these detectors made, columns `COLUMNS`."""
    parts = [
        attempts(path, path.parts[-3], path.parts[-2], detectors[path.stem])
        for path in sorted(results.glob("trials/*/*/*.parquet"))
        if path.stem in detectors
    ]
    return pd.concat([parquet.empty(COMPARED), *parts], ignore_index=True)[COLUMNS]


def clutter(results: Path, detectors: Mapping[str, Network]) -> pd.DataFrame:
    """The attempts in clutter that these detectors made, columns `CLEARING`."""
    parts = [
        cleared_tables(path, path.parts[-2], detectors[path.stem])
        for path in sorted(results.glob("clutter/*/*.parquet"))
        if path.stem in detectors
    ]
    return pd.concat([parquet.empty(CLEARED), *parts], ignore_index=True)[CLEARING]


def kept(path: Path, made: pd.DataFrame) -> pd.DataFrame:
    """The attempts of a table; none, with the columns of `made`, if it is not there."""
    return pd.read_parquet(path) if path.is_file() else made.iloc[:0]


def merged(made: pd.DataFrame, earlier: pd.DataFrame, key: list[str]) -> pd.DataFrame:
    """The attempts of a run and earlier ones, in the order of the key.

    Args:
        made: Attempts of the run. They replace the earlier ones that have the same `key`.
        earlier: With the same columns.
        key: Columns.
    """
    known = pd.MultiIndex.from_frame(earlier[key])
    stays = ~known.isin(pd.MultiIndex.from_frame(made[key]))
    together = pd.concat([earlier[stays], made])
    return together.sort_values(key, kind="stable", ignore_index=True)


def keep(attempts: pd.DataFrame, path: Path) -> None:
    """Write a table of attempts."""
    with atomic_output(path) as out:
        attempts.to_parquet(out, compression="zstd", index=False)


def print_success(head: str, shown: Mapping[str, Mapping[str, Row]]) -> None:
    """Means with intervals over networks, percent; `head` stands above the names."""
    lines = []
    for name in dict.fromkeys(name for panel in shown.values() for name in panel):
        rows = [panel.get(name) for panel in shown.values()]
        count = max((len(row.values) for row in rows if row and row.trained), default="")
        lines.append((f"`{name}`", count, *(text(row) if row else "" for row in rows)))
    print(table([head, "networks", *shown], lines))


def text(row: Row) -> str:
    """A mean with its interval, percent."""
    low, high = row.interval
    between = "" if np.isnan(low) else f" ({100 * low:.0f} to {100 * high:.0f})"
    return f"{100 * row.mean:.0f}{between}"


def print_comparisons(trials: pd.DataFrame, plan: Plan) -> None:
    """The pre-registered comparisons, points."""
    lines = []
    for row in compare_sets(trials, plan.comparisons):
        found = row.difference
        gain = f"{100 * found.gain:.1f} ({points(found.interval)})"
        tests = [p_value(found.p), p_value(row.p_holm), points(row.by_objects)]
        lines.append((f"`{row.first}` - `{row.second}`", f"{row.test}, {row.noise}", gain, *tests))
    print(table(["pair", "test", "over networks", "p", "p, Holm", "over objects"], lines))


def print_differences(baseline: str, tables: Mapping[str, Mapping[str, Mapping[str, Row]]]) -> None:
    """A set minus each other one, with 95 % intervals, points; tables by their title.

    Raises:
        UserError: There is no such set.
    """
    rates = {
        title: [
            {name: row.values for name, row in rows.items() if row.trained}
            for rows in tests.values()
        ]
        for title, tests in tables.items()
    }
    known = dict.fromkeys(name for tests in rates.values() for found in tests for name in found)
    if baseline not in known:
        raise UserError(f"no set {baseline!r} was tested; these were: {', '.join(known)}")
    for title, tests in tables.items():
        spreads = [pooled_spread(found.values()) for found in rates[title]]
        lines = [
            (f"`{name}`", *map(partial(difference_text, baseline, name), rates[title], spreads))
            for name in known
            if name != baseline and any(name in found for found in rates[title])
        ]
        print(table([f"{title}, `{baseline}` minus", *tests], lines))


def difference_text(
    first: str, second: str, rates: Mapping[str, Floats], spread: Spread | None
) -> str:
    """The difference of two sets in a test with its interval, points."""
    if first not in rates or second not in rates:
        return ""
    pair = rates[first], rates[second]
    found = np.mean(pair[0]) - np.mean(pair[1])
    return f"{100 * found:.1f} ({points(difference_interval(*pair, spread))})"


def points(interval: tuple[float, float]) -> str:
    """An interval of differences or standard deviations, points."""
    return " to ".join(f"{100 * end:.1f}" for end in interval)


def print_spread(title: str, rates: Mapping[str, Floats]) -> None:
    """Standard deviations between the networks of each set, and of all sets together, points."""
    each = {name: pooled_spread([values]) for name, values in rates.items()}
    shown = {f"`{name}`": found for name, found in each.items() if found}
    lines = [*shown.items(), ("all", pooled_spread(rates.values()))]
    if shown:
        head = [f"networks on {title}", "standard deviation"]
        print(table(head, [(name, deviation(found)) for name, found in lines]))


def deviation(spread: Spread | None) -> str:
    """A standard deviation with its interval, points."""
    return f"{100 * spread.sd:.1f} ({points(spread.interval)})" if spread else ""


if __name__ == "__main__":
    main(Path(sys.argv[1]), baseline=sys.argv[2] if len(sys.argv) > 2 else None)
