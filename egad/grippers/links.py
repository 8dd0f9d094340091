"""The links of a described hand, with their convex parts, and the gaps along its jaws."""

from contextlib import suppress

import mujoco
import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from egad._util.arrays import Floats
from egad.errors import RejectedError, UserError
from egad.geometry import decompose, is_solid, to_mesh, to_solid
from egad.grippers.description import shapes_of
from egad.grippers.fingers import Sides
from egad.grippers.jaw import GRID, PAD_DEPTH, JawStroke
from egad.grippers.jaw_solids import BREADTH, SKIN, JawFrame, JawSolids, solids_of
from egad.grippers.mechanism import body_name, joint_name
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER, HandLink, LinkJoint

DEPTH_STEP = 0.01  # metres, between places along a jaw
CONVEX = 0.02  # of a hull: with less excess a shape counts as convex
# How much convex parts may add: depth in hollows, metres, and fraction of the volume
JAW, PALM = (5e-4, 0.1), (2e-3, 0.5)
MAX_PARTS = 64


def hand_link(
    model: mujoco.MjModel, body: int, bodies: list[int], sides: Sides, *, grooved: bool
) -> HandLink:
    """A link of a hand, grooved ones as convex parts; `UserError` if it has several joints."""
    shapes = []
    for points in _parts(solids_of(model, body), *JAW) if grooved else shapes_of(model, body):
        with suppress(QhullError):  # it is flat, and touches nothing
            shapes.append(points[ConvexHull(points).vertices])
    fingers = zip((FIRST_FINGER, SECOND_FINGER), sides.links, strict=True)
    side = next((side for side, links in fingers if body in links), PALM_BODY)
    carrier = int(model.body_parentid[body])
    moves = side != PALM_BODY and carrier in bodies
    joints = int(model.body_jntnum[body]) if moves else 0
    if joints > 1:
        raise UserError(f"the link {body_name(model, body)} has more than one joint")
    place = np.eye(4)
    mujoco.mju_quat2Mat(turn := np.empty(9), model.body_quat[body])
    place[:3, :3], place[:3, 3] = turn.reshape(3, 3), model.body_pos[body]
    return HandLink(
        name=body_name(model, body),
        body=side,
        shapes=tuple(shapes),
        mass=float(model.body_mass[body]),
        carrier=bodies.index(carrier) if moves else -1,
        place=place,
        joint=joint_at(model, int(model.body_jntadr[body])) if joints else None,
    )


