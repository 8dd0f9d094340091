"""What networks know of labelled grasps in the study of failures as training data.

`curriculum_scores.py FOLDER NETWORKS`: FOLDER is a complete one of `curriculum.py`, and NETWORKS
has the networks that were trained further there. The first table has, for the further scenes of
each kind, the share of grasps that succeeded, and how many turns of the hand hold there. The second
one has, for networks of each kind at some of these scenes, the average precision and the error of
the rotation. This was not planned.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from curriculum import GRIPPER, networks_after, networks_before
from curriculum_tables import ALONE, BEFORE, KINDS

from egad._util.markdown import table as markdown
from egad.detectors.weights import read_vgn
from egad.grippers import GRIPPERS
from egad.learning.scene_examples import SceneExample, labelled_grasps, scene_example
from egad.learning.scene_scores import SceneScore, scene_score
from egad.learning.scene_training import answers_at, read_answers
from egad.learning.scenes import LabelledScene, SceneDataset, load_scenes
from egad.learning.training import spread

SCENES = 100  # of each kind, for the second table


def main(folder: Path, networks: Path) -> None:
    """Print the tables."""
    further = {kind: load_scenes(folder / "scenes" / kind) for kind in KINDS}
    turns = [(kind, *turns_that_hold(grasps_of(scenes))) for kind, scenes in further.items()]
    print(markdown(["scenes of", "successful grasps, %", "turns that hold"], turns))
    examples = {
        kind: [
            example_of(scenes.scene(number)) for number in spread(np.arange(len(scenes)), SCENES)
        ]
        for kind, scenes in further.items()
    }
    tried = {BEFORE: networks_before(networks)}
    tried |= {kind: networks_after(folder, kind) for kind in (*KINDS, ALONE)}
    rows = [
        (kind, *(text for each in examples.values() for text in scores(weights, each)))
        for kind, weights in tried.items()
        if weights[0].exists()
    ]
    titles = [f"{kind}: {what}" for kind in examples for what in ("precision", "degrees")]
    print(markdown(["networks", *titles], rows))


def grasps_of(scenes: SceneDataset) -> list[pd.DataFrame]:
    """The labelled grasps of each scene."""
    return [scenes.scene(number).grasps for number in range(len(scenes))]


def turns_that_hold(grasps: Sequence[pd.DataFrame]) -> tuple[str, str]:
    """The percentage of grasps that succeeded, and how many turns of the hand hold there."""
    holds = np.array([turns for each in grasps for turns in each["yaws"]])
    held = holds[holds.any(axis=1)]
    return (
        f"{100 * len(held) / len(holds):.1f}",
        f"{held.sum(axis=1).mean():.2f} of {held.shape[1]}",
    )


def example_of(scene: LabelledScene) -> SceneExample:
    """A scene as networks are shown it."""
    return scene_example(scene.observation().tsdf, labelled_grasps(scene, GRIPPERS[GRIPPER]))


def scores(weights: Sequence[Path], examples: Sequence[SceneExample]) -> tuple[str, str]:
    """Means over networks of the average precision and of the error of the rotation, degrees."""
    found = [score_of(each, examples) for each in weights]
    precision = np.mean([each.average_precision.value for each in found])
    return f"{precision:.2f}", f"{np.mean([each.angle.value for each in found]):.0f}"


def score_of(weights: Path, examples: Sequence[SceneExample]) -> SceneScore:
    """What a network answers to scenes, compared with their labels."""
    network = read_vgn(weights).eval()
    with torch.inference_mode():
        found = [answers_at(network, each).double().numpy() for each in examples]
    none = [np.zeros((len(each), 3)) for each in found]  # losses
    answers = map(read_answers, found, none, examples)
    return scene_score(list(answers))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
