"""How often the check of a table refuses honest ones, and finds forged ones.

    python studies/verification/checks.py mujoco pybullet --honest 25 --forged 100

Each attempt begins with a drop of its own, so a forged row leaves no trace in the next one. Honest
tables of other processors are those of nudged objects: with the kernels of BLAS and NumPy that one
machine can run, all bits are the same (tests/bench/test_same_bits.py). An honest table has two
attempts at each object; ten are joined before some rows are forged.
"""

import argparse
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pandas as pd
from scipy.stats import binomtest

import egad
from egad.bench import (
    NAMED_ERRORS,
    Reproduction,
    TrialParameters,
    TrialProtocol,
    TrialRunner,
    columns_of,
    judge,
    nudged,
    read_attempt,
    run_attempts,
)
from egad.bench.reproduction import MEASURED, NUDGES
from egad.detectors import QUICK
from egad.exchange import evaluation_set_models
from egad.random import generator
from egad.sim import ARMS, EngineName, Model, open_world
from egad.tables import parquet

DETECTORS = ("antipodal-depth", "random")
SHARES = (0.01, 0.03, 0.1)
ATTEMPTS = 2
JOINED = 10  # honest tables that are joined before some of their rows are forged
ENDS = [name for name in MEASURED if name != "stopped"]


def settings_of(engine: EngineName) -> TrialParameters:
    """Attempts as on the leaderboard, but each with a drop of its own."""
    trials = TrialProtocol(
        attempts=ATTEMPTS,
        engine=engine,
        depth_noise=0.1,
        errors=NAMED_ERRORS["typical"],
        reset="redrop",
    )
    return TrialParameters(seed=0, gripper=egad.gripper("egad_75mm"), trials=trials)


def repeated(rows: pd.DataFrame, model: Model, settings: TrialParameters) -> pd.DataFrame:
    """The attempts of a table at an object, simulated again from their initial poses."""
    arm = ARMS[settings.trials.arm](settings.gripper)
    found = []
    with open_world(settings.trials.engine, [model], arm.robot) as world:
        runner = TrialRunner(world, arm, settings.trials)
        for row in parquet.records(rows):
            known = read_attempt(row, settings.trials.errors)
            again = columns_of(runner.repeat(*known))
            found.append(again | {"outcome": again["outcome"] or row["outcome"]})
    return pd.DataFrame(found, index=rows.index)


class Table:
    """An honest table, its attempts again, and those of nudged objects."""

    def __init__(self, engine: EngineName, detector: str, labels: list[str]) -> None:
        """Simulate all of it."""
        self.settings = settings_of(engine)
        self.models = evaluation_set_models(self.settings.gripper, "paper")
        known = egad.load("evaluation-set").table
        known = known[known["label"].isin(labels)] if labels else known
        self.rows = pd.concat(
            [
                run_attempts(self.models[name], label, name, QUICK[detector], self.settings)
                for label, name in zip(known["label"], known["id"], strict=True)
            ],
            ignore_index=True,
        )
        self.rows = self.rows[self.rows["initial_pose"] != ""].reset_index(drop=True)
        self.found = self.with_nudge(0.0)
        self.nudged = {by: self.with_nudge(by) for by in NUDGES}

    def with_nudge(self, by: float) -> pd.DataFrame:
        """All attempts, with the inertia of the objects changed by a fraction."""
        groups = self.rows.groupby("id", sort=False)
        return pd.concat(
            repeated(rows, nudged(self.models[str(name)], by), self.settings)
            for name, rows in groups
        ).sort_index()

    def verdict(self, said: pd.DataFrame) -> Reproduction:
        """What the check says of a table of the same attempts."""
        places = [f"attempt {number}" for number in range(len(said))]
        return judge(said, self.found, places, lambda by, rows: self.nudged[by].iloc[rows])

    def honest(self, count: int) -> Iterator[pd.DataFrame]:
        """Tables as other processors might make them."""
        for number in range(count):
            yield self.with_nudge(-1e-13 * (number + 0.5))

    def turned(
        self, honest: pd.DataFrame, share: float, rng: np.random.Generator, *, ends: bool
    ) -> pd.DataFrame:
        """An honest table with failures said to be successes, perhaps with the end of a success."""
        said = honest.copy()
        failures = np.flatnonzero(~said["success"] & said["width"].notna())
        successes = np.flatnonzero(said["success"])
        count = min(max(round(share * len(said)), 1), len(failures))
        for row in rng.choice(failures, count, replace=False):
            said.loc[row, ["success", "outcome"]] = True, "success"
            if ends:
                said.loc[row, ENDS] = said.loc[rng.choice(successes), ENDS]
        return said

    def forged(
        self, honest: list[pd.DataFrame], share: float, rng: np.random.Generator, *, ends: bool
    ) -> Reproduction:
        """The verdict on honest tables that were joined, with a share of the rows turned."""
        chosen = rng.choice(len(honest), JOINED)
        turned = (self.turned(honest[each], share, rng, ends=ends) for each in chosen)
        return sum(map(self.verdict, turned), start=Reproduction())


def line(name: str, refused: int, count: int) -> str:
    """A row of the page."""
    low, high = binomtest(refused, count).proportion_ci(method="wilson")
    return f"| {name} | {refused} of {count} | {low:.0%} to {high:.0%} |"


def main() -> None:
    """Print the tables of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("engines", nargs="+", choices=("mujoco", "pybullet", "drake"))
    parser.add_argument("--honest", type=int, default=25)
    parser.add_argument("--forged", type=int, default=100)
    parser.add_argument("--labels", nargs="*", default=[])
    parser.add_argument("--detectors", nargs="*", default=DETECTORS)
    given = parser.parse_args()
    for engine in given.engines:
        for detector in given.detectors:
            table = Table(engine, detector, given.labels)
            print(f"\n{engine}, {detector}: {len(table.rows)} attempts", flush=True)
            honest = list(table.honest(given.honest))
            verdicts = [table.verdict(each) for each in honest]
            total = sum(verdicts, start=Reproduction())
            print(total, flush=True)
            refused = Counter(each.is_honest for each in verdicts)[False]
            print(line("honest", refused, given.honest), flush=True)
            rng = generator(0, "joined", engine, detector)
            chosen = [rng.choice(given.honest, JOINED) for _ in range(given.forged)]
            joined = [sum((verdicts[each] for each in some), Reproduction()) for some in chosen]
            refused = sum(not each.is_honest for each in joined)
            print(line(f"{JOINED} honest ones, joined", refused, given.forged), flush=True)
            for ends in (False, True):
                for share in SHARES:
                    rng = generator(0, "forged", engine, detector, str(share), str(ends))
                    forged = [
                        table.forged(honest, share, rng, ends=ends) for _ in range(given.forged)
                    ]
                    refused = sum(not each.is_honest for each in forged)
                    how = "with the end of a success" if ends else "outcome alone"
                    print(line(f"{share:.0%} turned, {how}", refused, given.forged), flush=True)


if __name__ == "__main__":
    main()
