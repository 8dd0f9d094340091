"""Pages about a hand from a file, what was found in it and its shape in 3D, and about a cup."""

from pathlib import Path
from textwrap import indent

import numpy as np
import trimesh
import yaml
from numpy.typing import ArrayLike

from egad._util.arrays import Floats
from egad.grasps.suction import limits, ring_vertices
from egad.grippers import Gripper, HandModel, SuctionCup
from egad.report.hand_shape import LINK_COLORS, Colored, colored, hand_shapes, painted
from egad.report.page import render_template
from egad.report.viewer import GraspScene, viewer_data
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

PAD_COLOR, APPROACH_COLOR = 3, 4  # numbers of the colors in scene3d.js
PAD_THICKNESS = 4e-4  # metres, of the plate that shows a pad
ARROW = (0.03, 0.001)  # metres: length and radius of the bar that shows the approach
UNEVEN = 0.1  # of the faces of pads: with less behind their foremost points they are flat
OPEN = 5e-4  # metres: with nothing further than this behind, what is uneven in pads are holes
# What is doubtful: pads that stay this part of the opening apart, an opening below this, pads that
# end this far before the fingertips, all in mm, and a tilt of axes, degrees
MAX_CLOSED, MIN_WIDE, MAX_BEHIND, MAX_OFF = 0.25, 5.0, 25.0, 2.0
# Also pads smaller than this, and this part of them that far back, in mm
MIN_PAD, MAX_SHARE, MAX_RECESS = 2.0, 0.5, 5.0
JAW_ROWS = 9  # of the table of a hand with one moving jaw
CHOICES = ("joint", "finger_links", "pad_links", "tcp", "closing_axis", "approach_axis")


def hand_facts(gripper: Gripper, model: HandModel) -> dict[str, str]:
    """What was found in the file of a hand, in words, with lengths in millimetres."""
    names = {side: _links(model, side) for side in LINK_COLORS}
    driven, followers = model.joints[: model.n_driven], model.joints[model.n_driven :]
    ends = model.positions[[0, -1]].T
    bow = 1000 * float(np.ptp(model.reach))
    jaw = {} if model.lever is None else _jaw_facts(gripper, model)
    pad = 1000 * np.ptp(model.pad, axis=0)
    frame = model.palm_to_hand
    boxes = [gripper.finger_length, gripper.finger_width, gripper.finger_thickness]
    return {
        "palm": names[0],
        "fingers": f"{names[-1]}; {names[1]}",
        "driven joint": "; ".join(
            f"{name}, {closed:.4g} closed, {wide:.4g} open"
            for name, (closed, wide) in zip(driven, ends, strict=False)
        ),
        "joints that follow": ", ".join(followers) or "none",
        "opening": f"{_mm(model.openings[[0, -1]], ' to ')} mm{_recess(model)}",
        "pads": f"{_mm(pad[1:] / 1000, ' x ')} mm, {1000 * (gripper.fingertip or 0):.1f} mm from "
        "their middle to the fingertips",
        "travel of the pads along the approach": f"{bow:.1f} mm" if bow > 0.01 else "none",
        "middle of the closed pads": f"{_mm(frame[:3, 3], ', ')} mm in the frame of the palm",
        **jaw,
        "closing axis": _axis(frame[:3, 0]),
        "approach axis": _axis(frame[:3, 2]),
        "convex parts": str(sum(len(link.shapes) for link in model.links)),
        "boxes, where boxes will do": f"fingers {_mm(boxes, ' x ')} mm, palm "
        f"{_mm(gripper.palm, ' x ')} mm",
        **{f"doubtful ({n})": text for n, text in enumerate(hand_doubts(gripper, model), 1)},
    }


def _recess(model: HandModel) -> str:
    """Between which points the opening is, if the pads are not flat."""
    share, depth = model.recess
    if share < UNEVEN:
        return ""
    begin = f" between the foremost points of the pads; {100 * share:.0f} % of their faces"
    if depth < OPEN:
        return f"{begin} is open"
    return f"{begin} lie further back, the rearmost {1000 * depth:.1f} mm farther apart"


