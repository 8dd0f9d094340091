"""How far two physics engines agree: `python studies/engines/engines.py RESULTS/D GRIPPER`.

Every attempt of the tables `trials/GRIPPER/P.parquet` that came to a grasp is carried out once more
in PyBullet and in MuJoCo, from the same state: the object lies where PyBullet let it come to rest,
and the hand does what the detector proposed. Then the experiment prints, for each detector, how
often both engines give the same outcome and the same success, and the rank correlation of the
success rates of the objects; the outcomes in MuJoCo of the attempts with each outcome in PyBullet;
and, of the attempts that only MuJoCo loses while the fingers close, the outcomes in PyBullet if its
contacts forget where they stuck.
"""

import sys
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr
from typing_extensions import override

from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench import CellErrors, TrialProtocol, TrialRunner, read_attempt
from egad.exchange import model_in, rows_by_id
from egad.grippers import GRIPPERS
from egad.sim import ARMS, FAST_ENGINES, open_world
from egad.sim.pybullet_world import PyBulletWorld
from egad.tables import parquet
from egad.tables.evaluation import TRIALS

PAIR = list(FAST_ENGINES)
ANCHORLESS = "without anchors"


class WithoutAnchors(PyBulletWorld):
    """PyBullet, whose contacts forget where they stuck."""

    @override
    def reset(self) -> None:
        super().reset()
        for body in self.objects:
            self.client.changeDynamics(body, -1, frictionAnchor=0)


def attempts_of(results: Path, gripper: str) -> pd.DataFrame:
    """The attempts of all detectors that came to a grasp."""
    tables = [
        parquet.read(path, TRIALS).assign(detector=path.stem)
        for path in sorted((results / "trials" / gripper).glob("*.parquet"))
    ]
    table = pd.concat(tables, ignore_index=True)
    return table[table["width"].notna()]


def carried_out(rows: tuple[str, pd.DataFrame], results: Path, gripper: str) -> pd.DataFrame:
    """The attempts at an object with their outcomes in both engines, as columns of these names."""
    name, table = rows
    bundle = results / "bundle" / gripper
    model, arm = model_in(bundle, rows_by_id(bundle)[name]), ARMS["axis"](GRIPPERS[gripper])
    tried = [read_attempt(row, CellErrors()) for row in parquet.records(table)]
    with open_world("pybullet", [model], arm.robot) as world:
        runner = TrialRunner(world, arm, TrialProtocol())
        first = [runner.repeat(*each) for each in tried]
    rests = [attempt.rest for attempt in first]
    worlds = {engine: open_world(engine, [model], arm.robot) for engine in PAIR}
    worlds[ANCHORLESS] = WithoutAnchors([model], arm.robot)
    found = {}
    for engine, unopened in worlds.items():
        with unopened as world:
            runner = TrialRunner(world, arm, TrialProtocol())
            found[engine] = [
                runner.carry_out(rest, grasp).outcome if rest and grasp else None
                for rest, (_, grasp, _) in zip(rests, tried, strict=True)
            ]
    return table.assign(**found)


def row(name: str, table: pd.DataFrame) -> str:
    """A row of the table: agreement of the attempts of a detector."""
    first, second = (table[engine] for engine in PAIR)
    held = pd.DataFrame({engine: table[engine] == "success" for engine in PAIR})
    rates = held.groupby(table["label"]).mean()
    shares = [np.mean(first == second), np.mean(held[PAIR[0]] == held[PAIR[1]]), *held.mean()]
    texts = " | ".join(f"{100 * share:.1f} %" for share in shares)
    order = spearmanr(*(rates[engine] for engine in PAIR)).statistic
    return f"| {name} | {len(table)} | {texts} | {order:.3f} |"


def main(results: Path, gripper: str) -> None:
    """Print the tables."""
    table = attempts_of(results, gripper)
    work = partial(carried_out, results=results, gripper=gripper)
    groups = [(str(name), rows) for name, rows in table.groupby("id")]
    with workers(2) as mapper:
        found = pd.concat(list(progress(mapper(work, groups), "carrying out", len(groups))))
    known = found.dropna(subset=PAIR)
    print(f"| detector | attempts | same outcome | same success | {PAIR[0]} | {PAIR[1]} | ranks |")
    print("| --- " * 7 + "|")
    for name, rows in known.groupby("detector"):
        print(row(str(name), rows))
    print(row("all", known))
    print(pd.crosstab(known[PAIR[0]], known[PAIR[1]]).to_markdown())
    lost = known["mujoco"].isin(["missed", "slipped_closing"]) & (known["pybullet"] == "success")
    print(known[lost][ANCHORLESS].value_counts().to_markdown())


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
