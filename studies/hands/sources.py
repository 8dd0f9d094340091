"""Fingertips chosen on evolved objects, primitives or YCB, and judged on all of these.

    python studies/hands/sources.py OUT SO101_MJCF YCB_FOLDER [HAND ...]

YCB_FOLDER has the laser scans as NAME.ply. Each search and each judged hand is kept in OUT, and a
second call makes only those that are missing; `sources_page.py OUT` prints the page. What is
compared, and how, is in sources_plan.md.
"""

import sys
from collections.abc import Iterable
from pathlib import Path

import trimesh
from household import household_parts

import egad
from egad._util.parameters import from_file
from egad.bench.hands import HandParameters, HandTrials, compare_at
from egad.bench.tips import FingertipDesign, TipSearch
from egad.bench.tips.base import Base, base_of
from egad.bench.tips.checks import hand_with_tips
from egad.bench.tips.design import choose, write_prints
from egad.bench.tips.search import search_tips
from egad.bench.tips.solids import make_tips
from egad.errors import EgadError
from egad.geometry import box_sides, joined_primitives
from egad.grippers import GRIPPERS
from egad.objects import NamedMesh, named_meshes
from egad.random import entropy, generator
from egad_workflow.config_files import read_values

SIZE, THICKEST = egad.Gripper(opening=0.06), 0.048  # metres: `rescale` makes a side of 80 % of it
SOURCES, SEEDS, ENGINES = ("evolved", "primitives", "ycb"), range(3), ("mujoco", "pybullet")
JUDGED_AT = 8  # objects of each source
JUDGED = HandTrials(drops=2, search_drops=3, tries=2, naive=1)
HERE = Path(__file__).parent
Meshes = dict[str, trimesh.Trimesh]


def pools(ycb: Path) -> tuple[dict[str, list[NamedMesh]], dict[str, list[NamedMesh]]]:
    """Objects of each source to search on, and to judge on, in metres."""
    evaluation = {each.label: each.mesh for each in egad.load("evaluation-set")}
    made = {f"primitive {n}": _primitive(n) for n in range(50)}
    scans = {path.stem: path for path in sorted(ycb.glob("*.ply"))}
    found = {
        "evolved": _scaled(evaluation),
        "primitives": _scaled(made),
        "ycb": dict(_thin_enough(scans)),
    }
    search, judge = {}, {"household": named_meshes(household_parts())}
    for source, meshes in found.items():
        families: dict[str, list[str]] = {}
        for label in meshes:  # a family of YCB has one number, one of evolved objects a column
            family = {"evolved": label[1:2], "ycb": label[:3]}.get(source, label)
            families.setdefault(family, []).append(label)
        order = sorted(families, key=lambda each: entropy(0, "sources of tips", source, each))
        half = set(order[: len(order) // 2])
        parts: tuple[Meshes, Meshes] = ({}, {})
        for family, labels in families.items():
            parts[family not in half].update({label: meshes[label] for label in labels})
        search[source] = named_meshes(parts[0])
        judge[source] = _in_order(named_meshes(parts[1]), 0)[:JUDGED_AT]
    return search, judge


def _primitive(number: int) -> trimesh.Trimesh:
    return joined_primitives(generator(0, "primitives of tips", number), 0.1)


def _scaled(meshes: Meshes) -> Meshes:
    return {label: egad.rescale(mesh, SIZE, rule="paper")[0] for label, mesh in meshes.items()}


def _thin_enough(scans: dict[str, Path]) -> Iterable[tuple[str, trimesh.Trimesh]]:
    """The scans that egad can use, and of which a hand of 60 mm could hold the smallest side."""
    for label, path in scans.items():
        try:
            mesh = egad.read_mesh(path, units="m")
        except EgadError as error:
            print(f"{label} is left out: {error}", flush=True)
            continue
        if box_sides(mesh)[0] <= THICKEST:
            yield label, mesh


def _in_order(targets: list[NamedMesh], seed: int) -> list[NamedMesh]:
    """Objects in a random order."""
    return sorted(targets, key=lambda each: entropy(seed, "order of tips", each.label))


def designed(base: Base, name: str, seed: int, out: Path, pool: list[NamedMesh]) -> egad.Gripper:
    """The hand with the tips that one search chose."""
    settings = read_values(HERE / f"{name}_tips.yaml") | {"seed": seed}
    search = from_file(TipSearch, settings)
    targets = _in_order(pool, seed)[: search.objects]
    table = search_tips(base, search, targets, "none", out / "designs.parquet", 1)
    kept = out / "design.json"
    if not kept.exists():
        kept.write_text(choose(base, search, table, targets, "none", 1).model_dump_json())
    design = FingertipDesign.model_validate_json(kept.read_text())
    tips = make_tips(base, design)
    write_prints(tips, out, name)
    return hand_with_tips(base, design, tips, out)


def main(out: Path, so101: Path, ycb: Path, names: list[str]) -> None:
    """Search and judge what is not yet there."""
    search, judge = pools(ycb)
    targets = [each for group in judge.values() for each in group]
    hands = {
        "so101": egad.Gripper.from_file(so101, torque=0.76, pads="bare"),
        "panda": GRIPPERS["panda"],
    }
    for name in names or hands:
        base = base_of(name, hands[name])
        made = {"as-built": hands[name]}
        for seed in SEEDS:
            for source in SOURCES:
                folder = out / name / f"{source}-{seed}"
                made[f"{source}-{seed}"] = designed(base, name, seed, folder, search[source])
        for which, hand in made.items():
            for engine in ENGINES:
                path = out / name / engine / f"{which}.parquet"
                if not path.exists():
                    path.parent.mkdir(parents=True, exist_ok=True)
                    trials = JUDGED.model_copy(update={"engine": engine})
                    settings = HandParameters(seed=100, hands=trials)
                    card = compare_at({which: hand}, targets, None, settings, "none")
                    card.save(path)
                    print(name, engine, card, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
