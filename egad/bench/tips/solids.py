"""The solids of a pair of fingertips: plates with grooves and bevels, on feet that fit the jaws.

A simulator gets convex pieces; the solid to print is their union without the jaw, or with it. The
frame of a tip has x from the outer to the inner face of the plate, z along the jaw from where the
foot begins.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import manifold3d
import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad.bench.tips.base import Base, pose_of
from egad.bench.tips.parameters import FingertipDesign
from egad.errors import UserError
from egad.geometry import RayCaster, is_solid, to_mesh
from egad.grippers import FINGERS

Solid = Any  # manifold3d.Manifold, which has no type information
RECESS = 0.015  # metres that a jaw may recede from its foremost point, where the foot reaches it
SINK = 3e-4  # metres that the foot reaches into the jaw before the jaw is cut out of it
FLAT = 0.9  # of a plate: a groove may be this wide
RAYS = 15  # along each side of the foot
REACH = 1.0  # metres, wider than any hand
CRUMB = 1e-9  # m3, of what the jaw cuts off a foot, that is left out
# Metres, of a countersunk M3 screw: its hole, its head, and the room around its head.
HOLE, HEAD, ROOM = 3.4e-3, 6.3e-3, 1.2e-3
SEAM = 2.5e-4  # metres by which the shapes of a jaw grow to be printed, if they do not touch


class Tip(NamedTuple):
    """The fingertip of a jaw, in the frame of the link that carries it, metres."""

    link: int  # number of the link
    pieces: tuple[Floats, ...]  # (n, 3) corners of its convex pieces, which reach into the jaw
    mesh: trimesh.Trimesh  # what is printed
    pose: Floats  # (4, 4) pose of the tip
    free: float  # length of the plate beyond the foot
    added: trimesh.Trimesh  # what it adds to the jaw, without screw holes


class Mount(NamedTuple):
    """Where the tips are mounted, in the frame of the hand at an opening, metres."""

    opening: float
    root: float  # where the feet begin along the approach
    end: float  # where they end
    tip: float  # where the jaws end
    faces: tuple[float, float]  # the foremost points of both jaws on the closing axis


def make_tips(base: Base, design: FingertipDesign) -> tuple[Tip, Tip]:
    """The tips of both jaws, the fixed one first; `UserError` if there is no room for them."""
    _check_plates(design)
    mount = _find_mount(base, design)
    first, second = (_make_tip(base, design, mount, side) for side in FINGERS)
    return first, second


def _check_plates(design: FingertipDesign) -> None:
    """Raise UserError if the groove is about as wide as the plate, or as deep, or all is bevel."""
    if design.bevel >= design.thickness:
        raise UserError(
            f"the bevel is {_mm(design.bevel)}, the plates are {_mm(design.thickness)} thick: make "
            "it smaller"
        )
    depth, half = design.groove_depth, _groove_half(design)
    room = design.width if design.groove_direction == "along" else design.length
    if depth >= design.thickness or 2 * half >= FLAT * room:
        raise UserError(
            f"the groove is {_mm(depth)} deep and {_mm(2 * half)} wide, in plates that are "
            f"{_mm(design.thickness)} thick and {_mm(room)} wide there; make it shallower"
        )
    foot = (design.width, design.overlap, design.thickness - depth)
    screws = (2 * (HEAD + ROOM), HEAD + ROOM, (HEAD - HOLE) / 2 + ROOM)
    if design.mount == "screw" and any(np.less(foot, screws)):
        raise UserError(
            f"two M3 screws need a foot that is {' x '.join(map(_mm, screws))} wide, long and, "
            f"without grooves, thick; it is {' x '.join(map(_mm, foot))}: enlarge it, or glue it"
        )


def _groove_half(design: FingertipDesign) -> float:
    """Half the width of the groove, metres; 0 without one."""
    slope = np.tan(np.radians(design.groove_angle))
    return float(design.groove_depth / slope) if slope and design.groove_depth else 0.0


def _mm(length: float) -> str:
    return f"{1000 * length:.3g} mm"


def _find_mount(base: Base, design: FingertipDesign) -> Mount:
    """The opening at which there is room for the plates with their gap between them."""
    wanted = design.gap + 2 * (design.thickness + design.spacer)
    openings = base.model.openings
    if not base.turns:
        return _mount_at(base, design, float(openings[-1]))
    mounts = [_mount_at(base, design, float(each)) for each in openings]
    apart = [mount.faces[1] - mount.faces[0] for mount in mounts]
    if not apart[0] <= wanted <= apart[-1]:
        raise UserError(
            f"where the tips are mounted, the jaws are {_mm(apart[0])} to {_mm(apart[-1])} apart; "
            f"plates that are parallel at {_mm(design.gap)} need {_mm(wanted)}: change their gap"
        )
    return _mount_at(base, design, float(np.interp(wanted, apart, openings)))


def _mount_at(base: Base, design: FingertipDesign, opening: float) -> Mount:
    """The faces of the jaws at an opening, where the feet are."""
    jaws = [base.model.corners(opening, side) for side in FINGERS]
    ends = [max(float(points[:, 2].max()) for points in jaw) for jaw in jaws]
    end = min(ends)
    root = end - design.overlap
    low = (-REACH, -design.width / 2, root)
    before = manifold3d.Manifold.cube((2 * REACH, design.width, design.overlap)).translate(low)
    faces = []
    for side, jaw in zip(FINGERS, jaws, strict=True):
        cuts = [manifold3d.Manifold.hull_points(points) ^ before for points in jaw]
        fronts = [-side * cut.bounding_box()[3 if side < 0 else 0] for cut in cuts if is_solid(cut)]
        if not fronts:
            raise UserError(
                f"a jaw has no face in the last {_mm(design.overlap)}, where the tip is mounted"
            )
        faces.append(-side * max(fronts))
    return Mount(opening, root, end, max(ends), (faces[0], faces[1]))


def _make_tip(base: Base, design: FingertipDesign, mount: Mount, side: int) -> Tip:
    """The tip of a jaw, in the frame of its link."""
    number = FINGERS.index(side)
    pose = np.eye(4)
    inner = mount.faces[number] - side * (design.thickness + design.spacer)
    pose[:3, :3] = np.diag([-side, -side, 1.0])
    pose[:3, 3] = inner + side * design.thickness, 0.0, mount.root
    parts = base.model.corners(mount.opening, side)
    beyond = mount.tip - mount.root
    plate = [_tilted(design, points) for points in _plate_pieces(design, beyond)]
    back = design.spacer + _recess(parts, design, mount, side)
    foot = _corners([-back, design.thickness / 2], design.width, [0.0, design.overlap])
    link = _carrier(base, mount, side)
    to_link = np.linalg.inv(pose_of(base.model, link, mount.opening)) @ pose
    jaw = [trimesh.transform_points(points, np.linalg.inv(pose)) for points in parts]
    solid, *others = _bodies(union_of_hulls([*plate, foot]) - union_of_hulls(jaw))
    if others:
        raise UserError("the jaw cuts a foot into pieces: make it wider, or the overlap shorter")
    own = [
        trimesh.transform_points(points, np.linalg.inv(to_link))
        for points in base.model.links[link].shapes
    ]
    printed = _printed(design, solid, [*plate, foot], own)
    return Tip(
        link,
        tuple(trimesh.transform_points(points, to_link) for points in (*plate, foot)),
        to_mesh(printed).apply_transform(to_link),
        to_link,
        mount.tip - mount.end + design.length,
        to_mesh(solid).apply_transform(to_link),
    )


def _bodies(solid: Solid) -> list[Solid]:
    """The bodies of a solid without crumbs, the largest first."""
    bodies = [body for body in solid.decompose() if body.volume() > CRUMB]
    return sorted(bodies, key=lambda body: -float(body.volume()))


def _printed(design: FingertipDesign, solid: Solid, tip: list[Floats], jaw: list[Floats]) -> Solid:
    """What is printed: what is added to a jaw, that with holes, or the jaw with its tip."""
    if design.mount == "glue":
        return solid
    if design.mount == "screw":
        return solid - _screw_holes(design)
    whole, *others = _bodies(union_of_hulls([*tip, *jaw]))
    if others:
        ends = _corners([-SEAM, SEAM], 2 * SEAM, [-SEAM, SEAM])
        grown = [(points[:, None] + ends).reshape(-1, 3) for points in jaw]
        whole, *others = _bodies(union_of_hulls([*tip, *grown]))
    if others:
        raise UserError("the shapes of a jaw do not touch, so it cannot be printed: glue the tips")
    return whole


def _screw_holes(design: FingertipDesign) -> Solid:
    """Two holes through the plate and its foot, countersunk by 90 degrees at the inner face."""
    r, head = HOLE / 2, HEAD / 2
    profile = [(0, -REACH), (r, -REACH), (r, r - head), (head, 0), (head, REACH), (0, REACH)]
    hole = manifold3d.CrossSection([profile]).revolve(64).rotate((0, 90, 0))
    places = [(design.thickness, way * design.width / 4, design.overlap / 2) for way in (-1, 1)]
    return hole.translate(places[0]) + hole.translate(places[1])


def _plate_pieces(design: FingertipDesign, beyond: float) -> list[Floats]:
    """Convex pieces of a plate that ends `beyond` + its length from where the foot begins."""
    length, thick = beyond + design.length, design.thickness
    half = _groove_half(design)
    if not half:
        return [_beveled(_corners([0.0, thick], design.width, [0.0, length]), design, length)]
    bottom = thick - design.groove_depth
    along = design.groove_direction == "along"
    low, high = (-design.width / 2, design.width / 2) if along else (0.0, length)
    middle = 0.0 if along else beyond + design.length / 2
    across = (0.0, length) if along else (-design.width / 2, design.width / 2)
    profiles = [
        [(0, low), (bottom, low), (bottom, high), (0, high)],
        [(bottom, low), (thick, low), (thick, middle - half), (bottom, middle)],
        [(bottom, middle), (thick, middle + half), (thick, high), (bottom, high)],
    ]
    pieces = [
        np.array([(x, s, t) if along else (x, t, s) for (x, s), t in product(profile, across)])
        for profile in profiles
    ]
    return [_beveled(piece, design, length) for piece in pieces]


def _corners(x: list[float], width: float, z: list[float]) -> Floats:
    """Corners of a box whose middle is at y = 0, (8, 3)."""
    return np.array(list(product(x, (-width / 2, width / 2), z)))


def _beveled(points: Floats, design: FingertipDesign, length: float) -> Floats:
    """A convex piece without the outer edge of the tip."""
    if not design.bevel:
        return points
    solid = manifold3d.Manifold.hull_points(points)
    normal = np.array([1.0, 0.0, -1.0]) / np.sqrt(2)
    cut = solid.trim_by_plane(tuple(normal), float(normal @ [design.bevel, 0.0, length]))
    return np.asarray(cut.to_mesh64().vert_properties)[:, :3]


def _tilted(design: FingertipDesign, points: Floats) -> Floats:
    """Points of a plate that is tilted about the inner edge where the foot ends."""
    half = np.radians(design.angle) / 2
    hinge = np.array([design.thickness, 0.0, design.overlap])
    turn = trimesh.transformations.rotation_matrix(-half, (0, 1, 0), hinge)
    return np.asarray(trimesh.transform_points(points, turn))


def _recess(parts: list[Floats], design: FingertipDesign, mount: Mount, side: int) -> float:
    """How deep the face of a jaw recedes where the foot is, metres, and a little more."""
    inset = 1e-5
    y = np.linspace(-design.width / 2 + inset, design.width / 2 - inset, RAYS)
    z = np.linspace(mount.root + inset, mount.end - inset, RAYS)
    face = mount.faces[FINGERS.index(side)] - side * inset
    starts = np.array([[face, *each] for each in product(y, z)])
    ahead = np.tile([float(side), 0.0, 0.0], (len(starts), 1))
    distances = RayCaster(to_mesh(union_of_hulls(parts))).first_hits(starts, ahead).distances
    reached = distances[distances <= RECESS]
    return float(reached.max(initial=0.0)) + SINK


def _carrier(base: Base, mount: Mount, side: int) -> int:
    """The link of a jaw that reaches farthest along the approach."""
    shapes = base.model.points(mount.opening)
    carriers = [n for n, link in enumerate(base.model.links) if link.body == side and link.shapes]
    return max(carriers, key=lambda n: max(float(points[:, 2].max()) for points in shapes[n]))


def union_of_hulls(pieces: Sequence[Floats]) -> Solid:
    """The union of convex hulls of points, (n, 3) each."""
    solids = [manifold3d.Manifold.hull_points(points) for points in pieces]
    return manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
