"""Complexity and graspability of meshes, and how similar they are."""

from collections.abc import Sequence
from typing import NamedTuple

import trimesh

from egad._util.arrays import Floats
from egad._util.display import facts_html
from egad._util.parameters import SCALE_RULES, check_count
from egad._util.progress import phase_if_slow
from egad.errors import check_name
from egad.geometry import ENLARGED, ScaleWarning, check_units, size_text, warn_user
from egad.geometry.repair import dropped_text, repair_with_warning
from egad.grippers import SUCTION, Gripper, as_gripper
from egad.measures.graspability import grasped_size
from egad.measures.grid import Cell, cell_name, cell_of
from egad.measures.measure import measure_repeatably
from egad.measures.parameters import MAP_RULE, MAX_CANDIDATES, default_measures
from egad.measures.reeb import Similarity, extract
from egad.measures.reeb import similarity as matching

MAP_GRIPPER = "yumi"  # the cells of the map are for it
LARGE = 0.02  # graspability that is not written in thousandths
MEASURED_LARGER = (
    "the mesh is enlarged before it is measured, as in EGAD: {size}; "
    "rule='none' keeps its real size"
)


class Measures(NamedTuple):
    """Where an object lies in EGAD's space, and at which size it was measured.

    Attributes:
        complexity: Entropy of the angular deficits, bits, of the voxels whose surface is closest
            to the mesh: as for evolved objects, whatever its triangles.
        graspability: Percentile of the quality of its sampled grasps: high is easy to grasp.
        graspability_std: Its standard error.
        cell: Cell of the grid: (column by complexity, row by difficulty), from 0 = simplest and
            0 = easiest; None for a suction cup, which has no place on the map.
        label: Name of the cell, such as `M14`: row M in difficulty, column 14 in complexity.
        cell_confidence: Probability that the percentile of all grasps lies in the same row.
        raw_complexity: Complexity of the mesh's own triangles, as in the paper's table III.
        rule: The scale rule. The cells of the map are by `exact`.
        gripper: Name of the gripper; empty if it has none. The cells of the map are for `yumi`.
        opening: Widest opening of the gripper, metres.
        factor: The mesh was scaled by this before grasps were sampled.
        sides: Sides of its box then, ascending, metres.
        dropped_bodies: How many bodies of the mesh were left out: only the largest is measured.
        dropped_volume: Their fraction of the volume of all bodies, with holes closed.
    """

    complexity: float
    graspability: float
    graspability_std: float
    cell: Cell | None
    label: str
    cell_confidence: float
    raw_complexity: float
    rule: str
    gripper: str
    opening: float
    factor: float
    sides: tuple[float, float, float]
    dropped_bodies: int
    dropped_volume: float

    @property
    def comparable(self) -> bool:
        """Whether the mesh was measured by the same rule and opening as the objects of the map."""
        return self.rule == MAP_RULE and self.opening == as_gripper(MAP_GRIPPER).opening

    @property
    def _facts(self) -> dict[str, str]:
        """The measures, then the conditions under which they hold."""
        factor, unit = (1, "") if self.graspability > LARGE else (1000, " 1e-3")
        value, std = factor * self.graspability, factor * self.graspability_std
        hand = f"{self.gripper}, " if self.gripper else ""
        facts = {
            "complexity": f"{self.complexity:.3f} bit ({self.raw_complexity:.3f} by its triangles)",
            "graspability": f"{value:.3f} ± {std:.3f}{unit}",
            "cell confidence": f"{100 * self.cell_confidence:.0f} %",
            "grasped by": f"a gripper ({hand}opening {1000 * self.opening:g} mm)",
            "at": f"{size_text(self.sides, self.factor)} by the rule {self.rule}",
        }
        if self.cell is None:
            del facts["cell confidence"]
        if self.dropped_bodies:
            facts["left out:"] = dropped_text(self.dropped_bodies, self.dropped_volume)
        if not self.comparable:
            facts["not comparable with the map"] = f"({MAP_RULE}, {MAP_GRIPPER})"
        return facts

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {text}" for name, text in self._facts.items())
        return f"Measures({self.label or 'no cell'}: {facts})"

    def _repr_html_(self) -> str:
        return facts_html(self.label or "no cell", self._facts)


