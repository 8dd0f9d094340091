"""MAP-Elites over fingertips: the best ones for each opening and length, raced on objects.

Designs try the objects in batches. One that is behind the elite of its cell by more than chance is
dropped. The table is written after each generation, and a search resumes from it.
"""

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import Mapper, workers
from egad.bench.hands import HandParameters, try_hands
from egad.bench.tips.base import Base
from egad.bench.tips.checks import tip_problems
from egad.bench.tips.parameters import FingertipDesign, TipLimits, TipSearch
from egad.detectors import IN_SCENES
from egad.errors import UserError
from egad.grippers import Gripper, files_of
from egad.io import checksum
from egad.objects import NamedMesh
from egad.random import generator
from egad.tables import parquet
from egad.tables.columns import FLOAT, integer, real, schema, text, values
from egad.tables.hands import GRASPERS

Row = dict[str, Any]  # of `TIP_DESIGNS`
DETECTOR = "antipodal-depth"  # for the grasper `detector`
CELL = 0.01  # metres of opening and of length, of a cell of the archive
FRESH, STEP = 0.25, 0.2  # fraction of designs without a parent; of a range, of a mutation
BATCH = 4  # objects after which designs may be dropped
DOUBT = 2.0  # standard errors by which a design may be behind an elite
MAX_DRAWS = 20  # generations of draws, after which a space without a possible design is given up
TIP_DESIGNS = schema(
    integer("design", "number of the design"),
    text("dimensions", "its dimensions, JSON"),
    text("problems", "why it cannot be printed or does not work; empty if it can"),
    real("opening", "opening of the hand with it", "m"),
    real("force", "force between its pads", "N"),
    values("rates", "mean success rate of the graspers, object by object", of=FLOAT),
)


def search_tips(
    base: Base, search: TipSearch, targets: Sequence[NamedMesh], rule: str, path: Path, jobs: int
) -> pd.DataFrame:
    """All designs, rows of `TIP_DESIGNS`, resumed from a file; `UserError` if none can be made."""
    notes = {
        "search": search.model_dump(mode="json"),
        "hand": base.gripper.model_dump(mode="json", exclude={"file"}),
        "files": [checksum(file) for file in files_of(base.gripper)],
        "objects": {each.label: shape_digest(each) for each in targets},
        "rule": rule,
    }
    rows: list[Row] = []
    if path.exists():
        if parquet.notes(path) != notes:
            raise UserError(f"{path} is of other settings, hand or objects; give another folder")
        rows = parquet.records(parquet.read(path, TIP_DESIGNS))
    settings = HandParameters(seed=search.seed, hands=search.trials)
    with workers(jobs) as mapper:
        while (done := sum(not row["problems"] for row in rows)) < search.evaluations:
            parents = elites(rows, len(targets))
            count = min(search.generation, search.evaluations - done)
            with TemporaryDirectory() as scratch:
                checked = _next_designs(base, search, len(rows), parents, mapper, Path(scratch))
                able = [row for row, _ in checked if not row["problems"]][:count]
                hands = {row["design"]: hand for row, hand in checked if hand}
                rate = partial(rate_hands, rule=rule, settings=settings, mapper=mapper)
                _race(able, hands, parents, targets, rate)
            last = able[-1]["design"] if able else checked[-1][0]["design"]
            rows += [row for row, _ in checked if row["design"] <= last]
            parquet.write(pd.DataFrame(rows), TIP_DESIGNS, path, notes)
    return pd.DataFrame(rows)


def shape_digest(target: NamedMesh) -> str:
    """A digest of the triangles of an object."""
    return hashlib.sha256(target.mesh().triangles.tobytes()).hexdigest()[:16]


def elites(rows: Sequence[Row], objects: int) -> list[Row]:
    """The best design of each cell, best first, among those that tried all objects."""
    best: dict[tuple[int, int], Row] = {}
    for row in rows:
        if not row["problems"] and len(row["rates"]) == objects:
            cell = cell_of(row)
            if cell not in best or np.mean(row["rates"]) > np.mean(best[cell]["rates"]):
                best[cell] = row
    return sorted(best.values(), key=lambda row: -float(np.mean(row["rates"])))


def cell_of(row: Row) -> tuple[int, int]:
    """The cell of a design in the archive, by the opening of the hand and the length."""
    return int(row["opening"] / CELL), int(design_of(row).length / CELL)


def design_of(row: Row) -> FingertipDesign:
    """The design of a row."""
    return FingertipDesign.model_validate_json(row["dimensions"])


