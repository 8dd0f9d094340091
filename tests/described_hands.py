"""Descriptions of hands, small enough to know the answers."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

from egad.geometry import to_mesh, to_solid

PANDA = {"finger": (0.01, 0.021, 0.0445), "palm": (0.2, 0.063, 0.06), "opening": 0.08}
BAR = 0.06  # metres, of the linkage
SWING = (0.1, 0.8)  # radians, of its bars, between open and closed
PAD = 0.004  # thickness of its pads
INSET = BAR * np.sin(SWING[1]) + 0.002  # of its hinges; so the pads are closed at 4 mm


def box_urdf(
    path: Path, *, mimic: bool = True, limits: bool = True, changes: dict[str, str] | None = None
) -> Path:
    """The boxes of the named Panda as URDF: x closes, z is the approach."""
    thick, wide, long = PANDA["finger"]
    inner = 1e-4  # as egad's boxes, which are this much further apart than the opening
    limit = f'<limit lower="0" upper="{PANDA["opening"] / 2}" effort="10" velocity="1"/>'
    side = {
        name: f"""
  <link name="{name}"><collision>
    <origin xyz="{way * (thick / 2 + inner)} 0 {long / 2}"/>
    <geometry><box size="{thick} {wide} {long}"/></geometry>
  </collision></link>
  <joint name="{name}_joint" type="prismatic">
    <parent link="hand"/><child link="{name}"/>
    <axis xyz="{way} 0 0"/>{limit if limits else ""}
    {'<mimic joint="left_joint"/>' if mimic and name == "right" else ""}
  </joint>"""
        for name, way in (("left", -1), ("right", 1))
    }
    sizes = " ".join(map(str, PANDA["palm"]))
    text = f"""<robot name="boxes">
  <link name="hand"><collision>
    <origin xyz="0 0 {-PANDA["palm"][2] / 2}"/><geometry><box size="{sizes}"/></geometry>
  </collision></link>{side["left"]}{side["right"]}
