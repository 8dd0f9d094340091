"""Films of attempts of hands, executed again from their rows."""

from typing import Any

from egad._util.arrays import RgbImage
from egad.bench.failures.reference import read_attempt
from egad.bench.hands.attempts import deviation
from egad.bench.hands.comparison import HandComparison
from egad.bench.hands.hand_runner import HandRunner
from egad.errors import UserError
from egad.grippers import Gripper
from egad.objects import NamedMesh
from egad.sim import Film, free_hand, open_world
from egad.sim.model import simulated
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty


def film_attempt_of_hand(
    card: HandComparison, target: NamedMesh, row: dict[str, Any]
) -> list[RgbImage]:
    """Frames, 20 per second, of an attempt of a comparison, a row with a pose.

    UserError if it ends differently on this machine.
    """
    settings = card.settings
    _, model = simulated(target, Gripper(opening=settings.hands.size), card.rule)
    drop, grasper, number = (row[name] for name in ("drop", "grasper", "attempt"))
    rest, grasp = read_attempt(row | {"score": 0.0})
    with open_world(settings.hands.engine, [model], free_hand(card.hands[row["hand"]])) as world:
        runner, film = HandRunner(world, empty(GRASPS), settings.hands), Film(world)
        tried = runner.attempt(rest, grasp, deviation(settings, row["id"], drop, grasper, number))
    if tried.outcome != row["outcome"]:
        raise UserError(
            f"{row['label']}, drop {drop}, {row['hand']}: {row['outcome']} became {tried.outcome}; "
            "machine, settings or the version of the engine must differ"
        )
    return film.frames
