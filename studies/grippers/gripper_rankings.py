"""Whether objects that are hard for one gripper are hard for others.

    python studies/grippers/gripper_rankings.py yumi robotiq_2f_85=HAND.urdf panda=HAND.urdf ...

The 49 objects of the released evaluation set are scaled to each gripper: one that egad knows by
name, or the file of one. Two tables are printed: the rank correlation of graspability between
grippers; and of graspability if grasps that the hand cannot reach count as zeros. The second row
repeats the first gripper with other grasps: no higher correlation can be measured.
"""

import argparse

import numpy as np
import pandas as pd

import egad
from egad._util.progress import progress
from egad.geometry import RayCaster, center_of_mass
from egad.grasps import ferrari_canny, label_parameters, sample_for_labels
from egad.grasps.approach import best_approaches
from egad.grippers import Gripper, body_of
from egad.random import generator

GRASPS, PERCENTILE = 200, 75.0


def graspability(target: egad.EvolvedObject, gripper: Gripper, seed: int) -> tuple[float, float]:
    """The percentile of the quality of grasps, and of those that the hand reaches."""
    mesh, _ = egad.rescale(target.mesh, gripper)
    caster, settings = RayCaster(mesh), label_parameters(gripper, GRASPS, seed)
    rng = generator(seed, "gripper-rankings", target.id)
    grasps, _ = sample_for_labels(caster, settings, rng)
    contacts = grasps.points, grasps.normals, grasps.axes
    quality = ferrari_canny(*contacts, center_of_mass(mesh), **settings.quality.model_dump())
    reached = best_approaches(caster, grasps, body_of(gripper)).free
    alone, held = np.percentile([quality, quality * reached], PERCENTILE, axis=1)
    return float(alone), float(held)


def compare(hands: dict[str, tuple[Gripper, int]]) -> None:
    """Print how alike the rankings are."""
    objects = egad.load("evaluation-set")
    rows = [
        {name: graspability(each, *hand) for name, hand in hands.items()}
        for each in progress(objects, "sampling grasps", len(objects))
    ]
    for number, title in enumerate(("without the hand", "with the hand")):
        table = pd.DataFrame([{name: found[number] for name, found in row.items()} for row in rows])
        print(f"\n{title}\n{table.corr('spearman').round(2).to_markdown()}", flush=True)
        print(table.apply(lambda column: (column == 0).sum()).to_dict(), "objects with 0")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("hands", nargs="+", metavar="NAME or NAME=FILE")
    known: dict[str, tuple[Gripper, int]] = {}
    for given in parser.parse_args().hands:
        name, _, file = given.partition("=")
        known[name] = (Gripper.from_file(file) if file else egad.gripper(name), 0)
        if len(known) == 1:
            known[f"{name}, again"] = (known[name][0], 1)
    compare(known)
