"""A page about a described hand: what was found in its file, and its shape in 3D."""

import numpy as np
import trimesh
import yaml
from numpy.typing import ArrayLike

from egad._util.arrays import Floats
from egad.grippers import Gripper, GripperModel
from egad.report.hand_shape import LINK_COLORS, link_shapes, painted
from egad.report.page import render_template
from egad.report.viewer import GraspScene, viewer_data
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

PAD_COLOR, APPROACH_COLOR = 3, 4  # numbers of the colors in scene3d.js
PAD_THICKNESS = 4e-4  # metres, of what shows a pad
ARROW = (0.03, 0.001)  # metres: length and radius of what shows the approach
CHOICES = ("joint", "finger_links", "pad_links", "tcp", "closing_axis", "approach_axis")


def hand_facts(gripper: Gripper, model: GripperModel) -> dict[str, str]:
    """What was found in the file of a hand, in words: lengths in millimetres.

    Args:
        gripper: Its settings.
        model: Its model.
    """
    names = {side: _links(model, side) for side in LINK_COLORS}
    driven, followers = model.joints[: model.n_driven], model.joints[model.n_driven :]
    ends = model.positions[[0, -1]].T
    bow = 1000 * float(np.ptp(model.reach))
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
        "opening": f"{_mm(model.openings[[0, -1]], ' to ')} mm",
        "pads": f"{_mm(pad[1:] / 1000, ' x ')} mm, {1000 * (gripper.fingertip or 0):.1f} mm from "
        "their middle to the fingertips",
        "way of the pads along the approach": f"{bow:.1f} mm" if bow > 0.01 else "none",
        "middle of the closed pads": f"{_mm(frame[:3, 3], ', ')} mm in the frame of the palm",
        "closing axis": _axis(frame[:3, 0]),
        "approach axis": _axis(frame[:3, 2]),
        "convex parts": str(sum(len(link.shapes) for link in model.links)),
        "boxes, where boxes will do": f"fingers {_mm(boxes, ' x ')} mm, palm "
        f"{_mm(gripper.palm, ' x ')} mm",
    }


def hand_entry(name: str, gripper: Gripper) -> str:
    """The entry of a configuration for a gripper with a file, as YAML."""
    settings = gripper.model_dump(mode="json", include={"file", *CHOICES, "force"})
    entry = {key: value for key, value in settings.items() if value is not None}
    return yaml.safe_dump({"grippers": {name: entry}}, sort_keys=False)


def hand_page(name: str, gripper: Gripper, model: GripperModel) -> str:
    """An HTML page about a hand that needs no other file.

    Args:
        name: Name of the gripper.
        gripper: Its settings.
        model: Its model.
    """
    openings = model.openings[[-1, len(model.openings) // 2, 0]]
    words = ("open", "half open", "closed")
    scenes = [hand_scene(model, *each) for each in zip(words, map(float, openings), strict=True)]
    return render_template(
        "hand.html.j2",
        name=name,
        facts=hand_facts(gripper, model),
        entry=hand_entry(name, gripper),
        viewer=viewer_data(scenes, gripper),
    )


def hand_scene(model: GripperModel, word: str, opening: float) -> GraspScene:
    """A hand at an opening for the viewer, with its pads and its approach, which points down.

    Args:
        model: The hand.
        word: What to call it.
        opening: Metres.
    """
    reach = float(model.reach_at(np.array(opening)))
    pads = [(pad, PAD_COLOR) for pad in _pads(model, opening, reach)]
    mesh, paint = painted([*link_shapes(model, opening), *pads, (_arrow(reach), APPROACH_COLOR)])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi, (1, 0, 0)))
    title = f"{1000 * opening:.1f} mm between the pads"
    return GraspScene(word, title, mesh, empty(GRASPS), paint=paint)


def _pads(model: GripperModel, opening: float, reach: float) -> list[trimesh.Trimesh]:
    """Thin plates where the pads are."""
    low, high = model.pad
    size = np.array([PAD_THICKNESS, *(high - low)[1:]])
    middle = (low + high) / 2 + [0, 0, reach]
    places = [middle * [0, 1, 1] + [side * opening / 2, 0, 0] for side in (-1, 1)]
    return [trimesh.creation.box(size).apply_translation(place) for place in places]


def _arrow(reach: float) -> trimesh.Trimesh:
    """A bar between the pads, from their middle along the approach."""
    length, radius = ARROW
    bar: trimesh.Trimesh = trimesh.creation.cylinder(radius, length, sections=16)
    bar.apply_translation((0, 0, reach + length / 2))
    return bar


def _links(model: GripperModel, side: int) -> str:
    return ", ".join(link.name for link in model.links if link.body == side and link.shapes)


def _mm(lengths: ArrayLike, between: str) -> str:
    """Lengths in millimetres; 0 has no sign."""
    return between.join(f"{value:.1f}" for value in np.round(1000 * np.asarray(lengths), 1) + 0.0)


def _axis(vector: Floats) -> str:
    return ", ".join(f"{value:.3g}" for value in np.round(vector, 6) + 0.0)