</robot>"""
    return _written(path, text, changes)


def _written(path: Path, text: str, changes: dict[str, str] | None) -> Path:
    """A file with a text, in which some parts are replaced."""
    for old, new in (changes or {}).items():
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text)
    return path


MIMIC_BAR = {"half": 0.02, "length": 0.06, "range": (-0.7, 0.1)}  # metres, radians


def mimic_linkage_urdf(path: Path, finger_limit: float, bar_limit: float | None = None) -> Path:
    """Two bars that lean as one, with fingers that mimic them the other way, and never turn.

    At 0 the bars stand upright, and the fingers are 20 mm apart.

    Args:
        path: File to write.
        finger_limit: Limit of the joints of the fingers both ways, radians.
        bar_limit: The same of the bar that mimics the driven one; as the driven one if None.
    """
    half, length, (low, high) = MIMIC_BAR.values()
    right = (-high, -low) if bar_limit is None else (-bar_limit, bar_limit)

    def side(name: str, way: int, limits: tuple[float, float], mimics: tuple[str, str]) -> str:
        bar = f"""
  <link name="{name}_bar"><collision>
    <origin xyz="0 0 {length / 2}"/><geometry><box size="0.008 0.012 {length}"/></geometry>
  </collision></link>
  <joint name="{name}_bar" type="revolute">
    <origin xyz="{way * half} 0 0"/><parent link="base"/><child link="{name}_bar"/>
    <axis xyz="0 1 0"/><limit lower="{limits[0]}" upper="{limits[1]}" effort="1" velocity="1"/>
    {mimics[0]}
  </joint>"""
        return f"""{bar}
  <link name="{name}_finger"><collision>
    <origin xyz="{-way * 0.006} 0 0.03"/><geometry><box size="0.008 0.02 0.05"/></geometry>
  </collision></link>
  <joint name="{name}_finger" type="revolute">
    <origin xyz="0 0 {length}"/><parent link="{name}_bar"/><child link="{name}_finger"/>
    <axis xyz="0 1 0"/>
    <limit lower="{-finger_limit}" upper="{finger_limit}" effort="1" velocity="1"/>{mimics[1]}
  </joint>"""

    def mimic(factor: int) -> str:
        return f'<mimic joint="left_bar" multiplier="{factor}"/>'

    path.write_text(f"""<robot name="linkage"><link name="base"><collision>
    <origin xyz="0 0 -0.02"/><geometry><box size="0.08 0.04 0.03"/></geometry>
  </collision></link>
{side("left", -1, (low, high), ("", mimic(-1)))}{side("right", 1, right, (mimic(-1), mimic(1)))}
</robot>""")
    return path


def linkage_mjcf(path: Path, swing: tuple[float, float] = SWING) -> Path:
    """Two parallelograms of equal bars: the fingers move on arcs and never turn.

    Args:
        path: File to write.
        swing: Lean of the bars inwards when the hand is open and when it is closed, radians.
    """
    low, high = swing
    inset = BAR * np.sin(high) + 0.002

    def side(name: str, way: int) -> str:
        # The bars hang upwards along z and turn about y; at 0 they stand upright.
        start = way * inset
        return f"""
      <body name="{name}_outer" pos="{start + way * 0.01} 0 0.05">
        <joint name="{name}_outer" axis="0 {-way} 0" range="{low} {high}"/>
        <geom type="box" size="0.003 0.005 {BAR / 2}" pos="0 0 {BAR / 2}" mass="0.01"/>
        <body name="{name}_finger" pos="0 0 {BAR}">
          <joint name="{name}_finger" axis="0 {way} 0" range="-2 2"/>
          <geom name="{name}_pad" type="box" size="{PAD / 2} 0.01 0.02"
            pos="{-way * (0.01 + PAD / 2)} 0 0.03" mass="0.01"/>
        </body>
      </body>
      <body name="{name}_inner" pos="{start} 0 0.05">
        <joint name="{name}_inner" axis="0 {-way} 0" range="-2 2"/>
        <geom type="box" size="0.003 0.005 {BAR / 2}" pos="0 0 {BAR / 2}" mass="0.01"/>
      </body>"""

    def loop(name: str) -> str:
        anchor = f'anchor="0 0 {BAR}"'
        return f'<connect body1="{name}_inner" body2="{name}_finger" {anchor} solref="0.004 1"/>'

    path.write_text(f"""<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" gravity="0 0 0" integrator="implicitfast"/>
  <default><joint armature="0.001" damping="0.02"/></default>
  <worldbody>
    <body name="base">
      <geom type="box" size="0.06 0.03 0.025" pos="0 0 0.02"/>{side("left", -1)}{side("right", 1)}
    </body>
  </worldbody>
  <equality>
    {loop("left")}{loop("right")}
    <joint joint1="right_outer" joint2="left_outer" solref="0.004 1"/>
  </equality>
  <contact>
    <exclude body1="left_outer" body2="left_inner"/>
    <exclude body1="right_outer" body2="right_inner"/>
  </contact>
  <actuator>
    <position name="close" joint="left_outer" kp="20" kv="2" ctrlrange="{low} {high}"/>
  </actuator>
