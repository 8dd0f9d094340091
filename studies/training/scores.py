"""Scores of the networks of the training study: `python scores.py STUDY SET...`.

Prints for each training set: the number of images of the split test that have a positive grasp; the
percentage of them in which each network is correct; the percentage of those of a single object in
which the outline is; and the loss of each network on the validation images. STUDY is the folder
`results/training_study`.
"""

import sys
from pathlib import Path

from study import Network, read_study, settings_for
from study_results import training_of

from egad._util.markdown import table
from egad.learning import TrainNetwork, outline_score
from egad.learning.train_on_images import open_dataset

CONFIG = Path(__file__).with_name("study.yaml")


def main(results: Path, names: list[str]) -> None:
    """Print the table."""
    study = read_study(CONFIG)
    lines = []
    for name in names:
        plan = TrainNetwork(seed=0, training=settings_for(study, Network(name, 0)).training)
        folders = [results / "images" / each for each in study.plan.image_sets(name)]
        shown = open_dataset(folders, plan)
        outline = outline_score(shown, shown.indices("test"))
        made = [
            training_of(results / "networks" / each.folder)
            for each in study.plan.networks
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