def hand_doubts(gripper: Gripper, model: HandModel) -> list[str]:
    """Why what was found in the file of a hand may be wrong, in sentences."""
    closed, wide = 1000 * model.openings[[0, -1]]
    behind = 1000 * ((gripper.fingertip or 0.0) - float(np.ptp(model.pad[:, 2])) / 2)
    small = 1000 * float(np.ptp(model.pad, axis=0)[1:].min())
    share, depth = model.recess
    degrees = model.joint_kind == "revolute" and Path(gripper.file or "").suffix != ".urdf"
    limits = 'without angle="radian", angles in MJCF are degrees' if degrees else "check its limits"
    doubts = [
        (
            closed > MAX_CLOSED * wide,
            f"The closed pads are still {closed:.1f} mm apart: check the limits of the joint, and "
            "pad_links.",
        ),
        (wide < MIN_WIDE, f"The hand opens only {wide:.1f} mm: {limits}."),
        (
            behind > MAX_BEHIND,
            f"The pads end {behind:.0f} mm before the fingertips: check pad_links or tcp.",
        ),
        (
            small < MIN_PAD,
            f"The pads measure only {small:.1f} mm in one direction: check pad_links and the axes.",
        ),
        (
            share > MAX_SHARE and 1000 * depth > MAX_RECESS,
            "Most of the faces of the pads lie far behind their foremost points: check pad_links "
            "and closing_axis.",
        ),
    ]
    for column, words, key in (
        (0, "closing axis", "closing_axis"),
        (2, "approach", "approach_axis"),
    ):
        off = np.degrees(np.arccos(min(np.abs(model.palm_to_hand[:3, column]).max(), 1.0)))
        doubtful = getattr(gripper, key) is None and off > MAX_OFF
        said = f"The {words} is {off:.0f} degrees off the axes of the palm: check {key}."
        doubts.append((bool(doubtful), said))
    return [text for doubtful, text in doubts if doubtful]


def _jaw_facts(gripper: Gripper, model: HandModel) -> dict[str, str]:
    """Facts specific to a hand with one moving jaw."""
    lever, low, high = model.lever or 1.0, *np.degrees(model.angles[[0, -1]])
    unit, slides = ("N m", False) if model.joint_kind == "revolute" else ("N", True)
    angle = f"{low:.1f} to {high:.1f} degrees"
    if not slides and model.angles.min() < 0 < model.angles.max():
        parallel = float(np.interp(0.0, model.angles, model.openings))
        angle += f", parallel at {1000 * parallel:.1f} mm"
    return {
        "moving jaw": "the second finger; the first one is fixed, and is placed first",
        "angle between the jaws": "none" if slides and not np.any(model.angles) else angle,
        "friction that holds a round body": f"{np.tan(np.abs(model.angles).max() / 2):.2f} when "
        "wide open",
        "depths of the table": f"{_mm(model.depths, ', ')} mm beyond the pads, along the approach",
        "strength of the joint": f"{gripper.force * lever:.3g} {unit} for {gripper.force:g} N at "
        "the pads",
    }


def jaw_table(model: HandModel) -> list[dict[str, str]]:
    """Openings of a hand with one moving jaw (`gaps` in mm); empty for other hands."""
    if model.lever is None:
        return []
    turns = model.joint_kind == "revolute"
    rows = []
    for number in np.linspace(0, len(model.openings) - 1, JAW_ROWS).round().astype(int):
        joint, angle = float(model.positions[number, 0]), float(model.angles[number])
        rows.append(
            {
                "joint": f"{np.degrees(joint):.1f} deg" if turns else f"{1000 * joint:.1f} mm",
                "opening": f"{1000 * model.openings[number]:.1f} mm",
                "angle": f"{np.degrees(angle) + 0.0:.1f} deg",
                "friction": f"{np.tan(abs(angle) / 2):.2f}",
                "gaps": ", ".join(
                    "-" if np.isnan(gap) else f"{1000 * gap:.0f}" for gap in model.gaps[number]
                ),
            }
        )
    return rows


