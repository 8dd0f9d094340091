"""The datasheet of designed fingertips: dimensions, a picture, gains and losses, how to print."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pydantic.fields import FieldInfo

from egad._util.files import write_text
from egad._util.markdown import table
from egad.bench.hands import HandComparison
from egad.bench.tips import DesignedTips, FingertipDesign
from egad.grippers import Gripper, model_of
from egad.objects import NamedMesh
from egad.report.hand import hand_entry
from egad.report.hand_shape import hand_shapes, painted
from egad.report.hands import write_card
from egad.report.log_sheet import LogObject, page, plan
from egad.report.pictures import png_bytes, render
from egad.tables.hands import GRASPERS

PICTURE, OBJECT = 480, 256  # pixels
ROUNDS = 3  # of attempts before and after, on a robot
SIZES = ("opening", "finger_length", "force")
CHANGE = 0.5  # of the success rate at an object, that is told as a gain or loss
PRINTING = """## Print and mount

`first_tip.stl` and `second_tip.stl` (together `tips.3mf`) lie as they are printed: 4 perimeters or
more, full infill. The first one is for the fixed jaw, if one jaw is fixed. The foot of a tip fits
the shape of its jaw that collides: to 0.5 mm if one jaw moves, else its convex hull.
"""
MOUNTING = {
    "glue": "Print without support. Sand the jaw and glue the foot with epoxy.",
    "screw": "Print without support. Drill the jaw through the foot, 3.4 mm, and use countersunk "
    "M3 screws.",
    "join": "Each print is a jaw with its tip, of the shape that collides, from the palm on: cut "
    "the bores again that this fills. Parts that do not touch are 0.25 mm thicker all around. Only "
    "what is added was checked: let the slicer look for thin walls, and add support.",
}
CHECKING = """

Then check on the robot: `log.html` logs all attempts before, then all after the tips are mounted,
objects in random order; keep camera and light as they are. `egad trials compare` reads its CSV."""


def write_tip_pages(
    designed: DesignedTips, out: Path, targets: Sequence[NamedMesh], *, jobs: int = 1
) -> None:
    """Write a card for each engine, and the datasheet with its pictures, into a folder."""
    for engine, card in designed.cards.items():
        write_card(card, out / f"card-{engine}.html", targets, films=1, jobs=jobs)
    (name, base), (_, hand) = next(iter(designed.cards.values())).hands.items()
    for file, each in (("before.png", base), ("after.png", hand)):
        mesh, _ = painted(hand_shapes(each, each.opening / 2))
        (out / file).write_bytes(png_bytes(render(mesh, PICTURE)))
    write_text(out / "hand.yaml", hand_entry("with_tips", hand, model_of(hand)))
    write_text(out / "datasheet.md", datasheet(designed, name, base))
    write_text(out / "log.html", _log_page(designed, name, targets))


def _log_page(designed: DesignedTips, name: str, targets: Sequence[NamedMesh]) -> str:
    """The page to log attempts at the objects of the cards, before and after."""
    judged = set(next(iter(designed.cards.values())).table["label"])
    objects = [
        LogObject(each.label, each.id, png_bytes(render(each.mesh(), OBJECT)))
        for each in targets
        if each.label in judged
    ]
    planned = plan(judged, ROUNDS, ("before", "after"), 0, blind=False, rounds=True)
    order = sorted(planned.order, key=lambda attempt: attempt.detector == "after")
    planned = replace(planned, order=tuple(order))  # tips are mounted once
    return page(planned, objects, f"{name}, before and after")


def datasheet(designed: DesignedTips, name: str, base: Gripper) -> str:
    """The datasheet, as Markdown."""
    fields, hands = FingertipDesign.model_fields, (base, designed.hand)
    rows = ((key, _shown(key, value), _meaning(fields[key])) for key, value in designed.design)
    sizes = ((key, *(_shown(key, getattr(each, key)) for each in hands)) for key in SIZES)
    works = int((designed.table["problems"] == "").sum())
    parts = [
        f"# Fingertips for {name}",
        "![before](before.png) ![after](after.png)",
        table(("dimension", "value", "meaning"), rows).rstrip(),
        table(("hand", "before", "after"), sizes).rstrip(),
        f"Chosen among {len(designed.table)} designs, of which {works} can be made, on "
        f"{len(designed.chosen_on)} objects: {', '.join(designed.chosen_on)}. The rates below are "
        "of other objects and drops, with 95 % intervals over objects.",
        *(_results(engine, card) for engine, card in designed.cards.items()),
        PRINTING + MOUNTING[designed.design.mount] + CHECKING,
    ]
    return "\n\n".join(parts) + "\n"


def _meaning(field: FieldInfo) -> str:
    """What a dimension is, without the unit that its setting has."""
    return (field.description or "").replace(", metres", "").replace(", degrees", "")


def _shown(key: str, value: float | str) -> str:
    """A dimension with its unit."""
    if isinstance(value, str):
        return value
    units = {"force": ("N", 1), "grip": ("%", 100), "angle": ("degrees", 1)}
    unit, scale = units.get(key.removeprefix("groove_"), ("mm", 1000))
    return f"{scale * value:.1f} {unit}"


def _results(engine: str, card: HandComparison) -> str:
    """Rates before and after in an engine, and the objects of large changes."""
    before, after = card.hands
    rows = []
    for who, words in GRASPERS.items():
        rates, gain = card.rates(who), card.compare(after, before, who)
        shown = (f"{100 * rates[hand].value:.0f} %" for hand in (before, after))
        low, high = (100 * end for end in gain.interval)
        rows.append((words, *shown, f"{100 * gain.difference:+.0f} ({low:+.0f} to {high:+.0f})"))
    old, new = (card.attempts(hand).groupby("label")["success"].mean() for hand in (before, after))
    gains, losses = (", ".join(old.index[way * (new - old) >= CHANGE]) or "none" for way in (1, -1))
    rates_of = table(("grasps", "before", "after", "difference, points"), rows)
    told = f"Best grasps gain by half or more at {gains}; they lose as much at {losses}."
    return f"## In {engine}\n\n{rates_of}\n{told}"
