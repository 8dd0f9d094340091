"""Whether the names that a configuration refers to are defined in it."""

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from egad._util.parameters import Parameters
from egad.pipeline.config.sections import SET_SECTIONS
from egad.pipeline.config.settings import Settings

P = TypeVar("P", bound=Parameters)


def wrong_references(settings: Settings) -> list[str]:
    """What a configuration names and does not define, a line each.

    Only what the user gave is wrong: a default may name what is missing as long as nothing uses it.
    So a dump of the settings, in which every section is given, is not checked again.

    Args:
        settings: Those of the user's configuration, which remember what was given.
    """
    problems = [
        *_unknown("targets.datasets", settings.targets.datasets, settings.datasets),
        *_unknown("targets.grippers", settings.targets.grippers, settings.grippers),
        *_unknown("targets.detectors", settings.targets.detectors, settings.detectors),
        *_unknown("targets.clutter", settings.targets.clutter, settings.detectors),
        *_unknown("render.camera", [settings.render.camera], settings.cameras),
        *_unknown("difficulty.gripper", [settings.difficulty.gripper], settings.grippers),
        *_unknown(
            "select_eval.gripper",
            [name] if (name := settings.select_eval.gripper) else [],
            settings.grippers,
        ),
        *_unknown_in_study(settings),
        *_unknown_in_release(settings),
    ]
    evolved = [name for name, data in settings.datasets.items() if data.source == "evolved"]
    if len(evolved) > 1:
        problems.append(
            f"datasets: at most one can have the source `evolved`, got {', '.join(evolved)}"
        )
    if "training_study" in settings.datasets:
        problems.append("datasets.training_study: the name is reserved for the folder of the study")
    return problems


def _unknown_in_study(settings: Settings) -> list[str]:
    """Unknown names of the training study, and settings of its sets that do not go together.

    Training sets that are not used may name a missing dataset.
    """
    study, sets = settings.training_study, settings.training_sets
    used = [name for name in study.sets if name in sets]
    images = dict.fromkeys(name for key in used for name in sets[key].images if name in sets)
    own = {name: each for name, each in sets.items() if each.dataset}
    compared = dict.fromkeys([*study.sets, *study.references])
    trained = [name for name in study.sets if name in sets and not sets[name].weights]
    curves = {key: getattr(study, key) for key in ("object_curve", "image_curve")}
    twice = sorted({*study.sets} & {*study.references})
    return [
        *_unknown("training_study.sets", study.sets, sets),
        *_unknown("training_study.tests", study.tests, settings.datasets),
        *_unknown("training_study.references", study.references, settings.detectors),
        *(f"training_study.references: {name!r} is a training set, too" for name in twice),
        *(
            p
            for key, names in curves.items()
            for p in _unknown(f"training_study.{key}", names, dict.fromkeys(trained))
        ),
        *(
            p
            for pair in study.comparisons
            for p in _unknown("training_study.comparisons", pair, compared)
        ),
        *(
            p
            for name in used
            for p in _unknown(f"training_sets.{name}.images", sets[name].images, own)
        ),
        *(p for name in dict.fromkeys([*used, *images]) for p in _problems_of_set(settings, name)),
    ]


def _problems_of_set(settings: Settings, name: str) -> list[str]:
    """What is wrong with a training set, apart from its images."""
    chosen, path = settings.training_sets[name], f"training_sets.{name}"
    dataset = [chosen.dataset] if chosen.dataset else []
    camera = [chosen.render["camera"]] if "camera" in chosen.render else []
    problems = [
        *_unknown(f"{path}.dataset", dataset, settings.datasets),
        *_unknown(f"{path}.render.camera", camera, settings.cameras),
    ]
    for key in SET_SECTIONS:
        try:
            changed(getattr(settings, key), getattr(chosen, key))
        except ValidationError as error:
            problems += [f"{path}.{key}: {each['ctx']['error']}" for each in error.errors()]
    positive = chosen.training.get("positive", settings.training.positive)
    shown = [name for name in (chosen.images or [name]) if name in settings.training_sets]
    simulated = [
        settings.training_sets[name].render.get("simulate", settings.render.simulate)
        for name in shown
    ]
    if positive == "simulated" and not chosen.weights and not all(simulated):
        problems.append(
            f"{path}.training.positive: simulated needs images with render.simulate: true"
        )
    return problems


def _unknown_in_release(settings: Settings) -> list[str]:
    """Unknown names of the section, if it is given; its defaults may name what is missing."""
    if "release" not in settings.model_fields_set:
        return []
    return [
        *_unknown("release.dataset", [settings.release.dataset], settings.datasets),
        *_unknown("release.gripper", [settings.release.gripper], settings.grippers),
    ]


def changed(section: P, changes: Mapping[str, Any]) -> P:
    """A section of which some settings are different.

    Raises:
        ValidationError: They do not go together.
    """
    return type(section)(**{**section.model_dump(), **changes})


def _unknown(key: str, used: Iterable[str], table: Mapping[str, object]) -> list[str]:
    return [
        f"{key}: {name!r} is not defined; known: {', '.join(sorted(table))}"
        for name in used
        if name not in table
    ]
