"""Scores of the networks of the training study: `python experiments/scores.py STUDY SET...`.

For each training set, the images of the split test that have a positive grasp; in how many percent
of them each network is correct; in how many percent of those of a single object the outline is; and
the loss of each network on the validation images. STUDY is the folder `results/training_study`.
"""

import sys
from pathlib import Path

from egad._util.markdown import table
from egad.learning import outline_score
from egad.pipeline.cli.common import settings_in
from egad.pipeline.config.training_study import Network, image_sets, networks_of, settings_for
from egad.pipeline.stages.train import TrainNetwork, open_dataset
from egad.pipeline.stages.training_study import training_of

CONFIG = Path(__file__).parents[1] / "config/training_study.yaml"


def main(study: Path, names: list[str]) -> None:
    """Print the table."""
    settings = settings_in(CONFIG)
    lines = []
    for name in names:
        plan = TrainNetwork(seed=0, training=settings_for(settings, Network(name, 0)).training)
        folders = [study / "images" / each for each in image_sets(name, settings.training_sets)]
        shown = open_dataset(folders, plan)
        outline = outline_score(shown, shown.indices("test"))
        made = [
            training_of(study / "networks" / each.folder)
            for each in networks_of(settings)
            if each.training_set == name
        ]
        rates = " ".join(f"{100 * each.rate:.0f}" for each in made)
        losses = " ".join(f"{each.last['validation_loss']:.4f}" for each in made)
        share = f"{100 * outline.n_correct / outline.n_images:.0f} of {outline.n_images}"
        lines.append((f"`{name}`", int(made[0].score["n_images"]), rates, share, losses))
    head = ["trained on", "test images", "correct, %", "outline, %", "loss on validation images"]
    print(table(head, lines))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
