"""Whether the names that a configuration refers to are defined in it."""

from collections.abc import Iterable, Iterator, Mapping

from egad.bench.failures import check_searchable
from egad.detectors import IN_ANY_DIRECTION, check_gripper
from egad.errors import UserError
from egad.grippers import ANTIPODAL
from egad_workflow.config_files import NAMES
from egad_workflow.settings import Settings


def wrong_references(settings: Settings) -> list[str]:
    """The names that a configuration uses but does not define; defaults are not checked."""
    problems = [
        *_undefined(settings),
        *_wrong_kind("targets.detectors", settings.targets.detectors, settings),
        *_not_for_trials(settings),
        *_scaled_under_grasps(settings),
        *_wrong_kind("targets.clutter", settings.targets.clutter, settings),
        *_impossible_targets(settings),
        *_impossible_searches(settings),
    ]
    evolved = [name for name, data in settings.datasets.items() if data.source == "evolved"]
    if len(evolved) > 1:
        problems.append(
            f"datasets: at most one can have the source `evolved`, got {', '.join(evolved)}"
        )
    return problems


def _undefined(settings: Settings) -> Iterator[str]:
    """A line for each name that is not defined; defaults of `release` may name what is missing."""
    for section, key, table in NAMES:
        if section == "release" and section not in settings.model_fields_set:
            continue
        names = getattr(getattr(settings, section), key)
        listed = names if isinstance(names, list) else [names] if names else []
        yield from unknown_names(f"{section}.{key}", listed, getattr(settings, table))


def _wrong_kind(key: str, detectors: Iterable[str], settings: Settings) -> list[str]:
    """A line for each detector of a target that is for another kind of gripper than a target's."""
    problems = []
    hands = [name for name in settings.targets.grippers if name in settings.grippers]
    for name in (name for name in detectors if name in settings.detectors):
        for hand in hands:
            try:
                check_gripper(settings.detectors[name].name, settings.grippers[hand])
            except UserError as error:
                problems.append(f"{key}: with {hand} of targets.grippers, {error}")
    return problems


def _not_for_trials(settings: Settings) -> list[str]:
    """A line for each detector of trials that needs more than these show it."""
    return [
        f"targets.detectors: {name} asks for more than a view from above: see targets.clutter"
        for name in settings.targets.detectors
        if name in settings.detectors and settings.detectors[name].detector in IN_ANY_DIRECTION
    ]


def _scaled_under_grasps(settings: Settings) -> list[str]:
    """A line for each detector that is known grasps of meshes, if these are scaled."""
    targets, rule = settings.targets, settings.rescale.rule
    sources = {data.source for name in targets.datasets if (data := settings.datasets.get(name))}
    return [
        f"rescale.rule: it is {rule}; with the grasps of meshes, {name}, it is none: they have one "
        "size"
        for name in dict.fromkeys([*targets.detectors, *targets.clutter])
        if "meshes" in sources and rule != "none"
        if name in settings.detectors and settings.detectors[name].known_grasps
    ]


def _impossible_targets(settings: Settings) -> list[str]:
    """A line for each target that a gripper without jaws, or with its own sampler, cannot have."""
    hands = {name: settings.grippers.get(name) for name in settings.targets.grippers}
    others = {name: hand.kind for name, hand in hands.items() if hand and not hand.kind.closes}
    own = [name for name, hand in hands.items() if hand and hand.kind.closes and hand.sampler]
    problems = [
        f"targets.{key}: {name} of targets.grippers has {kind.noun}; this is for jaws"
        for key in ("simulated_labels", "agreement", "render", "scenes")
        if getattr(settings.targets, key)
        for name, kind in others.items()
    ]
    problems += [
        f"targets.render: {name} of targets.grippers has a sampler of its own; images need "
        "antipodal grasps"
        for name in own
        if settings.targets.render and settings.grippers[name].grasps_with != ANTIPODAL
    ]
    return problems


def _impossible_searches(settings: Settings) -> list[str]:
    """A line for each impossible target of a search for failures."""
    targets = settings.targets
    if not targets.failures:
        return []
    sources = {name: settings.datasets.get(name) for name in targets.datasets}
    problems = [
        f"targets.failures: {name} of targets.datasets has the source `{data.source}`, without "
        "genomes; failures are searched for among evolved objects (`evolved` or `archive`)"
        for name, data in sources.items()
        if data and data.source not in ("evolved", "archive")
    ]
    hands = {name: settings.grippers.get(name) for name in targets.grippers}
    for name in targets.failures:
        detector = settings.detectors.get(name)
        if detector is None:
            continue
        if settings.failures.approach == "above" and detector.detector in IN_ANY_DIRECTION:
            problems.append(
                f"targets.failures: {name} asks for more than a view from above, and "
                "failures.approach is above"
            )
        for gripper, hand in hands.items():
            try:
                if hand:
                    check_searchable(detector, hand)
            except UserError as error:
                problems.append(f"targets.failures: with {gripper} of targets.grippers, {error}")
    return problems


def unknown_names(key: str, used: Iterable[str], table: Mapping[str, object]) -> list[str]:
    """A line for each name that a setting uses and a table does not have."""
    return [
        f"{key}: {name!r} is not defined; known: {', '.join(sorted(table))}"
        for name in used
        if name not in table
    ]
