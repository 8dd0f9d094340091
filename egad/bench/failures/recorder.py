"""Attempts at one object: drops, grasps of the detector and of others, and their results."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad.bench.failures.object_runner import ObjectRunner
from egad.bench.failures.reference import REST, ReferencePolicy
from egad.detectors import Detector, Failure, Grasp
from egad.random import generator
from egad.sim import Pose
from egad.tables.failures import FAILURE_ATTEMPTS
from egad.tables.outcomes import Outcome


class Drop(NamedTuple):
    """An object that has come to rest."""

    runner: ObjectRunner
    rest: Pose
    purpose: str  # as in `tables.failures.FAILURE_ATTEMPTS`
    number: int  # number of the drop for this purpose


class Recorder:
    """Makes attempts at one object with one detector, and keeps a row of each."""

    def __init__(
        self, object_id: str, detect: Detector, seed: int, report: Callable[[int], object] = int
    ) -> None:
        """Begin without a row; `report` is called with 1 after every attempt."""
        self._id, self._detect, self._seed, self._report = object_id, detect, seed, report
        self._rows: list[dict[str, Any]] = []

    def table(self) -> pd.DataFrame:
        """One row per attempt so far, columns of `tables.failures.FAILURE_ATTEMPTS`."""
        return pd.DataFrame(self._rows, columns=FAILURE_ATTEMPTS.names)

    def drop(self, runner: ObjectRunner, purpose: str, number: int) -> Drop | None:
        """Drop the object in the orientation of a number; None if it does not come to rest."""
        rest = runner.drop(self._rng("drop", purpose, number))
        return None if rest is None else Drop(runner, rest, purpose, number)

    def propose(self, drop: Drop) -> list[Grasp] | Outcome | Failure:
        """Proposals of the detector; see `ObjectRunner.propose`."""
        rng = self._rng(f"detector {drop.runner.engine}", drop.purpose, drop.number)
        return drop.runner.propose(self._detect, drop.rest, rng)

    def ask(self, drop: Drop, learner: ReferencePolicy | None = None) -> bool:
        """Whether the first proposal of the detector holds; a learner, if given, remembers it."""
        proposed = self.propose(drop)
        if isinstance(proposed, Failure):
            return self.note(drop, "detector", proposed.outcome, failure=proposed.text)
        if isinstance(proposed, Outcome):
            return self.note(drop, "detector", proposed)
        success = self.execute(drop, "detector", proposed[0])
        if learner is not None:
            learner.remember(drop.rest, proposed[0], success)
        return success

    def execute(self, drop: Drop, who: str, grasp: Grasp, rank: int = 0) -> bool:
        """Execute a grasp proposed by `who`, with its rank; return whether it holds."""
        return self.note(drop, who, drop.runner.execute(drop.rest, grasp), grasp, rank)

    def note(
        self,
        drop: Drop,
        who: str,
        outcome: Outcome,
        grasp: Grasp | None = None,
        rank: int = 0,
        failure: str = "",
    ) -> bool:
        """Record the result of an attempt as a row; return whether it succeeded."""
        lies = [*drop.rest.position.tolist(), *drop.rest.quaternion.tolist()]
        self._rows.append(
            {
                "id": self._id,
                "engine": drop.runner.engine,
                "purpose": drop.purpose,
                "drop": drop.number,
                "who": who,
                "rank": rank,
                "success": outcome == Outcome.SUCCESS,
                "outcome": outcome.value,
                **dict(zip(REST, lies, strict=True)),
                "pose": [] if grasp is None else grasp.pose[:3].ravel().tolist(),
                "width": np.nan if grasp is None else grasp.width,
                "score": np.nan if grasp is None else grasp.quality,
                "failure": failure,
            }
        )
        self._report(1)
        return outcome == Outcome.SUCCESS

    def _rng(self, what: str, purpose: str, number: int) -> np.random.Generator:
        return generator(self._seed, f"failure {what}", purpose, self._id, number)