def draw_design(search: TipSearch, parents: Sequence[Row], number: int) -> FingertipDesign:
    """A design of the space: a mutated elite, or without parents, or at times, a random one."""
    rng = generator(search.seed, "fingertips", number)
    parent = None
    if parents and rng.random() >= FRESH:
        parent = design_of(parents[int(rng.integers(len(parents)))])
    drawn: dict[str, Any] = {}
    for name in FingertipDesign.model_fields:
        choice = search.tips.get(name)
        if not isinstance(choice, tuple):
            drawn |= {} if choice is None else {name: choice}
        elif isinstance(choice[0], str):
            kept = parent is not None and rng.random() >= FRESH
            drawn[name] = getattr(parent, name) if kept else choice[int(rng.integers(len(choice)))]
        else:
            low, high = float(choice[0]), float(choice[1])
            value = rng.uniform(low, high)
            if parent is not None:
                value = getattr(parent, name) + rng.normal(0.0, STEP * (high - low))
            drawn[name] = round(float(np.clip(value, low, high)), 5)
    return FingertipDesign.model_validate(drawn)


def _next_designs(
    base: Base, search: TipSearch, first: int, parents: Sequence[Row], mapper: Mapper, scratch: Path
) -> list[tuple[Row, Gripper | None]]:
    """Designs and hands, until a generation has no problems; UserError if none seems possible."""
    checked: list[tuple[Row, Gripper | None]] = []
    work = partial(_check, base=base, limits=search.limits, scratch=scratch)
    for start in range(first, first + MAX_DRAWS * search.generation, search.generation):
        numbers = range(start, start + search.generation)
        checked += mapper(work, [(n, draw_design(search, parents, n)) for n in numbers])
        if sum(not row["problems"] for row, _ in checked) >= search.generation:
            break
    if all(row["problems"] for row, _ in checked):
        problems = [row["problems"] for row, _ in checked]
        kinds = [re.sub(r"[\d.]+", "#", problem) for problem in problems]
        often = problems[kinds.index(Counter(kinds).most_common(1)[0][0])]
        raise UserError(f"none of {len(checked)} designs of this space works; most often, {often}")
    return checked


def _check(
    item: tuple[int, FingertipDesign], base: Base, limits: TipLimits, scratch: Path
) -> tuple[Row, Gripper | None]:
    """The row of a design, without rates, and the hand with it."""
    number, design = item
    hand, problems = tip_problems(base, design, limits, scratch / str(number))
    row = {
        "design": number,
        "dimensions": design.model_dump_json(),
        "problems": "; ".join(problems),
        "opening": hand.opening if hand else np.nan,
        "force": hand.force if hand else np.nan,
        "rates": [],
    }
    return row, hand


def _race(
    live: list[Row],
    hands: Mapping[int, Gripper],
    best: Sequence[Row],
    targets: Sequence[NamedMesh],
    rate: Callable[[Sequence[tuple[Gripper, NamedMesh]]], list[float]],
) -> None:
    """Add the rates at the objects; of designs that fall behind the elite of their cell, a few."""
    elite = {cell_of(row): row["rates"] for row in best}
    for start in range(0, len(targets), BATCH):
        some = targets[start : start + BATCH]
        pairs = [(hands[row["design"]], target) for row in live for target in some]
        found = np.reshape(rate(pairs), (-1, len(some)))
        for row, rates in zip(live, found.tolist(), strict=True):
            row["rates"] += rates
        live = [row for row in live if _may_win(row["rates"], elite.get(cell_of(row)))]


def _may_win(rates: Sequence[float], elite: Sequence[float] | None) -> bool:
    """Whether a design may still beat the elite of its cell: paired differences by object."""
    if elite is None:
        return True
    behind = np.asarray(elite)[: len(rates)] - rates
    error = float(behind.std(ddof=1)) / np.sqrt(len(rates)) if len(rates) > 1 else np.inf
    return bool(behind.mean() <= DOUBT * error)


def rate_hands(
    pairs: Sequence[tuple[Gripper, NamedMesh]], rule: str, settings: HandParameters, mapper: Mapper
) -> list[float]:
    """Mean success rate of the graspers, for pairs of a hand with jaws and an object."""
    work = partial(_rate, rule=rule, settings=settings)
    return list(progress(mapper(work, pairs), "trying tips", len(pairs)))


def _rate(pair: tuple[Gripper, NamedMesh], rule: str, settings: HandParameters) -> float:
    """Mean of the success rates of the graspers; 0 for an object that cannot be simulated."""
    hand, target = pair
    detectors = {hand.kind.name: IN_SCENES[DETECTOR]}
    table = try_hands(target, {"tips": hand}, detectors, rule, settings)
    counted = table[table["grasper"].isin(list(GRASPERS))]
    return float(counted.groupby("grasper")["success"].mean().mean()) if len(counted) else 0.0
