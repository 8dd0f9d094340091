"""The name that `egad gripper inspect` gives a hand from a file."""

from pathlib import Path

import pytest

from egad.cli.gripper import _name_of


@pytest.mark.parametrize(
    ("taken", "name"),
    [((), "my_panda"), (("my_panda",), "my_panda_2"), (("my_panda", "my_panda_2"), "my_panda_3")],
)
def test_no_other_gripper_has_it(taken, name):
    assert _name_of(Path("Panda.urdf"), taken) == name
