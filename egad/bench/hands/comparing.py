"""Comparing hands: the same objects in millimetres, drops and errors for each of them."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Any

import pandas as pd
import trimesh

from egad._util.parameters import from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.failures.finding import name_of
from egad.bench.hands.attempts import try_hands
from egad.bench.hands.comparison import HandComparison
from egad.bench.hands.hand_runner import USUAL
from egad.bench.hands.parameters import HandParameters, HandTrials
from egad.bench.parameters import CellErrors
from egad.detectors import (
    IN_SCENES,
    SHIPPED_NETWORKS,
    Detect,
    DetectorConfig,
    FailureMonitor,
    NoiseName,
    as_detector,
    check_gripper,
    knows_scene,
    opened,
)
from egad.errors import RejectedError, UserError
from egad.geometry import SIDE_FRACTION, box_sides
from egad.grippers import Gripper, as_gripper
from egad.objects import EVALUATION_SET, Dataset, NamedMesh, load, named_meshes, scaled_solid
from egad.sim import EngineName, check_engine

Hands = Mapping[str, Gripper | str] | Sequence[str]


def compare_hands(
    hands: Hands,
    objects: Dataset | Mapping[str, trimesh.Trimesh] | None = None,
    *,
    detector: Detect | str | None = None,
    size: float = 0.06,
    drops: int = 6,
    search_drops: int = 8,
    errors: str | Mapping[str, Any] | CellErrors = "typical",
    noise: NoiseName = "stereo",
    engine: EngineName = "mujoco",
    seed: int = 0,
    jobs: int = 1,
) -> HandComparison:
    """Let hands try the same objects: what they can do, how easily, and with a detector.

    Three graspers choose the grasps. `best`: the best grasp that a search finds, from above and
    from any direction, at drops that do not count. `detector`: what a detector proposes. `naive`:
    three naive grasps at each drop, straight in at random points of the surface. For all hands,
    an object has the same size, lies in the same poses, and the errors of the cell are the same.
    The hand comes along a straight line; a contact on the way is a failure. It then retreats by
    10 cm and holds the object for half a second.

    Args:
        hands: Names of grippers, or grippers by a name; differences are to the first.
        objects: A dataset of evolved objects, scaled to `size`; or meshes in metres by name, which
            keep their size. By default, the evaluation set.
        detector: As for `egad.run_benchmark`. By default `antipodal-depth` for jaws and
            `suction-depth` for cups.
        size: Opening that evolved objects are scaled to, by the rule `paper`, metres: their
            smallest side becomes at most 80 % of it.
        drops: Drops of each object that hands are judged on.
        search_drops: Other drops, on which the best grasps are searched for.
        errors: Errors of a real cell, as in `egad.run_trials`.
        noise: Noise of the depth images that the detector gets: none, stereo, gamma, dex or points.
        engine: What computes the physics: `mujoco`, `pybullet` or `drake`.
        seed: The same arguments give the same table.
        jobs: Processes; the result does not depend on them.

    Raises:
        UserError: A hand opens less than the smallest object; the detector is for another kind of
            gripper, knows where objects lie, or fails in every attempt at the first three objects;
            there is no such gripper; none of the objects can be simulated; or a number is out of
            range.

    Source: ours; the search is that of the reference of `egad.find_failures`.
    """
    check_engine(engine)
    trials = from_arguments(
        HandTrials,
        size=size,
        drops=drops,
        search_drops=search_drops,
        errors=errors,
        noise=noise,
        engine=engine,
    )
    settings = from_arguments(HandParameters, seed=seed, hands=trials)
    chosen = load(EVALUATION_SET) if objects is None else objects
    rule = "paper" if isinstance(chosen, Dataset) else "none"
    return compare_at(named_hands(hands), named_meshes(chosen), detector, settings, rule, jobs)


def named_hands(hands: Hands) -> dict[str, Gripper]:
    """Hands by name; UserError if there is none, one twice, or one has no name."""
    if not isinstance(hands, Mapping):
        names = [hands] if isinstance(hands, str) else list(hands)
        if unnamed := [each for each in names if not isinstance(each, str)]:
            raise UserError(f"{unnamed[0]!r} has no name; give hands as {{'mine': egad.Gripper()}}")
        check_distinct(names)
        hands = {name: name for name in names}
    if not hands:
        raise UserError("there are no hands to compare")
    return {name: as_gripper(hand) for name, hand in hands.items()}


def check_distinct(names: Sequence[str]) -> None:
    """Raise UserError for a hand that is given twice."""
    if twice := [name for name in names if names.count(name) > 1]:
        raise UserError(f"the hand {twice[0]} is given twice")


def compare_at(
    hands: Mapping[str, Gripper],
    targets: Sequence[NamedMesh],
    detector: Detect | str | None,
    settings: HandParameters,
    rule: str,
    jobs: int = 1,
) -> HandComparison:
    """Compare hands at objects that are scaled by a rule; see `compare_hands`, also for errors."""
    kinds = {hand.kind.name for hand in hands.values()}
    detectors = {kind: _detector_of(kind, detector) for kind in sorted(kinds)}
    _check_hands(hands, detectors, targets, settings.hands.size, rule)
    monitor = FailureMonitor(len(targets), keep_going=False, remedy="")
    tables = []
    with ExitStack() as stack, workers(jobs) as mapper:
        asked = {
            kind: stack.enter_context(opened(detect, settings.planning_time, at_once=False))
            for kind, detect in detectors.items()
        }
        work = partial(try_hands, hands=hands, detectors=asked, rule=rule, settings=settings)
        for table in progress(mapper(work, targets), "trying", len(targets)):
            monitor.check(table[table["grasper"] == "detector"])
            tables.append(table)
    known = [table for table in tables if len(table)]
    if not known:
        raise UserError("none of the objects can be simulated")
    names = {name: name_of(detectors[hand.kind.name]) for name, hand in hands.items()}
    return HandComparison(pd.concat(known), hands, names, settings, rule)


def _detector_of(kind: str, detector: Detect | str | None) -> Detect:
    """The detector for a kind of gripper; UserError if it cannot be compared with a search."""
    found = as_detector(detector or USUAL[kind], (*SHIPPED_NETWORKS, *IN_SCENES))
    if isinstance(found, DetectorConfig) and knows_scene(found):
        raise UserError(
            f"the detector {found.name} knows where objects lie, as the search for the best grasp "
            "does; give one that has to see them"
        )
    return found


def _check_hands(
    hands: Mapping[str, Gripper],
    detectors: Mapping[str, Detect],
    targets: Sequence[NamedMesh],
    size: float,
    rule: str,
) -> None:
    """Raise UserError for a hand that does not fit its detector, or opens less than all objects."""
    for name, hand in hands.items():
        detect = detectors[hand.kind.name]
        try:
            if isinstance(detect, DetectorConfig):
                check_gripper(detect.name, hand)
        except UserError as error:
            raise UserError(f"the hand {name}: {error}") from error
    openings = {name: hand.opening for name, hand in hands.items() if hand.kind.closes}
    narrowest = min(openings, key=openings.__getitem__, default="")
    if not narrowest or (rule == "paper" and openings[narrowest] >= SIDE_FRACTION * size):
        return
    sides = {each.label: _smallest_side(each, size, rule) for each in targets}
    smallest = min(sides, key=sides.__getitem__)
    if openings[narrowest] < sides[smallest] < float("inf"):
        raise UserError(
            f"the hand {narrowest} opens {1000 * openings[narrowest]:.3g} mm, less than the "
            f"smallest object, {smallest}, is thick ({1000 * sides[smallest]:.3g} mm): compare "
            "hands at smaller objects"
        )


def _smallest_side(target: NamedMesh, size: float, rule: str) -> float:
    """The smallest side of an object, metres; infinite if it cannot be used."""
    try:
        return float(box_sides(scaled_solid(target, Gripper(opening=size), rule))[0])
    except RejectedError:
        return float("inf")