@phase_if_slow("measuring a mesh")
def measure(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str = MAP_GRIPPER,
    *,
    rule: str = MAP_RULE,
    max_candidates: int = MAX_CANDIDATES,
    seed: int = 0,
) -> Measures:
    """Complexity and graspability of a mesh.

    The mesh is repaired, then scaled by a rule. By default its smallest side becomes 80 % of the
    opening of the gripper, as for the objects of the map, so its size and unit do not matter beyond
    rounding, which may lead to other grasps. The same mesh and seed give the same values.

    Args:
        mesh: Any mesh: in metres, or in any unit for the rule `exact`.
        gripper: The gripper that grasps are sampled for, or its name. The default is `yumi`, the
            gripper of the published labels.
        rule: The size at which grasps are sampled, see `rescale`: `exact`, or `none` for the real
            size, or `paper`. The smallest side is that of the minimum-volume box; for `exact`, that
            of the box along the principal axes, as in EGAD's program. Only cells by `exact` are
            comparable with the map.
        max_candidates: The number of candidate grasps is doubled until the cell is certain, up to
            this number.
        seed: Seed of the grasps.

    Raises:
        RejectedError: The mesh cannot be repaired, is flat, or has no grasp.
        UserError: There is no gripper or rule of this name, or a number is not allowed.

    Warns:
        ScaleWarning: The mesh is measured larger than it is.
        DroppedBodiesWarning: It has several bodies; only the largest is measured.
        UnitsWarning: By another rule than `exact`, the size of the mesh suggests a unit other than
            the metre.

    Source: EGAD (Morrison, Corke and Leitner 2020), section III.
    """
    check_count("max_candidates", max_candidates)
    check_name("rule", rule, SCALE_RULES)
    if rule != MAP_RULE:
        check_units(mesh)
    repaired, hand = repair_with_warning(mesh), as_gripper(gripper)
    settings = default_measures(hand, seed)
    size = grasped_size(repaired.mesh, settings, rule)
    if size.factor > ENLARGED:
        warn_user(MEASURED_LARGER.format(size=size_text(size.sides, size.factor)), ScaleWarning)
    found = measure_repeatably(repaired.mesh, settings, max_candidates, size.factor)
    cup = hand.grasps_with == SUCTION
    cell = None if cup else cell_of(found.complexity, found.graspability, settings.space)
    first, second, third = map(float, size.sides)
    return Measures(
        complexity=found.complexity,
        graspability=found.graspability,
        graspability_std=found.graspability_std,
        cell=cell,
        label=cell_name(*cell) if cell else "",
        cell_confidence=found.cell_confidence,
        raw_complexity=found.raw_complexity,
        rule=rule,
        gripper=gripper if isinstance(gripper, str) else "",
        opening=hand.opening,
        factor=size.factor,
        sides=(first, second, third),
        dropped_bodies=repaired.dropped_bodies,
        dropped_volume=repaired.dropped_volume,
    )


def similarity(first: trimesh.Trimesh, second: trimesh.Trimesh) -> float:
    """Similarity of two shapes by their Reeb graphs: 1 for equal ones, 0 for nothing in common.

    Args:
        first: A mesh, in any unit.
        second: Another one.

    Raises:
        RejectedError: A mesh cannot be repaired or has no Reeb graph.

    Warns:
        DroppedBodiesWarning: A mesh has several bodies; only the largest is compared.

    Source: Hilaga et al., Topology Matching, SIGGRAPH 2001.
    """
    return float(similarity_matrix([first, second])[0, 1])


@phase_if_slow("comparing meshes")
def similarity_matrix(meshes: Sequence[trimesh.Trimesh]) -> Floats:
    """Similarities of all pairs of n shapes, (n, n): symmetric, with 1 on the diagonal.

    Args:
        meshes: The shapes, each in any unit.

    Raises:
        RejectedError: A mesh cannot be repaired or has no Reeb graph.

    Warns:
        DroppedBodiesWarning: A mesh has several bodies; only the largest is compared.
    """
    parameters = Similarity()
    graphs = [extract(repair_with_warning(mesh).mesh, parameters) for mesh in meshes]
    return matching.similarity_matrix(graphs, parameters.weight)
