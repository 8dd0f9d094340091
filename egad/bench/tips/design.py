"""Design fingertips: search them on some objects, choose on fresh drops, judge on the others."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.workers import workers
from egad.bench.hands import HandComparison, HandParameters, compare_at
from egad.bench.tips.base import Base, base_of
from egad.bench.tips.checks import hand_with_tips, print_rotation
from egad.bench.tips.parameters import FingertipDesign, TipSearch
from egad.bench.tips.search import design_of, elites, rate_hands, search_tips
from egad.bench.tips.solids import Tip, make_tips
from egad.errors import UserError
from egad.evalset import PlacedMesh, in_grid, split_by_family, write_3mf
from egad.grippers import Gripper
from egad.io import write_stl_mm
from egad.objects import NamedMesh
from egad.random import entropy
from egad.sim import check_engine
from egad.tables import parquet

DESIGNS = "designs.parquet"
FINALISTS = 3  # elites that are tried again on fresh drops
PLATE, SPACE = 0.04, 0.008  # metres from the edge of the bed to the tips, and between them


class DesignedTips(NamedTuple):
    """Fingertips, the hand with them, and how both compare with the hand as it was."""

    design: FingertipDesign
    tips: tuple[Tip, Tip]
    hand: Gripper
    table: pd.DataFrame  # all designs: rows of `search.TIP_DESIGNS`
    chosen_on: list[str]  # labels of the objects of the search
    cards: dict[str, HandComparison]  # by engine: `NAME` and `NAME with tips`, on other objects


def design_tips(
    name: str,
    gripper: Gripper,
    search: TipSearch,
    targets: Sequence[NamedMesh],
    out: Path,
    *,
    rule: str = "paper",
    engines: Sequence[str] = ("mujoco",),
    jobs: int = 1,
) -> DesignedTips:
    """Fingertips for a hand, searched in simulation, and a folder with all files.

    Args:
        name: What the hand is called.
        gripper: A hand whose jaws slide, or one of which turns, from a file or as boxes.
        search: The space of designs, limits, and size of the search.
        targets: Objects; whole columns of the map of an evaluation set are held out.
        out: Folder for hand.urdf, hand.xml, the tips as STL and 3MF in the pose to print, and all
            designs. A search that was interrupted resumes from it.
        rule: How objects are scaled to the sizes of the trials.
        engines: Physics engines that the tips are judged in; the search uses that of its trials.
        jobs: Processes; results do not depend on them.

    Raises:
        UserError: The hand has no jaws to mount tips on, no design of the space can be made, or
            there are too few objects.
    """
    for engine in engines:
        check_engine(engine)
    base = base_of(name, gripper)
    chosen, others = split_targets(targets, search)
    if not chosen or not others:
        raise UserError(f"{len(targets)} objects are too few to search on some and judge on others")
    table = search_tips(base, search, chosen, rule, out / DESIGNS, jobs)
    design = choose(base, search, table, chosen, rule, jobs)
    tips = make_tips(base, design)
    hand = hand_with_tips(base, design, tips, out)
    write_prints(tips, out, name)
    cards = {}
    for engine in engines:
        trials = search.judged.model_copy(update={"engine": engine})
        judged = HandParameters(seed=_seed(search, "judge"), hands=trials)
        both = {name: gripper, f"{name} with tips": hand}
        cards[engine] = compare_at(both, others, None, judged, rule, jobs)
    return DesignedTips(design, tips, hand, table, [each.label for each in chosen], cards)


def choose(
    base: Base,
    search: TipSearch,
    table: pd.DataFrame,
    targets: Sequence[NamedMesh],
    rule: str,
    jobs: int,
) -> FingertipDesign:
    """The best of the first elites on fresh drops."""
    best = elites(parquet.records(table), len(targets))[:FINALISTS]
    designs = [design_of(row) for row in best]
    settings = HandParameters(seed=_seed(search, "choose"), hands=search.trials)
    with TemporaryDirectory() as scratch, workers(jobs) as mapper:
        folders = [Path(scratch) / str(row["design"]) for row in best]
        made = zip(designs, folders, strict=True)
        hands = [hand_with_tips(base, each, make_tips(base, each), folder) for each, folder in made]
        pairs = [(hand, target) for hand in hands for target in targets]
        rates = np.reshape(rate_hands(pairs, rule, settings, mapper), (len(hands), -1))
    return designs[int(rates.mean(axis=1).argmax())]


def split_targets(
    targets: Sequence[NamedMesh], search: TipSearch
) -> tuple[list[NamedMesh], list[NamedMesh]]:
    """Objects to search on, in random order, and objects to judge on, which share no column."""
    grid = in_grid({each.label for each in targets})
    family = {each.label: each.label[1:2] if grid else each.label for each in targets}
    split = split_by_family(family, (), search.held_out, search.seed)
    chosen = [each for each in targets if split[each.label] == "train"]
    chosen.sort(key=lambda each: entropy(search.seed, "objects of fingertips", each.label))
    return chosen[: search.objects], [each for each in targets if split[each.label] != "train"]


def write_prints(tips: Sequence[Tip], out: Path, name: str) -> None:
    """Write both tips as STL, and together as a 3MF plate, in the pose to print."""
    placed, left = {}, PLATE
    for word, tip in zip(("first", "second"), tips, strict=True):
        vertices = np.asarray(tip.mesh.vertices) @ print_rotation(tip.mesh, tip.pose).T
        mesh = trimesh.Trimesh(vertices - vertices.min(axis=0), tip.mesh.faces, process=False)
        write_stl_mm(mesh, out / f"{word}_tip.stl")
        placed[f"{word} tip"] = PlacedMesh(mesh, np.array([left, PLATE, 0.0]))
        left += float(mesh.extents[0]) + SPACE
    write_3mf(placed, out / "tips.3mf", {"Title": f"Fingertips for {name}"})


def _seed(search: TipSearch, purpose: str) -> int:
    """A seed of drops that no other step has seen."""
    return entropy(search.seed, f"fingertips: {purpose}") % 2**32
