"""The functions of `import egad` that take a mesh: measure, compare, scale, grasp, decompose."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import trimesh
from numpy.typing import ArrayLike

from egad._util.arguments import check_array, check_number
from egad._util.arrays import Floats
from egad._util.display import facts_html
from egad._util.files import as_path
from egad._util.parameters import (
    MAX_SIDE_FRACTION,
    SCALE_RULES,
    check_count,
    from_arguments,
)
from egad._util.progress import phase_if_slow
from egad.errors import check_name
from egad.evalset import Bundle, make_parts, measure_parts, warn_if_beyond
from egad.geometry import (
    DEVIATION,
    ENLARGED,
    MAX_PARTS,
    MAX_VERTICES,
    SIDE_FRACTION,
    VOLUME_ERROR,
    DroppedBodiesWarning,
    ScaleWarning,
    check_units,
    mass_properties,
    scaling,
    size_text,
    warn_user,
    wind_outwards,
)
from egad.geometry import stable_poses as resting
from egad.geometry.repair import Repaired, dropped_text
from egad.geometry.repair import repair as repair_mesh
from egad.grasps import (
    APPROACH_ANGLES,
    CONE,
    FRICTION,
    Grasps,
    LabelParameters,
    label_grasps,
    label_parameters,
)
from egad.grippers import Gripper, as_gripper, hand_body
from egad.io import read_mesh as read_any_mesh
from egad.measures import (
    MAP_RULE,
    MAX_CANDIDATES,
    Cell,
    CoarseMeshWarning,
    cell_name,
    cell_of,
    center_of_mass,
    coarse_advice,
    default_measures,
    grasped_size,
    is_coarse,
    measure_repeatably,
)
from egad.random import generator
from egad.reeb import Similarity
from egad.reeb import graph as reeb
from egad.reeb import similarity as matching

MAP_GRIPPER = "yumi"  # the cells of the map are for it
MEASURED_LARGER = (
    "the mesh is measured larger than it is, as EGAD does: {size}; rule='none' measures it as it is"
)


def read_mesh(path: str | Path, units: str | None = None) -> trimesh.Trimesh:
    """Read a mesh file as one mesh in metres: obj, stl, ply, off, glb or 3mf.

    Polygons become triangles that lie within them. All objects, groups and nodes become one mesh,
    where the file puts them; vertices at the same place are merged. Colors, materials and normals
    are left out. glTF files have y up: they are turned to have z up. `docs/guides/own-meshes.md`
    lists what is read of each format.

    Args:
        path: The file.
        units: Unit of its coordinates: `m`, `cm`, `mm` or `inch`. It may be left out if the file
            states it (3mf, or a comment such as `unit: mm`), or the format does (glb: metres).

    Raises:
        RejectedError: The file is damaged, is not a mesh, has no faces, or has a feature that is
            not read, such as a free-form surface or a compressed mesh; the message names it. Or it
            states another unit than the one given, or neither gives one.
        UserError: The unit is unknown, or the path is no path.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit.
    """
    file = as_path("path", path)
    mesh = read_any_mesh(file, units)
    check_units(mesh, f"the mesh {file.name}", units or "the unit of the file")
    return mesh


class Measures(NamedTuple):
    """Where an object lies in EGAD's space, and at which size it was measured.

    Attributes:
        complexity: Entropy of the angular deficits of its vertices, bits.
        graspability: Percentile of the quality of its sampled grasps: high is easy to grasp.
        graspability_std: Its standard error.
        cell: Cell of the grid: (column by complexity, row by difficulty), from 0 = simplest and
            0 = easiest.
        label: Name of the cell, such as `M14`: row M in difficulty, column 14 in complexity.
        cell_confidence: Probability that the percentile of all grasps lies in the same cell.
        fine_complexity: Complexity after long edges are split, bits. If it differs from the
            complexity by more than a cell, the triangles are too large for either to mean much.
        rule: The scale rule. The cells of the map are by `exact`.
        gripper: Name of the gripper; empty if it has none. The cells of the map are for `yumi`.
        opening: Widest opening of the gripper, metres.
        factor: The mesh was scaled by this before grasps were sampled.
        sides: Sides of its box then, ascending, metres.
        dropped_bodies: How many bodies of the mesh were left out: only the largest is measured.
        dropped_volume: Their part of the volume of all bodies, with holes closed.
    """

    complexity: float
    graspability: float
    graspability_std: float
    cell: Cell
    label: str
    cell_confidence: float
    fine_complexity: float
    rule: str
    gripper: str
    opening: float
    factor: float
    sides: tuple[float, float, float]
    dropped_bodies: int
    dropped_volume: float

    @property
    def comparable(self) -> bool:
        """Whether the mesh was measured as the objects of the map, by the same rule and opening."""
        return self.rule == MAP_RULE and self.opening == as_gripper(MAP_GRIPPER).opening

    @property
    def _graspability_text(self) -> str:
        value, std = 1000 * self.graspability, 1000 * self.graspability_std
        return f"{value:.3f} ± {std:.3f} 1e-3"

    def __repr__(self) -> str:
        """The measures, then what they hold for."""
        hand = f"{self.gripper}, " if self.gripper else ""
        parts = [
            f"{self.label}: complexity {self.complexity:.3f} bit",
            f"graspability {self._graspability_text}",
            f"cell confidence {100 * self.cell_confidence:.0f} %",
            f"grasped by a gripper ({hand}opening {1000 * self.opening:g} mm)",
            f"at {size_text(self.sides, self.factor)} by the rule {self.rule}",
        ]
        if is_coarse(self.complexity, self.fine_complexity):
            parts.append(f"too coarse: {self.fine_complexity:.3f} bit after long edges are split")
        if self.dropped_bodies:
            parts.append(dropped_text(self.dropped_bodies, self.dropped_volume))
        if not self.comparable:
            parts.append(f"not comparable with the map ({MAP_RULE}, {MAP_GRIPPER})")
        return f"Measures({', '.join(parts)})"

    def _repr_html_(self) -> str:
        """The measures as a table, for notebooks."""
        hand = f"{self.gripper}, " if self.gripper else ""
        facts = {
            "complexity": f"{self.complexity:.3f} bit",
            "graspability": self._graspability_text,
            "cell confidence": f"{100 * self.cell_confidence:.0f} %",
            "gripper": f"{hand}opening {1000 * self.opening:g} mm",
            "measured": f"at {size_text(self.sides, self.factor)} by the rule {self.rule}",
        }
        if is_coarse(self.complexity, self.fine_complexity):
            facts["too coarse"] = f"{self.fine_complexity:.3f} bit after long edges are split"
        if self.dropped_bodies:
            facts["left out"] = dropped_text(self.dropped_bodies, self.dropped_volume)
        if not self.comparable:
            facts["not comparable"] = f"the map is for {MAP_RULE}, {MAP_GRIPPER}"
        return facts_html(self.label, facts)


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
        gripper: The gripper that grasps are sampled for, or its name. The default is `yumi`, as
            the published labels are for it.
        rule: At which size grasps are sampled, see `rescale`: `exact`, or `none` for the real size,
            or `paper`. The smallest side is that of the minimum-volume box, for `exact` that of the
            box along the principal axes, as in EGAD's program. Only cells by `exact` are comparable
            with the map.
        max_candidates: Candidate grasps are doubled until the cell is certain, at most to this
            number.
        seed: Seed of the grasps.

    Raises:
        RejectedError: The mesh cannot be repaired, is flat, or has no grasp.
        UserError: There is no gripper or rule of this name, or a number is not allowed.

    Warns:
        ScaleWarning: The mesh is measured larger than it is.
        DroppedBodiesWarning: It has several bodies; only the largest is measured.
        CoarseMeshWarning: Its triangles are so large that its complexity means little.
        UnitsWarning: By another rule than `exact`, the size of the mesh suggests another unit than
            the metre.

    Source: EGAD (Morrison, Corke and Leitner 2020), section III.
    """
    check_count("max_candidates", max_candidates)
    check_name("rule", rule, SCALE_RULES)
    if rule != MAP_RULE:
        check_units(mesh)
    repaired, hand = _repaired(mesh), as_gripper(gripper)
    settings = default_measures(hand, seed)
    size = grasped_size(repaired.mesh, settings, rule)
    if size.factor > ENLARGED:
        warn_user(MEASURED_LARGER.format(size=size_text(size.sides, size.factor)), ScaleWarning)
    found = measure_repeatably(repaired.mesh, settings, max_candidates, size.factor)
    if is_coarse(found.complexity, found.fine_complexity):
        warn_user(coarse_advice(found.fine_complexity), CoarseMeshWarning)
    cell = cell_of(found.complexity, found.graspability, settings.space)
    first, second, third = map(float, size.sides)
    return Measures(
        complexity=found.complexity,
        graspability=found.graspability,
        graspability_std=found.graspability_std,
        cell=cell,
        label=cell_name(*cell),
        cell_confidence=found.cell_confidence,
        fine_complexity=found.fine_complexity,
        rule=rule,
        gripper=gripper if isinstance(gripper, str) else "",
        opening=hand.opening,
        factor=size.factor,
        sides=(first, second, third),
        dropped_bodies=repaired.dropped_bodies,
        dropped_volume=repaired.dropped_volume,
    )


