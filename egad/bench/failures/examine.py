"""Whether an object is a failure: screened with few attempts, confirmed with fresh ones.

An object is a failure of a detector if it can be grasped, but the detector does not grasp it: the
reference holds it in at least 80 % of the attempts, and at least 50 percentage points more often
than the detector from the same poses. Both must hold with 95 % confidence, in every physics engine,
on drops that were not used to choose anything. These are the default settings.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Literal

import pandas as pd
import trimesh

from egad.bench.failures.evidence import Claim, Examined, ObjectVerdict, PairedDrop, failed_drops
from egad.bench.failures.models import model_of_attempts
from egad.bench.failures.object_runner import ObjectRunner, open_runner
from egad.bench.failures.parameters import FailureParameters, FailureSearch
from egad.bench.failures.recorder import Drop, Recorder
from egad.bench.failures.reference import ReferencePolicy
from egad.detectors import Detector, asked_for
from egad.errors import RejectedError, UserError
from egad.evalset import print_problems
from egad.grasps.sampling import dataset_grasps
from egad.sim import Model
from egad.tables.grasping import GRASPS
from egad.tables.outcomes import Outcome
from egad.tables.parquet import empty

SOLVED = 0.5  # of the success rate that a failure may have: above this, examination ends
TRIES = 3  # grasps of the reference per drop, while it is chosen
HOPELESS = 0.3  # fraction of the drops without a grasp that holds, above which the choice ends


def approach_of(detect: Detector, search: FailureSearch) -> Literal["above", "any"]:
    """The approach of a detector: from the settings, or else from the input that it asks for."""
    sees = asked_for(detect)
    if search.approach == "above" and sees != "view":
        raise UserError(
            f"the detector asks for `{sees}`, but for grasps from above it gets a view from above; "
            "with the approach `any` it gets what it asks for"
        )
    return search.approach or ("above" if sees == "view" else "any")


class Examination:
    """Examines one object with one detector."""

    def __init__(
        self,
        mesh: trimesh.Trimesh,
        object_id: str,
        detect: Detector,
        settings: FailureParameters,
        report: Callable[[int], object] = int,
    ) -> None:
        """Prepare for a closed mesh, scaled, metres; the id and the seed determine all drops."""
        self._mesh, self._id = mesh, object_id
        self._settings, self._search = settings, settings.failures
        self._from_above = approach_of(detect, settings.failures) == "above"
        self._recorder = Recorder(object_id, detect, settings.seed, report)
        self._reference = ReferencePolicy()
        self._solved = 0  # attempts in which the detector succeeded, before fresh ones

    def run(self) -> Examined:
        """Screen, choose the reference, and confirm, as far as necessary."""
        try:
            verdict, reason = self._verdict()
        except RejectedError as problem:
            verdict, reason = ObjectVerdict.NOT_SIMULATED, str(problem)
        return Examined(verdict, reason, self._recorder.table())

    def _verdict(self) -> tuple[ObjectVerdict, str]:
        rough = model_of_attempts(self._mesh, "screen", self._settings, self._id)
        with self._runners(rough, empty(GRASPS)) as runners:
            if (found := self._screen(runners)) is not None:
                return found
        grasps = self._labelled()
        with self._runners(rough, grasps) as runners:
            if (verdict := self._choose(runners)) is not None:
                return verdict, ""
        if problems := print_problems(self._mesh, self._settings.print_check):
            return ObjectVerdict.NOT_PRINTABLE, ", ".join(problems)
        exact = model_of_attempts(self._mesh, "confirm", self._settings, self._id)
        with self._runners(exact, grasps) as runners:
            is_failure = self._confirm(runners)
        return ObjectVerdict.FAILURE if is_failure else ObjectVerdict.NOT_CONFIRMED, ""

    def explain(self, attempts: pd.DataFrame) -> pd.DataFrame:
        """Try other proposals of the detector where only the reference succeeded: the attempts."""
        recorder, engine = self._recorder, self._search.engines[0]
        exact = model_of_attempts(self._mesh, "explain", self._settings, self._id)
        failed = failed_drops(attempts, engine)[: self._search.explain]
        with self._runners(exact, empty(GRASPS)) as (runner, *_):
            for number in failed:
                drop = recorder.drop(runner, "confirm", number)
                if drop is None:
                    continue
                proposed = recorder.propose(drop)
                drop = drop._replace(purpose="explain")
                for rank, grasp in enumerate(proposed if isinstance(proposed, list) else []):
                    if rank and recorder.execute(drop, "detector", grasp, rank):
                        break
        return recorder.table()

    @contextmanager
    def _runners(self, model: Model, grasps: pd.DataFrame) -> Iterator[list[ObjectRunner]]:
        """A runner in each engine, for the duration of the `with` block."""
        with ExitStack() as stack:
            opened = (
                open_runner(engine, model, grasps, self._settings, from_above=self._from_above)
                for engine in self._search.engines
            )
            yield list(map(stack.enter_context, opened))

    def _labelled(self) -> pd.DataFrame:
        try:
            return dataset_grasps(self._mesh, self._id, self._settings.labels)
        except RejectedError:
            return empty(GRASPS)

    def _screen(self, runners: Sequence[ObjectRunner]) -> tuple[ObjectVerdict, str] | None:
        """Make a few attempts with the detector alone; None if the object is worth examining."""
        drops = 0
        for number in range(self._search.screen):
            runner = runners[number % len(runners)]
            drop = self._recorder.drop(runner, "screen", number)
            if drop is None:
                continue
            drops += 1
            self._solved += self._recorder.ask(drop, self._reference)
            if self._is_solved(self._search.screen):
                return ObjectVerdict.DETECTOR_SUCCEEDS, ""
        return None if drops else (ObjectVerdict.NOT_SIMULATED, "it does not come to rest")

    def _is_solved(self, planned: int) -> bool:
        """Whether the detector succeeds too often for a failure, given the planned attempts."""
        return self._solved > SOLVED * (1 - self._search.least_difference) * planned

    def _choose(self, runners: Sequence[ObjectRunner]) -> ObjectVerdict | None:
        """Let the reference try grasps, then the detector; None if there is no verdict yet."""
        lost, planned = 0, self._search.screen + self._search.choose
        for number in range(self._search.choose):
            lost += not self._choose_at(runners, number)
            if lost > HOPELESS * self._search.choose:
                return ObjectVerdict.NOT_GRASPABLE
            if self._is_solved(planned):
                return ObjectVerdict.DETECTOR_SUCCEEDS
        return None

    def _choose_at(self, runners: Sequence[ObjectRunner], number: int) -> bool:
        """Whether the reference holds the object at a drop; if so, the detector also tries."""
        runner = runners[number % len(runners)]
        drop = self._recorder.drop(runner, "choose", number)
        if drop is None or not self._try_reference(drop):
            return False
        self._solved += self._recorder.ask(drop, self._reference)
        return True

    def _try_reference(self, drop: Drop) -> bool:
        """Whether one of the best grasps of the reference holds; it learns from all of them."""
        for rank in range(TRIES):
            known = self._reference.ranked(drop.runner, drop.rest)
            if not known:
                return False
            success = self._recorder.execute(drop, "reference", known[0], rank)
            self._reference.remember(drop.rest, known[0], success)
            if success:
                return True
        return False

    def _confirm(self, runners: Sequence[ObjectRunner]) -> bool:
        """Try both from fresh drops, engines in turn, until it is clear if it is a failure."""
        search = self._search
        claim = Claim(search.least_reference, search.least_difference, search.confidence)
        open_ones = {runner: list[PairedDrop]() for runner in runners}
        for number in range(search.confirm):
            for runner, pairs in list(open_ones.items()):
                pair = self._paired(runner, "confirm", number)
                if pair is None:
                    return False
                pairs.append(pair)
                if claim.is_shown(pairs):
                    del open_ones[runner]
                elif claim.is_hopeless(pairs, search.confirm):
                    return False
        return not open_ones

    def _paired(self, runner: ObjectRunner, purpose: str, number: int) -> PairedDrop | None:
        """Try both at a fresh drop; None if the object does not come to rest."""
        drop = self._recorder.drop(runner, purpose, number)
        if drop is None:
            return None
        known = self._reference.ranked(runner, drop.rest)
        if known:
            won = self._recorder.execute(drop, "reference", known[0])
        else:
            won = self._recorder.note(drop, "reference", Outcome.NO_GRASP)
        return PairedDrop(won, self._recorder.ask(drop))
