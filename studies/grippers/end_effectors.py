"""Jaws, a suction cup and one swinging jaw on the same 49 objects.

    python studies/grippers/end_effectors.py panda cup_30mm so101 [--attempts 10] [--jobs 2]

The objects of the released evaluation set are scaled to each hand. The first table has how many
labelled grasps of an object (of at most 100) have a quality and are free of collision, the objects
without any such grasp, and the success of the detector `labels` in simulated trials in both
engines, with 95 % intervals for other objects. The second one has rank correlations of graspability
(Spearman) between the hands; a hand with other random numbers shows how far it can be known.
"""

import argparse
import warnings

import numpy as np
from cup_rankings import correlation

import egad
from egad._util.arrays import Floats
from egad.sim import EngineName

GRASPS, CANDIDATES = 100, 4096
ENGINES: tuple[EngineName, ...] = ("mujoco", "pybullet")


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("hands", nargs="+")
    parser.add_argument("--attempts", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    objects = egad.load("evaluation-set")
    heads = ["hand", "good grasps", "objects without", *(f"success, {each}" for each in ENGINES)]
    print(f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}")
    for name in given.hands:
        cells = labels_row(objects, name)
        cells += [success(objects, name, engine, given.attempts, given.jobs) for engine in ENGINES]
        print(f"| `{name}` | {' | '.join(cells)} |", flush=True)
    print()
    print_ranks(objects, given.hands)


def labels_row(objects: egad.Dataset, name: str) -> list[str]:
    """The percentage of labelled grasps that are good, and how many objects have none."""
    shares = []
    for each in objects:
        mesh, _ = egad.rescale(each.mesh, name)
        try:
            grasps = egad.sample_grasps(mesh, name, GRASPS)
        except egad.RejectedError:
            shares.append(0.0)
            continue
        shares.append(float(np.mean((grasps.quality > 0) & grasps.collision_free)))
    found = np.array(shares)
    return [f"{100 * found.mean():.0f} %", str(int(np.sum(found == 0)))]


def success(objects: egad.Dataset, name: str, engine: EngineName, attempts: int, jobs: int) -> str:
    """The success of the detector `labels`, percent, with its interval."""
    made = egad.run_trials("labels", objects, name, engine=engine, attempts=attempts, jobs=jobs)
    rate = made.success_rate()
    return f"{100 * rate.value:.0f} ({100 * rate.ci_low:.0f} to {100 * rate.ci_high:.0f})"


def print_ranks(objects: egad.Dataset, hands: list[str]) -> None:
    """Print the rank correlations of graspability between hands."""
    values = {name: graspabilities(objects, name, 0) for name in hands}
    values[f"{hands[0]}, again"] = graspabilities(objects, hands[0], 1)
    print(f"| | {' | '.join(values)} |\n|{' --- |' * (len(values) + 1)}")
    for name, mine in values.items():
        cells = [
            "" if name == other else correlation(mine, theirs) for other, theirs in values.items()
        ]
        print(f"| `{name}` | {' | '.join(cells)} |")
    print({name: int(np.sum(found == 0)) for name, found in values.items()}, "have graspability 0")


def graspabilities(objects: egad.Dataset, name: str, seed: int) -> Floats:
    """The graspability of each object at the size for a hand; 0 without a grasp."""
    found = []
    for each in objects:
        try:
            measured = egad.measure(each.mesh, name, max_candidates=CANDIDATES, seed=seed)
            found.append(measured.graspability)
        except egad.RejectedError:
            found.append(0.0)
    return np.array(found)


if __name__ == "__main__":
    main()
