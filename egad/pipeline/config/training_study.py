"""The networks of the experiment on training sets, and the settings that each is made with."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from egad.errors import UserError
from egad.pipeline.config import DetectorConfig, Settings, TrainingSet

FOLDER = Path("results/training_study")
WEIGHTS = "weights.safetensors"


class Network(NamedTuple):
    """A network of the experiment.

    Attributes:
        training_set: What it learnt from.
        seed: Number of its training, from 0; 0 for given weights.
    """

    training_set: str
    seed: int

    @property
    def name(self) -> str:
        """What it is called as a grasp detector."""
        return f"{self.training_set}-{self.seed}"

    @property
    def folder(self) -> str:
        """Where it is trained, in the folder of networks."""
        return f"{self.training_set}/{self.seed}"


def networks(sets: Mapping[str, TrainingSet], names: list[str], seeds: int) -> list[Network]:
    """The networks of some training sets; of given weights there is one.

    Args:
        sets: All training sets.
        names: Those that are compared.
        seeds: Networks trained on each.
    """
    counts = {name: seeds if sets[name].dataset else 1 for name in names}
    return [Network(name, seed) for name, count in counts.items() for seed in range(count)]


def networks_of(settings: Settings) -> list[Network]:
    """The networks that a configuration asks for."""
    asked = settings.training_study
    return networks(settings.training_sets, asked.sets, asked.seeds)


def with_networks(settings: Settings) -> Settings:
    """The same with these networks among the grasp detectors, so that they are tried as any other.

    Raises:
        UserError: Another detector has the name of one.
    """
    detectors = dict(settings.detectors)
    for network in networks_of(settings):
        if network.name in settings.detectors:
            raise UserError(
                f"detectors.{network.name}: that is what a network of the training set "
                f"{network.training_set} is called; rename one of them"
            )
        given = settings.training_sets[network.training_set].weights
        trained = (FOLDER / "networks" / network.folder / WEIGHTS).as_posix()
        detectors[network.name] = DetectorConfig(detector="ggcnn", weights=given or trained)
    return settings.model_copy(update={"detectors": detectors})


def settings_for(settings: Settings, network: Network) -> Settings:
    """The settings that the images of a training set and a network are made with.

    All sets have as many images, and their images the same seed; networks of a set differ in the
    seed of the training.
    """
    chosen = settings.training_sets[network.training_set]
    parts = {name: getattr(chosen, name) for name in ("complexity", "subset", "hold_out")}
    render = settings.render.model_copy(update=parts)
    return settings.model_copy(update={"render": render, "seed": settings.seed + network.seed})
