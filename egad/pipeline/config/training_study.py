"""The networks of the training study, and the settings that they are trained and tested with."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from egad.errors import UserError
from egad.perception import STEREO
from egad.pipeline.config import DetectorConfig, Settings, TrainingSet, TrainingStudy
from egad.pipeline.config.references import changed
from egad.pipeline.config.sections import SET_SECTIONS

FOLDER = Path("results/training_study")
WEIGHTS = "weights.safetensors"


class Network(NamedTuple):
    """A network of the study.

    Attributes:
        training_set: What it was trained on.
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


def networks(sets: Mapping[str, TrainingSet], study: TrainingStudy) -> list[Network]:
    """The networks of the training sets that are compared; of given weights there is one."""
    counts = {
        name: 1 if sets[name].weights else sets[name].seeds or study.seeds for name in study.sets
    }
    return [Network(name, seed) for name, count in counts.items() for seed in range(count)]


def networks_of(settings: Settings) -> list[Network]:
    """The networks that a configuration asks for."""
    return networks(settings.training_sets, settings.training_study)


def image_sets(name: str, sets: Mapping[str, TrainingSet]) -> list[str]:
    """The training sets whose images a set consists of: itself, if it has a dataset."""
    return [name] if sets[name].dataset else sets[name].images


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

    The images of all sets have the same seed; networks of a set differ in that of the training.
    """
    chosen = settings.training_sets[network.training_set]
    sections = {
        name: changed(getattr(settings, name), getattr(chosen, name)) for name in SET_SECTIONS
    }
    return settings.model_copy(update={**sections, "seed": settings.seed + network.seed})


def settings_of_tests(settings: Settings, noise: str = "none") -> Settings:
    """The settings that networks are tested with.

    Args:
        settings: The whole configuration.
        noise: Of the depth images of trials with single objects: none or stereo. Cleared tables
            have all kinds of noise of the study.
    """
    study = settings.training_study
    depth_noise = STEREO.disparity if noise == "stereo" else 0.0
    scenes = {"scenes": tuple(study.clutter), "noise": tuple(study.noise), "rounds": study.rounds}
    parts = {
        "trials": settings.trials.model_copy(update={"depth_noise": depth_noise}),
        "clutter": settings.clutter.model_copy(update=scenes),
    }
    return settings.model_copy(update=parts)