def _repaired(mesh: trimesh.Trimesh) -> Repaired:
    """The repaired mesh, with a warning if bodies were left out."""
    repaired = repair_mesh(mesh)
    if repaired.dropped:
        warn_user(f"only the largest body is used: {repaired.dropped}", DroppedBodiesWarning)
    return repaired


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
    graphs = [reeb.extract(_repaired(mesh).mesh, parameters) for mesh in meshes]
    return matching.similarity_matrix(graphs, parameters.weight)


def rescale(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    rule: str = "paper",
    *,
    side_fraction: float = SIDE_FRACTION,
) -> tuple[trimesh.Trimesh, float]:
    """Scale an object about the origin of its coordinates to fit a gripper.

    Coordinates in single precision, such as those of the released objects, are rounded to it again.

    Args:
        mesh: Metres; not changed.
        gripper: The gripper, or its name.
        rule: `paper`: the smallest side of the minimum-volume box becomes at most the fraction of
            the opening, smaller objects stay as they are. `egad-script`: the longest side becomes
            the opening, then as `paper`. `exact`: the smallest side becomes the fraction. `none`:
            the object stays as it is.
        side_fraction: Part of the opening that the rule aims at.

    Returns:
        The scaled mesh, and the factor.

    Raises:
        RejectedError: The mesh is flat.
        UserError: There is no such gripper or rule, or the fraction is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit than the metre.
    """
    check_units(mesh)
    fraction = check_number("side_fraction", side_fraction, above=0, most=MAX_SIDE_FRACTION)
    scaled, row = scaling.rescale(mesh, rule, as_gripper(gripper).opening, fraction)
    return scaled, row["factor"]