</mujoco>""")
    return path


# The jaws of an SO-101, as boxes, in millimetres. Fixed: x of the inner face, z from and to, half
# the breadth. Moving: the same as distances from its hinge, where the joint is at 0.
FIXED_STEPS = (
    (-7.9, -104.5, -95.0, 4.0),
    (-9.9, -95.0, -86.0, 5.5),
    (-11.6, -86.0, -65.0, 9.0),
    (-13.3, -65.0, -45.0, 10.5),
    (-15.0, -45.0, -36.0, 12.0),
)
MOVING_STEPS = ((-12.3, -82.0, -73.0, 4.0), (-10.3, -73.0, -63.0, 6.0), (-8.3, -63.0, -24.0, 10.0))
HINGE = (20.2, -23.4)  # x and z
JAW_THICKNESS = (5.0, 6.0)
JAW_RANGE = (-0.1745, 1.7453)  # radians; positive opens
JAW_STROKE = 0.05  # metres, of a jaw that slides


def jaw_urdf(
    path: Path,
    *,
    slides: bool = False,
    meshes: bool = False,
    mirrored: bool = False,
    changes: dict[str, str] | None = None,
) -> Path:
    """An SO-101's hand: a fixed jaw on the palm, in steps, and a moving one about a hinge.

    The jaws open along x and point to -z.

    Args:
        path: File to write.
        slides: Whether the moving jaw slides along x instead, closed with its steps at 0 mm.
        meshes: Whether palm and jaws are one concave mesh each instead of boxes.
        mirrored: Whether the joint counts the other way.
        changes: Texts that are replaced in the file.
    """
    palm = ((-35.0, 6.0), (-24.0, 24.0), (-36.0, 0.0))
    fixed = [((x - JAW_THICKNESS[0], x), (-y, y), (a, b)) for x, a, b, y in FIXED_STEPS]
    moving = [((x, x + JAW_THICKNESS[1]), (-y, y), (a, b)) for x, a, b, y in MOVING_STEPS]
    start = (-7.9 + 12.3, -21.5) if slides else HINGE
    low, high = (0.0, JAW_STROKE) if slides else JAW_RANGE
    way = -1 if mirrored else 1
    if mirrored:
        low, high = -high, -low
    axis = f"{way} 0 0" if slides else f"0 {-way} 0"
    text = f"""<robot name="jaw">
  <link name="gripper">{_shapes(path, "gripper", [palm, *fixed], meshes)}</link>
  <link name="jaw">{_shapes(path, "jaw", moving, meshes)}</link>
  <joint name="swing" type="{"prismatic" if slides else "revolute"}">
    <origin xyz="{start[0] / 1000} 0 {start[1] / 1000}"/>
    <parent link="gripper"/><child link="jaw"/><axis xyz="{axis}"/>
    <limit lower="{low}" upper="{high}" effort="1" velocity="1"/>
  </joint>
</robot>"""
    return _written(path, text, changes)


def jaw_gap(angle: float, z: float) -> float:
    """Gap of the jaws of `jaw_urdf` along x, metres; NaN where one of them is not.

    Args:
        angle: Of the joint, radians.
        z: Depth in the frame of the palm, metres.
    """
    mm, (hinge_x, hinge_z) = 1000 * z, HINGE
    fixed = [x for x, low, high, _ in FIXED_STEPS if low <= mm < high]
    ends = []
    for x, low, high, _ in MOVING_STEPS:
        along = (mm - hinge_z - x * np.sin(angle)) / np.cos(angle)  # from the hinge
        if low <= along < high:
            ends.append(hinge_x + x * np.cos(angle) - along * np.sin(angle))
    if not fixed or not ends:
        return float("nan")
    return (min(ends) - fixed[0]) / 1000


def _shapes(path: Path, name: str, boxes: Sequence[Sequence[Sequence[float]]], mesh: bool) -> str:
    """Collision shapes of a link: boxes in millimetres, or one mesh file of all of them."""
    solids = []
    for box in boxes:
        size, center = np.ptp(box, axis=1) / 1000, np.mean(box, axis=1) / 1000
        solids.append(
            trimesh.creation.box(size, trimesh.transformations.translation_matrix(center))
        )
    if mesh:
        whole = to_solid(solids[0].vertices, solids[0].faces)
        for solid in solids[1:]:
            whole += to_solid(solid.vertices, solid.faces)
        file = path.with_name(f"{path.stem}-{name}.stl")
        to_mesh(whole).export(file)
        return f'<collision><geometry><mesh filename="{file.name}"/></geometry></collision>'
    return "".join(
        f"""
    <collision><origin xyz="{" ".join(map(str, solid.bounds.mean(axis=0)))}"/>
      <geometry><box size="{" ".join(map(str, solid.extents))}"/></geometry></collision>"""
        for solid in solids
    )
