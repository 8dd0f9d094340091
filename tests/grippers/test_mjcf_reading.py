"""MJCF with what does not decide how a hand opens, against the hand without it."""

import numpy as np
import pytest

from egad.errors import UserError
from egad.grippers.reading import read_model

HAND = """<mujoco model="hand">
  <compiler angle="radian"/>
  <default><geom friction="1"/></default>
  <asset>
    <texture name="cloth" type="2d" builtin="flat" width="1" height="1"/>
  </asset>
  <worldbody><body name="palm"><geom type="box" pos="0 0 -0.02" size="0.06 0.02 0.02"/>
    <body name="left"><joint name="left" type="slide" axis="-1 0 0" range="0 0.035"/>
      <geom type="box" pos="-0.005 0 0.03" size="0.005 0.01 0.03"/></body>
    <body name="right"><joint name="right" type="slide" axis="1 0 0" range="0 0.035"/>
      <geom type="box" pos="0.005 0 0.03" size="0.005 0.01 0.03"/></body>
  </body></worldbody>
  <equality><joint joint1="right" joint2="left"/></equality>
  <actuator><position joint="left"/></actuator></mujoco>"""
SEEN = '<geom type="mesh" mesh="cover" contype="0" conaffinity="0"/>'
ASSET, LEFT = "<asset>", '<body name="left">'
TEXTURE = '<texture name="cloth" type="2d" builtin="flat" width="1" height="1"/>'

HARMLESS = {
    "a mesh that is only seen is missing": {
        ASSET: f'{ASSET}<mesh name="cover" file="no.obj"/>',
        LEFT: LEFT + SEEN,
    },
    "a texture is missing": {ASSET: f'{ASSET}<texture name="t" type="2d" file="no.png"/>'},
    "a height field is missing": {
        ASSET: f'{ASSET}<hfield name="land" file="no.png" size="1 1 1 1"/>',
        "<worldbody>": '<worldbody><geom type="hfield" hfield="land"/>',
    },
    "a skin is missing": {
        "<worldbody>": '<deformable><skin file="no.skn"/></deformable><worldbody>'
    },
    "an asset twice": {TEXTURE: 2 * TEXTURE},
    "an attribute of defaults": {"<default>": '<default><default class="a" group="1"/>'},
}


def hand(folder, changes):
    text = HAND
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "hand.step").write_text("ISO-10303-21;")
    path = folder / "hand.xml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("case", HARMLESS)
def test_what_does_not_decide_the_opening_does_not_stop_the_reading(tmp_path, case):
    found = read_model(hand(tmp_path, HARMLESS[case]))
    assert found.openings[[0, -1]] == pytest.approx([0, 0.07], abs=1e-9)
    np.testing.assert_allclose(np.ptp(found.pad, axis=0), [0, 0.02, 0.06], atol=1e-8)


def test_a_collision_mesh_that_is_missing_is_named(tmp_path):
    changes = HARMLESS["a mesh that is only seen is missing"]
    collides = {old: new.replace('contype="0"', "") for old, new in changes.items()}
    with pytest.raises(UserError, match=r"a mesh of the link left is missing: no\.obj"):
        read_model(hand(tmp_path, collides))


def test_two_meshes_of_a_name_are_refused_unless_they_are_the_same(tmp_path):
    """In any of the asset blocks, and also if their name is only that of their file."""
    for first, second in (
        ('name="pad" file="a.obj"', 'name="pad" file="b.obj"'),
        ('file="a/pad.obj"', 'file="b/pad.obj"'),
    ):
        later = f"<asset><mesh {second}/></asset><worldbody>"
        with pytest.raises(UserError, match="two different assets <mesh> named pad"):
            read_model(hand(tmp_path, {ASSET: f"{ASSET}<mesh {first}/>", "<worldbody>": later}))


def test_what_a_file_with_a_fault_includes_is_relative_to_it(tmp_path):
    changes = {TEXTURE: 2 * TEXTURE, "<worldbody>": '<include file="parts/more.xml"/><worldbody>'}
    (tmp_path / "parts").mkdir()
    part = tmp_path / "parts/more.xml"
    part.write_text('<mujoco><worldbody><body name="camera"/></worldbody></mujoco>')
    found = read_model(hand(tmp_path, changes))
    assert found.openings[[0, -1]] == pytest.approx([0, 0.07], abs=1e-9)


@pytest.mark.parametrize("ending", ["usd", "usda", "usdc", "USDZ"])
def test_usd_is_named_with_a_way_out(tmp_path, ending):
    path = tmp_path / f"hand.{ending}"
    path.write_text("#usda 1.0")
    with pytest.raises(UserError, match="USD is not read; export URDF or MJCF"):
        read_model(path)


def test_a_camera_on_the_palm_does_not_turn_the_approach(tmp_path):
    """It shifts the middle of the palm by half the length of the fingers."""
    camera = '<geom type="box" pos="0 0.06 -0.02" size="0.1 0.02 0.02"/>'
    found = read_model(hand(tmp_path, {LEFT: camera + LEFT}))
    np.testing.assert_allclose(found.palm_to_hand[:3, 2], [0, 0, 1], atol=1e-9)
