"""Joints that follow others, against what their couplings say."""

import logging

import mujoco
import numpy as np
import pytest
from described_hands import MIMIC_BAR, linkage_mjcf, mimic_linkage_urdf

from egad.errors import UserError
from egad.grippers.mechanism import Mechanism
from egad.grippers.reading import read_model


def chain_of_mimics(couplings: list[tuple[int, float, float]]) -> mujoco.MjModel:
    """A driven hinge 0 and others, each coupled to an earlier one with a factor and an offset."""
    links, joints = ['<link name="base"/><link name="l0"/>'], []
    joints.append("""<joint name="j0" type="revolute"><parent link="base"/><child link="l0"/>
      <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>""")
    for number, (leader, factor, offset) in enumerate(couplings, 1):
        links.append(f'<link name="l{number}"/>')
        joints.append(f"""<joint name="j{number}" type="revolute"><parent link="base"/>
      <child link="l{number}"/><axis xyz="0 0 1"/>
      <limit lower="-0.1" upper="0.1" effort="1" velocity="1"/>
      <mimic joint="j{leader}" multiplier="{factor}" offset="{offset}"/></joint>""")
    spec = mujoco.MjSpec.from_string(f"<robot name='r'>{''.join(links + joints)}</robot>")
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-6
    return spec.compile()


def followed(couplings, driven: float) -> list[float]:
    """The obvious twin: each joint from its leader, one after the other."""
    positions = [driven]
    for leader, factor, offset in couplings:
        positions.append(factor * positions[leader] + offset)
    return positions


@pytest.mark.parametrize("case", range(6))
def test_mimic_joints_go_where_their_leaders_take_them(case):
    """From any start, tiny and far ones, and beyond their own limits."""
    rng = np.random.default_rng(case)
    couplings = [
        (int(rng.integers(n)), float(rng.choice([-2, -1, -0.5, 0.5, 1, 3])), float(offset))
        for n, offset in enumerate(rng.choice([0, 0, 0.2], 4), 1)
    ]
    mechanism = Mechanism(chain_of_mimics(couplings), 1, [0], [1, 2, 3, 4])
    for driven in np.linspace(-1, 1, 9):
        for start in (0.0, 1e-300, 1e-17, -1e-17, 1e-9, 0.1, rng.uniform(-3, 3, 5)):
            found = mechanism.follow(np.array([driven]), np.full(5, start))
            np.testing.assert_allclose(found, followed(couplings, driven), atol=1e-9)
            mechanism.check(found)


@pytest.mark.parametrize("start", [0.0, 1e-300, 1e-17, -1e-17, 1e-9])
def test_a_linkage_closes_from_tiny_positions(tmp_path, start):
    """All bars of a parallelogram lean alike, however near to 0 they were."""
    model = mujoco.MjModel.from_xml_path(str(linkage_mjcf(tmp_path / "hand.xml", (-0.3, 0.6))))
    driven = model.joint("left_outer").id
    followers = [joint for joint in range(model.njnt) if joint != driven]
    mechanism = Mechanism(model, model.body("base").id, [driven], followers)
    for angle in (-0.3, -1e-17, 0.0, 0.01, 0.6):
        found = mechanism.follow(np.array([angle]), np.full(model.nq, start))
        np.testing.assert_allclose(found, angle, atol=1e-6)


@pytest.mark.parametrize("limits", [(3.0, None), (0.5, None), (0.5, 0.3), (0.0, None)])
def test_the_limits_of_joints_that_mimic_do_not_count(tmp_path, caplog, limits):
    """The fingers stay parallel, and a warning names the joints whose limits are passed."""
    path = mimic_linkage_urdf(tmp_path / "hand.urdf", *limits)
    with caplog.at_level(logging.WARNING):
        found = read_model(path)
    half, length, (low, high) = MIMIC_BAR.values()
    angle = found.positions[:, found.joints.index("left_bar")]
    np.testing.assert_allclose(angle, np.linspace(high, low, 65), atol=1e-9)
    gaps = 2 * (half - 0.01 - length * np.sin(angle))
    np.testing.assert_allclose(found.openings, gaps, atol=1e-9)
    assert found.openings[[0, -1]] == pytest.approx([8.02e-3, 97.31e-3], abs=5e-6)
    fingers = [n for n, link in enumerate(found.links) if "finger" in link.name]
    np.testing.assert_allclose(np.ptp(found.turns[:, fingers], axis=0), 0, atol=1e-9)
    passed = {name for name in found.joints if any(name in each for each in caplog.messages)}
    expected = {"left_finger", "right_finger"} if limits[0] <= 0.5 else set()
    assert passed == expected | ({"right_bar"} if limits[1] else set())
    assert all(str(path) in each for each in caplog.messages)


def test_a_joint_without_limits_may_turn_often(tmp_path, caplog):
    """A gear on a finger turns 20 times as far as the driven bar, and nothing warns of it."""
    path = mimic_linkage_urdf(tmp_path / "hand.urdf", 3.0)
    gear = """<link name="gear"/><joint name="gear" type="continuous"><parent link="left_bar"/>
    <child link="gear"/><axis xyz="0 1 0"/><mimic joint="left_bar" multiplier="20"/></joint>"""
    path.write_text(path.read_text().replace("</robot>", f"{gear}</robot>"))
    found = read_model(path)
    angles = found.positions[:, [found.joints.index(name) for name in ("left_bar", "gear")]]
    np.testing.assert_allclose(angles[:, 1], 20 * angles[:, 0], atol=1e-9)
    assert np.abs(angles[:, 1]).max() > 2 * np.pi
    assert not caplog.messages


def test_a_linkage_that_cannot_close_is_refused_with_its_links(tmp_path):
    """A passive joint of it has a limit, beyond which its motor cannot go."""
    path = linkage_mjcf(tmp_path / "hand.xml")
    text = path.read_text()
    old = '<joint name="right_finger" axis="0 1 0" range="-2 2"/>'
    assert old in text
    path.write_text(text.replace(old, old.replace("-2 2", "-2 0.5")))
    words = r"where left_outer is at 0\.\d+, the coupling of the links right_inner and right_finger"
    with pytest.raises(UserError, match=words):
        read_model(path)


def test_a_coupling_that_does_not_hold_is_named():
    mechanism = Mechanism(chain_of_mimics([(0, 2.0, 0.0), (0, 1.0, 0.0)]), 1, [0], [1, 2])
    mechanism.check(np.array([0.1, 0.2, 0.1]))
    words = "where j0 is at 0.1, the coupling of the joints j1 and j0 .* off by 0.05 metres or rad"
    with pytest.raises(UserError, match=words):
        mechanism.check(np.array([0.1, 0.25, 0.1]))