@phase_if_slow("sampling grasps")
def sample_grasps(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    n: int = 500,
    *,
    seed: int = 0,
    friction: float = FRICTION,
    cone: float = CONE,
    approach_angles: int = APPROACH_ANGLES,
    center_of_mass: ArrayLike | None = None,
) -> Grasps:
    """Sample antipodal grasps of a mesh, with their quality and collisions of the hand.

    Args:
        mesh: A closed mesh in metres, as it is grasped: see `rescale`.
        gripper: The gripper, or its name.
        n: The largest number of grasps. Fewer are returned if no more are found that are at least
            2.5 mm apart.
        seed: The same mesh and seed give the same grasps.
        friction: Coulomb friction coefficient that the quality is computed with.
        cone: Tangent of the widest angle between the closing axis and the normals of a sampled
            grasp. Grasps outside the friction cone slip: their quality is 0.
        approach_angles: Directions around the closing axis from which the hand is tested for
            collisions, evenly spaced.
        center_of_mass: (3,) metres; by default that of a solid of uniform density.

    Returns:
        At least one grasp, in the frame of the mesh.

    Raises:
        RejectedError: The mesh is open, or there is no grasp; the text says what became of the
            candidates.
        UserError: There is no gripper of this name, or a number is not allowed.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit than the metre.

    Source: Mahler et al., Dex-Net 2.0, RSS 2017 (sampling); Ferrari and Canny, ICRA 1992 (quality).
    """
    check_units(mesh)
    hand = as_gripper(gripper)
    parameters = label_parameters(
        hand,
        check_count("n", n),
        seed,
        friction=friction,
        cone=cone,
        approach_angles=approach_angles,
    )
    com = _center(mesh, center_of_mass)
    rng = generator(parameters.seed, "sample_grasps")
    return Grasps(label_grasps(mesh, com, parameters, rng, hand_body(hand)))


