"""Comparisons of hands whose attempts are known, so that numbers can be counted by hand."""

from partial_tables import fill_columns

from egad.bench.hands import HandComparison, HandParameters, HandTrials
from egad.grippers import GRIPPERS
from egad.tables.hands import HAND_ATTEMPTS

HANDS = {name: GRIPPERS[name] for name in ("yumi", "panda")}
LABELS = [f"{row}{column}" for row in "AB" for column in range(4)]
LONG = {label: 0.03 + 0.02 * number for number, label in enumerate(LABELS)}


def attempts(hand, label, grasper, causes):
    """Rows of attempts at drops 8, 9 and so on; `held` and `swung` are successes."""
    return [
        {"hand": hand, "label": label, "id": label, "grasper": grasper, "drop": 8 + number}
        | {"cause": cause, "success": cause in ("held", "swung"), "engine": "mujoco"}
        | {"smallest_side": 0.03, "longest_side": LONG[label]}
        for number, cause in enumerate(causes)
    ]


def card(lost=("B3",)):
    """Two drops of eight objects: `yumi` holds each once, `panda` always, but never the lost."""
    rows = []
    for label in LABELS:
        panda = ["palm", "finger"] if label in lost else ["held", "swung"]
        for grasper in ("best", "detector"):
            rows += attempts("yumi", label, grasper, ["held", "missed"])
            rows += attempts("panda", label, grasper, panda)
        for hand in HANDS:
            rows += attempts(hand, label, "naive", ["slipped", "none_reachable"])
    settings = HandParameters(seed=0, hands=HandTrials(drops=2, naive=1))
    detectors = dict.fromkeys(HANDS, "antipodal-depth")
    return HandComparison(fill_columns(HAND_ATTEMPTS, rows), HANDS, detectors, settings, "paper")