def joint_at(model: mujoco.MjModel, number: int) -> LinkJoint:
    """A joint by its number in the model."""
    slides = int(model.jnt_type[number]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return LinkJoint(
        joint_name(model, number),
        "prismatic" if slides else "revolute",
        np.array(model.jnt_axis[number]),
        np.array(model.jnt_pos[number]),
        float(model.qpos0[model.jnt_qposadr[number]]),
    )


def gaps_along(
    jaws: JawSolids, frame: JawFrame, stroke: JawStroke, root: float
) -> tuple[Floats, Floats]:
    """Depths (d,) beyond the pads, metres, and gaps (k, d) there of what protrudes most, or NaN."""
    length = float(stroke.pads.middle @ frame.approach) - root
    depths = -DEPTH_STEP * np.arange(max(int(length / DEPTH_STEP), 0) + 1)
    middles = stroke.pads.middle + SKIN * frame.closing + depths[:, None] * frame.approach
    points = middles + stroke.pads.extent[0] * BREADTH[:, None, None] * frame.across
    shape = points.shape[:2]
    behind = jaws.fixed_face(points.reshape(-1, 3), frame).reshape(shape)
    foremost = np.where(np.isfinite(behind), behind, np.inf).min(axis=0)
    known = np.isfinite(foremost)
    faces = (points - np.where(known, foremost, 0.0)[:, None] * frame.closing).reshape(-1, 3)
    joint = jaws.mechanism.model.jnt_qposadr[jaws.mechanism.driven[0]]
    gaps = np.array([jaws.gaps(faces, float(each[joint]), frame) for each in stroke.positions])
    nearest = gaps.reshape(-1, *shape).min(axis=1)
    return np.asarray(depths), np.where(known & np.isfinite(nearest), nearest, np.nan)


def jaw_root(jaws: JawSolids, frame: JawFrame, stroke: JawStroke) -> float:
    """Where the fixed jaw begins along the approach: where the palm protrudes, if it does."""
    surfaces = np.concatenate([np.asarray(solid.vertices) for solid in jaws.solids])
    lowest = float((surfaces @ frame.approach).min())
    start = float(stroke.pads.middle @ frame.approach)
    depths = np.arange(0.0, start - lowest, GRID)
    line = stroke.pads.middle + PAD_DEPTH * frame.closing - depths[:, None] * frame.approach
    inside = np.isneginf(jaws.fixed_face(line, frame))
    if not inside.any():
        return lowest
    ahead, behind = (float(depths[inside.argmax() - before]) for before in (1, 0))
    while behind - ahead > SKIN / 10:
        middle = (ahead + behind) / 2
        point = stroke.pads.middle + PAD_DEPTH * frame.closing - middle * frame.approach
        if np.isneginf(jaws.fixed_face(point[None], frame)[0]):
            behind = middle
        else:
            ahead = middle
    return start - ahead


def jaw_links(
    jaws: JawSolids, frame: JawFrame, root: float, static: list[int]
) -> tuple[HandLink, HandLink, HandLink]:
    """The palm, the fixed jaw, which begins at `root`, and the moving one, as convex parts."""
    model = jaws.mechanism.model
    palm: list[trimesh.Trimesh] = []
    finger: list[trimesh.Trimesh] = []
    for solid in jaws.solids:
        for mesh, ahead in _cut(solid, frame.approach, root):
            (finger if ahead else palm).append(mesh)
    name, mass = body_name(model, static[0]), sum(float(model.body_mass[each]) for each in static)
    body = jaws.body
    joint = joint_at(model, int(model.body_jntadr[body]))
    turns, places = jaws.mechanism.placement(jaws.positions(joint.zero))
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turns[body], places[body]
    moving, own = body_name(model, body), float(model.body_mass[body])
    return (
        HandLink(name, PALM_BODY, _parts(palm, *PALM), mass, -1, np.eye(4), None),
        HandLink(f"{name}-fixed-jaw", FIRST_FINGER, _parts(finger, *JAW), 0.0, 0, np.eye(4), None),
        HandLink(moving, SECOND_FINGER, _parts(jaws.moving_solids, *JAW), own, 0, place, joint),
    )


def lever_of(jaws: JawSolids, stroke: JawStroke, frame: JawFrame) -> float:
    """Torque of the joint for a newton between the pads: metres at any opening; 1 if it slides."""
    contact = stroke.pads.middle + stroke.openings[-1] * frame.closing
    velocities, _ = jaws.mechanism.velocities(stroke.positions[-1], jaws.body, contact[None])
    return float(abs(velocities[0] @ frame.closing))


def _cut(
    mesh: trimesh.Trimesh, normal: Floats, height: float
) -> list[tuple[trimesh.Trimesh, bool]]:
    """The pieces ahead of a plane and behind it, each with whether it lies ahead."""
    heights = np.asarray(mesh.vertices) @ normal
    solid = to_solid(mesh.vertices, mesh.faces)
    one_side = heights.min() >= height - SKIN or heights.max() <= height + SKIN
    if one_side or not is_solid(solid):
        return [(mesh, bool(heights.mean() >= height))]
    halves = solid.split_by_plane(tuple(normal), height)
    return [
        (to_mesh(half), ahead)
        for half, ahead in zip(halves, (True, False), strict=True)
        if is_solid(half)
    ]


def _parts(meshes: list[trimesh.Trimesh], deviation: float, excess: float) -> tuple[Floats, ...]:
    """Corners of convex parts of solids."""
    parts: list[trimesh.Trimesh] = []
    for mesh in meshes:
        hulls = [trimesh.convex.convex_hull(mesh.vertices)]
        if hulls[0].volume > (1 + CONVEX) * abs(mesh.volume):
            with suppress(RejectedError):
                hulls = decompose(mesh, MAX_PARTS, excess, deviation).parts
        parts += hulls
    return tuple(np.asarray(part.vertices) for part in parts)
