"""Does it help VGN to check its hand against what is seen? `python avoid_collisions.py RUN`.

RUN is the folder in which the study ran. VGN with its published weights and the first network of
`tuned-evolved` clear 40 piles of evolved objects from the scenes' split `test`, which are in no
test of the study: as they are, with `avoid_collisions`, and without the grasps that collide.
"""

import sys
from pathlib import Path

import numpy as np

import egad
from egad.detectors import Detect, DetectorConfig, GraspPoses, Observation, Vgn, in_collision
from egad.grippers import Gripper
from egad.learning.scenes import load_scenes

OBJECTS, ROUNDS, SEED, THRESHOLD = 60, 40, 11, 0.1
NETWORKS = {
    "vgn-low": "weights/vgn_conv.pth",
    "tuned-evolved-0": "results/scene_study/networks/tuned-evolved/0/weights.safetensors",
}


class WithoutCollisions:
    """VGN without the grasps that collide."""

    def __init__(self, weights: str) -> None:
        """Load its weights."""
        self._vgn = Vgn(weights, THRESHOLD)

    def __call__(
        self, observation: Observation, gripper: Gripper, rng: np.random.Generator
    ) -> GraspPoses:
        """The grasps that are left."""
        found = self._vgn(observation.tsdf, gripper, rng)
        free = ~in_collision(found.poses, found.widths, observation.cloud.points, gripper)
        return GraspPoses(*(values[free] for values in found))


def main(run: Path) -> None:
    """Print what each clears, and the outcomes of its attempts."""
    index = load_scenes(run / "results/egad/scenes/panda").index
    names = sorted(set(index.loc[index["split"] == "test", "objects"].explode()))[:OBJECTS]
    objects = egad.load("released").select(names)
    for network, path in NETWORKS.items():
        weights = str(run / path)
        variants: dict[str, Detect] = {
            ("avoiding" if avoid else "as it is"): DetectorConfig(
                detector="vgn", weights=weights, threshold=THRESHOLD, avoid_collisions=avoid
            )
            for avoid in (False, True)
        }
        for name, detect in (variants | {"without": WithoutCollisions(weights)}).items():
            found = egad.run_benchmark(
                detect, objects, scenes=["pile"], noise=["none", "dex"], rounds=ROUNDS, seed=SEED
            )
            for rates in found.rates():
                print(network, name, rates.noise, rates.success, rates.cleared, sep="; ")
            print(found.table.groupby("noise")["outcome"].value_counts().to_string(), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
