"""Lift objects with labelled grasps in ManiSkill, and report how often that works.

python examples/maniskill/evaluate.py build/maniskill --episodes 4
"""

import argparse
from pathlib import Path

import gymnasium as gym
import pandas as pd
import pick_single_egad  # noqa: F401 (registers the task)
from mani_skill.utils.wrappers import RecordEpisode
from policy import LiftPolicy
from prepare import GRASPS

import egad
from egad.bench.stats import by_object, mean_rate


def attempt(env: gym.Env, grasps: egad.Grasps, label: str, seed: int) -> dict:
    """One episode with an object; the seed is of its initial pose and the goal."""
    env.reset(seed=seed, options={"label": label})
    outcome = LiftPolicy(env, grasps.of(label)).run()
    steps = int(env.unwrapped.elapsed_steps[0])
    row = {"label": label, "seed": seed, "outcome": outcome, "success": outcome == "success"}
    return row | {"steps": steps}


def report(trials: pd.DataFrame) -> str:
    """The success rate with its interval, the outcomes, and the objects that often fail."""
    mean, objects = mean_rate(trials), by_object(trials)
    low, high = mean.interval
    outcomes = trials["outcome"].value_counts().items()
    worst = objects[objects["successes"] <= objects["attempts"] / 2]
    return "\n".join(
        [
            f"{mean.successes} of {mean.attempts} episodes with {len(objects)} objects succeeded: "
            f"{mean.value:.1%}, 95 % interval {low:.1%} to {high:.1%}",
            f"objects lifted at least once: {(objects['successes'] > 0).sum()} of {len(objects)}",
            "outcomes: " + ", ".join(f"{n} {o}" for o, n in outcomes),
            "half of the episodes or more failed: "
            + (", ".join(f"{o} {s}/{n}" for o, s, n in worst.itertuples()) or "none"),
        ]
    )


def main() -> None:
    """Read the arguments, run all episodes and print the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("objects", type=Path, help="folder from prepare.py")
    parser.add_argument("--labels", nargs="+", help="objects (default: all)")
    parser.add_argument("--episodes", type=int, default=4, help="episodes with each object")
    parser.add_argument("--seed", type=int, default=0, help="of the first episode")
    parser.add_argument("--out", type=Path, help="CSV file with one row per episode")
    parser.add_argument("--films", type=Path, help="folder for an MP4 file of each episode")
    parser.add_argument("--render-backend", default="none", help="as in ManiSkill; gpu for films")
    arguments = parser.parse_args()
    env = gym.make(
        "PickSingleEGAD-v1",
        objects=arguments.objects,
        obs_mode="state",
        control_mode="pd_joint_pos",
        sim_backend="physx_cpu",
        render_backend=arguments.render_backend,
        render_mode="rgb_array" if arguments.films else None,
        reconfiguration_freq=0,
    )
    if arguments.films:
        env = RecordEpisode(env, str(arguments.films), save_trajectory=False, video_fps=20)
    grasps = egad.Grasps(pd.read_parquet(arguments.objects / GRASPS))
    rows = []
    for label in arguments.labels or env.unwrapped.labels:
        for seed in range(arguments.seed, arguments.seed + arguments.episodes):
            rows.append(attempt(env, grasps, label, seed))
            print(label, seed, rows[-1]["outcome"], flush=True)
    env.close()
    trials = pd.DataFrame(rows)
    if arguments.out:
        trials.to_csv(arguments.out, index=False)
    print(report(trials))


if __name__ == "__main__":
    main()