def dataset_grasps(
    mesh: trimesh.Trimesh, object_id: str, parameters: LabelParameters
) -> pd.DataFrame:
    """The labelled grasps of a scaled object, the same as in a dataset of the pipeline.

    Args:
        mesh: A closed mesh in metres.
        object_id: Id of the object; with the seed it decides the grasps.
        parameters: The gripper, the seed, how many grasps, and how to rate them.

    Returns:
        Columns of `tables.grasping.GRASPS` without `id` and `label`.

    Raises:
        RejectedError: The mesh is open, or there is no grasp.
    """
    rng = generator(parameters.seed, "grasps", object_id)
    body = hand_body(parameters.gripper)
    return label_grasps(mesh, center_of_mass(mesh), parameters, rng, body)


@phase_if_slow("decomposing a mesh into convex parts")
def convex_parts(
    mesh: trimesh.Trimesh,
    *,
    max_parts: int = MAX_PARTS,
    volume_error: float = VOLUME_ERROR,
    deviation: float = DEVIATION,
    max_vertices: int = MAX_VERTICES,
) -> list[trimesh.Trimesh]:
    """Convex meshes that together approximate a solid, for physics engines.

    Args:
        mesh: A closed surface, metres.
        max_parts: The largest number of parts. If it is not enough, volume error and deviation grow
            by the same factor until it is.
        volume_error: The parts may exceed the solid by this fraction of its volume.
        deviation: About 99 % of the surface that fingers can touch lies no deeper in a part,
            metres.
        max_vertices: The largest number of vertices of a part.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
        UserError: A number is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit than the metre.
        PartsWarning: `max_parts` is not enough; the text has the bounds that the parts keep.
    """
    check_units(mesh)
    wanted = from_arguments(
        Bundle,
        max_parts=max_parts,
        volume_error=volume_error,
        deviation=deviation,
        max_vertices=max_vertices,
    )
    solid = wind_outwards(mesh)
    found = make_parts(solid, wanted)
    if found.deviation > wanted.deviation:
        errors = measure_parts(solid, found.parts, wanted)
        warn_if_beyond("the mesh", False, errors.volume_error, found.deviation)
    return found.parts


def stable_poses(
    mesh: trimesh.Trimesh, center_of_mass: ArrayLike | None = None
) -> list[resting.StablePose]:
    """The poses in which a solid can rest on a table, the most probable first.

    Args:
        mesh: A closed surface, in any unit; any surface if the center of mass is given, as only
            its convex hull counts then.
        center_of_mass: (3,) in the unit of the mesh; by default that of a solid of uniform density.

    Returns:
        At least one pose, with probabilities that add up to 1. `pose.matrix` is the (4, 4)
        transform from the frame of the mesh to that of the table: z points up, the table is at
        z = 0, and the center of mass is above the origin.

    Raises:
        RejectedError: The mesh is flat, or the center of mass is not inside its hull. Or the
            center of mass is not given, and the mesh is open or inside out.
        UserError: It is not a mesh, or the center of mass is not 3 finite numbers.

    Source: after Goldberg et al., Part pose statistics, 1999.
    """
    return resting.stable_poses(mesh, _center(mesh, center_of_mass))


def _center(mesh: trimesh.Trimesh, given: ArrayLike | None) -> Floats:
    """The center of mass that is given, or that of the solid."""
    if given is None:
        return mass_properties(mesh, 1.0).com
    return check_array("center_of_mass", given, (3,), "3 finite numbers")