def hand_entry(name: str, gripper: Gripper, model: HandModel) -> str:
    """The entry of a configuration for a gripper with a file, as YAML; a comment if doubtful."""
    strength = "force" if gripper.torque is None else "torque"
    settings = gripper.model_dump(mode="json", include={"file", *CHOICES, strength})
    settings |= gripper.model_dump(mode="json", include={"pads", "friction"}, exclude_defaults=True)
    entry = {key: value for key, value in settings.items() if value is not None}
    text: str = yaml.safe_dump({"grippers": {name: entry}}, sort_keys=False)
    if not hand_doubts(gripper, model):
        return text
    return indent(f"Doubtful, as said above: check it, then remove these marks.\n{text}", "# ")


def hand_page(name: str, gripper: Gripper, model: HandModel) -> str:
    """An HTML page about a hand that needs no other file."""
    openings = model.openings[[-1, len(model.openings) // 2, 0]]
    words = ("open", "half open", "closed")
    scenes = [hand_scene(model, *each) for each in zip(words, map(float, openings), strict=True)]
    return render_template(
        "hand.html.j2",
        name=name,
        facts=hand_facts(gripper, model),
        jaw=jaw_table(model),
        entry=hand_entry(name, gripper, model),
        viewer=viewer_data(scenes, gripper),
    )


def hand_scene(model: HandModel, word: str, opening: float) -> GraspScene:
    """A hand at an opening (m) for the viewer, with its pads; it points down, a fixed jaw stays."""
    middle = model.middle_at(np.array(opening))
    pads = [(pad, PAD_COLOR) for pad in _pads(model, opening, middle)]
    links, arrow = colored(model.shapes(opening)), (_arrow(middle), APPROACH_COLOR)
    mesh, paint = painted([*links, *pads, arrow])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi, (1, 0, 0)))
    title = f"{1000 * opening:.1f} mm between the pads"
    return GraspScene(word, title, mesh, empty(GRASPS), paint=paint)


def _pads(model: HandModel, opening: float, middle: Floats) -> list[trimesh.Trimesh]:
    """Thin plates where the pads are; the plate of a jaw that turns tilts with it."""
    low, high = model.pad
    size = np.array([PAD_THICKNESS, *(high - low)[1:]])
    place = (low + high) / 2 * [0, 1, 1] + middle
    plates = []
    for side, angle in ((-1, 0.0), (1, float(model.angle_at(np.array(opening))))):
        plate: trimesh.Trimesh = trimesh.creation.box(size)
        plate.apply_transform(trimesh.transformations.rotation_matrix(angle, (0, 1, 0)))
        plates.append(plate.apply_translation(place + np.array([side * opening / 2, 0, 0])))
    return plates


def _arrow(middle: Floats) -> trimesh.Trimesh:
    """A bar between the pads, from their middle along the approach."""
    length, radius = ARROW
    bar: trimesh.Trimesh = trimesh.creation.cylinder(radius, length, sections=16)
    bar.apply_translation(middle + np.array([0, 0, length / 2]))
    return bar


def _links(model: HandModel, side: int) -> str:
    return ", ".join(link.name for link in model.links if link.body == side and link.shapes)


def _mm(lengths: ArrayLike, between: str) -> str:
    """Lengths in millimetres; 0 has no sign."""
    return between.join(f"{value:.1f}" for value in np.round(1000 * np.asarray(lengths), 1) + 0.0)


def _axis(vector: Floats) -> str:
    return ", ".join(f"{value:.3g}" for value in np.round(vector, 6) + 0.0)


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
