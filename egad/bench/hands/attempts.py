"""All attempts of several hands at one object, from the same poses of rest."""

import logging
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad.bench.cell_errors import Deviation, draw
from egad.bench.failures.reference import REST, ReferencePolicy
from egad.bench.hands.hand_runner import PROTOCOL, HandResult, HandRunner
from egad.bench.hands.parameters import HandParameters
from egad.bench.scenes import make_scene
from egad.detectors import Detector, Failure, Grasp, grasps_if_any
from egad.errors import RejectedError
from egad.geometry import box_sides
from egad.grasps import label_parameters
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.random import entropy, generator
from egad.sim import Model, Pose, UnstableError, free_hand, open_world, platform_of
from egad.sim.model import simulated
from egad.tables.hands import HAND_ATTEMPTS, OF_OUTCOME
from egad.tables.outcomes import Outcome

log = logging.getLogger(__name__)
LABELLED = 300  # grasps of each object among which the search looks
SETTLED = 5  # drops in a row at which the first grasp holds, after which the search ends


class RestingDrop(NamedTuple):
    """An object that lies still."""

    number: int
    rest: Pose


def try_hands(
    target: NamedMesh,
    hands: Mapping[str, Gripper],
    detectors: Mapping[str, Detector],
    rule: str,
    settings: HandParameters,
) -> pd.DataFrame:
    """Rows of `HAND_ATTEMPTS`: all hands at one object; none if it cannot be used.

    Detectors are by kind of gripper. The object has the same size for all hands, by a rule. Drops,
    errors of the cell, noise and naive grasps are the same for all hands, too.
    """
    trials = settings.hands
    try:
        mesh, model = simulated(target, Gripper(opening=trials.size), rule)
        drops = _drops(model, target.id, settings)
    except (RejectedError, UnstableError) as reason:
        log.warning("%s is left out: %s", target.label, reason)
        return pd.DataFrame(columns=HAND_ATTEMPTS.names)
    smallest, _, longest = box_sides(mesh).tolist()
    known = {
        "label": target.label,
        "id": target.id,
        "smallest_side": smallest,
        "longest_side": longest,
        "engine": trials.engine,
        "platform": platform_of(trials.engine),
        "errors": str(trials.errors),
    }
    rows: list[dict[str, Any]] = []
    for name, hand in hands.items():
        grasps = grasps_if_any(mesh, target.id, label_parameters(hand, LABELLED, settings.seed))
        with open_world(trials.engine, [model], free_hand(hand)) as world:
            runner = HandRunner(world, grasps, trials)
            made = _Attempts(runner, target.id, settings).all_of(drops, detectors[hand.kind.name])
            rows += [known | {"hand": name} | row for row in made]
    return pd.DataFrame(rows, columns=HAND_ATTEMPTS.names)


def _drops(model: Model, object_id: str, settings: HandParameters) -> list[RestingDrop]:
    """Where the object comes to rest, in a world without a hand; UnstableError if it does not."""
    count = settings.hands.search_drops + settings.hands.drops
    with open_world(settings.hands.engine, [model]) as world:
        return [
            RestingDrop(number, make_scene(world, "single", rng, PROTOCOL)[0].pose)
            for number in range(count)
            for rng in [generator(settings.seed, "drop for hands", object_id, number)]
        ]


class _Attempts:
    """Attempts of one hand at one object."""

    def __init__(self, runner: HandRunner, object_id: str, settings: HandParameters) -> None:
        """Begin without an attempt."""
        self._runner, self._id, self._settings = runner, object_id, settings
        self._policy = ReferencePolicy()

    def all_of(self, drops: list[RestingDrop], detect: Detector) -> Iterator[dict[str, Any]]:
        """Search on the first drops, then try all graspers on the others: rows."""
        trials = self._settings.hands
        yield from self._search(drops[: trials.search_drops])
        for drop in drops[trials.search_drops :]:
            ranked = self._policy.ranked(self._runner, drop.rest)
            yield self._row(drop, "best", 0, ranked[0] if ranked else Outcome.NO_GRASP)
            rng = generator(self._settings.seed, "detector of hands", self._id, drop.number)
            proposed = self._runner.propose(detect, drop.rest, rng)
            grasp = proposed[0] if isinstance(proposed, list) else proposed
            yield self._row(drop, "detector", 0, grasp)
            for number in range(trials.naive):
                index = (self._id, drop.number, number)
                rng = generator(self._settings.seed, "naive grasp of hands", *index)
                naive = self._runner.naive(drop.rest, rng)
                yield self._row(drop, "naive", number, naive or Outcome.NO_GRASP)

    def _search(self, drops: list[RestingDrop]) -> Iterator[dict[str, Any]]:
        """Try the most promising grasps at each drop until one holds, and learn from them."""
        settled = 0
        for drop in drops:
            for number in range(self._settings.hands.tries):
                ranked = self._policy.ranked(self._runner, drop.rest)
                row = self._row(drop, "search", number, ranked[0] if ranked else Outcome.NO_GRASP)
                yield row
                if ranked:
                    self._policy.remember(drop.rest, ranked[0], row["success"])
                if row["success"] or not ranked:
                    break
            settled = settled + 1 if row["success"] and number == 0 else 0
            if settled == SETTLED:
                return

    def _row(
        self, drop: RestingDrop, grasper: str, number: int, grasp: Grasp | Outcome | Failure
    ) -> dict[str, Any]:
        """Try a grasp, if there is one: the columns that depend on the attempt."""
        failure = grasp.text if isinstance(grasp, Failure) else ""
        if isinstance(grasp, Grasp):
            tried = self._runner.attempt(drop.rest, grasp, self._deviation(drop, grasper, number))
            pose, width = grasp.pose[:3].ravel().tolist(), grasp.width
        else:
            outcome = grasp.outcome if isinstance(grasp, Failure) else grasp
            tried, pose, width = HandResult(outcome, OF_OUTCOME[outcome]), [], np.nan
        lies = [*drop.rest.position.tolist(), *drop.rest.quaternion.tolist()]
        return {
            "grasper": grasper,
            "drop": drop.number,
            "attempt": number,
            "success": tried.outcome == Outcome.SUCCESS,
            "outcome": tried.outcome.value,
            "cause": tried.cause.value,
            "turned": tried.turned,
            **dict(zip(REST, lies, strict=True)),
            "pose": pose,
            "width": width,
            "failure": failure,
        }

    def _deviation(self, drop: RestingDrop, grasper: str, number: int) -> Deviation:
        """Errors of an attempt, the same for all hands."""
        return deviation(self._settings, self._id, drop.number, grasper, number)


def deviation(
    settings: HandParameters, object_id: str, drop: int, grasper: str, number: int
) -> Deviation:
    """The errors of an attempt, the same for all hands; the camera is calibrated after a search."""
    session = entropy(settings.seed, "session of hands", object_id, str(grasper == "search"))
    attempt = entropy(settings.seed, "errors of hands", object_id, drop, grasper, number)
    return draw(settings.hands.errors, session, attempt)
