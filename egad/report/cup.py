"""A page about a suction cup: the loads that it holds, and its shape in 3D."""

import numpy as np
import trimesh
import yaml

from egad.grasps.suction import limits, ring_vertices
from egad.grippers import Gripper, SuctionCup
from egad.report.hand_shape import Colored, hand_shapes, painted
from egad.report.page import render_template
from egad.report.viewer import GraspScene, viewer_data
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

SPRING = 4e-4  # metres, radius of the bar that shows a spring
KINDS = {"perimeter": 1, "flexion": 2, "cone": 3}  # springs and their colors in scene3d.js
GRAM = 9.81e-3  # newtons


def cup_facts(cup: SuctionCup) -> dict[str, str]:
    """The properties of a cup and the loads that it holds, in words."""
    most = limits(cup)
    return {
        "ring": f"{2000 * cup.radius:.3g} mm across, {cup.sides} vertices",
        "height": f"{1000 * cup.height:.3g} mm from the ring to the apex",
        "seals if": f"no spring changes its length by {100 * cup.max_strain:.3g} % or more, and "
        "there is no hole inside the ring",
        "pull along the axis": f"{most.pull:.3g} N ({most.pull / GRAM / 1000:.3g} kg)",
        "force across the axis": f"{most.across:.3g} N with no other load",
        "torsion": f"{most.torsion:.3g} N m with no other load",
        "bending": f"{most.bending:.3g} N m: holds 100 g up to "
        f"{1000 * most.bending / (100 * GRAM):.3g} mm beside the axis",
        "stem": f"{2000 * cup.stem_radius:.3g} mm across, {1000 * cup.stem_length:.3g} mm long",
    }


def cup_entry(name: str, gripper: Gripper) -> str:
    """The entry of a configuration for a gripper with a cup, as YAML."""
    entry = gripper.model_dump(mode="json", include={"cup", "opening"})
    if gripper.sampler:
        entry["sampler"] = gripper.sampler
    return yaml.safe_dump({"grippers": {name: entry}}, sort_keys=False)


def cup_page(name: str, gripper: Gripper, cup: SuctionCup) -> str:
    """An HTML page about a gripper with a cup that needs no other file."""
    scenes = [
        _scene("cup and stem", hand_shapes(gripper, 0.0)),
        _scene("springs", spring_shapes(cup)),
    ]
    return render_template(
        "cup.html.j2",
        name=name,
        facts=cup_facts(cup),
        entry=cup_entry(name, gripper),
        viewer=viewer_data(scenes, gripper),
    )


def spring_shapes(cup: SuctionCup) -> list[Colored]:
    """A bar for each spring of a cup on a flat surface, with colors."""
    ring = np.pad(ring_vertices(cup), ((0, 0), (0, 1)))
    apex = np.tile([0.0, 0.0, -cup.height], (cup.sides, 1))
    ends = {
        "perimeter": np.roll(ring, -1, axis=0),
        "flexion": np.roll(ring, -2, axis=0),
        "cone": apex,
    }
    return [
        (trimesh.creation.cylinder(SPRING, segment=[start, end], sections=8), KINDS[kind])
        for kind, others in ends.items()
        for start, end in zip(ring, others, strict=True)
    ]


def _scene(name: str, shapes: list[Colored]) -> GraspScene:
    mesh, paint = painted(shapes)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi, (1, 0, 0)))
    return GraspScene(name, "", mesh, empty(GRASPS), paint=paint)
