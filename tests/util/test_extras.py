import pickle
import subprocess
import sys

import pytest
import trimesh

from egad._util.extras import PACKAGES, check_installed, needed_for
from egad.errors import MissingPackageError, UserError

HIDDEN = """
import sys
class Hidden:
    def find_spec(name, *_):
        if name.partition(".")[0] in PACKAGES:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Hidden)
"""


def test_a_missing_package_is_named_with_its_extra():
    with pytest.raises(MissingPackageError) as found, needed_for("a dream"):
        raise ModuleNotFoundError("No module named 'torch.nn'", name="torch.nn")
    assert str(found.value) == "a dream needs PyTorch: pip install 'egad[vision]'"
    assert isinstance(found.value, UserError)
    assert isinstance(found.value, ImportError)
    copied = pickle.loads(pickle.dumps(found.value))  # noqa: S301 (our own)
    assert str(copied) == str(found.value)


def test_it_is_named_for_the_innermost_purpose():
    with pytest.raises(MissingPackageError, match="films need"), needed_for("x"):  # noqa: SIM117
        with needed_for("films need more: it"):
            raise ModuleNotFoundError("No module named 'imageio'", name="imageio")


def test_other_modules_are_missing_as_ever():
    with pytest.raises(ModuleNotFoundError, match="nonsense") as found, needed_for("a dream"):
        raise ModuleNotFoundError("No module named 'nonsense'", name="nonsense")
    assert not isinstance(found.value, MissingPackageError)


def test_a_package_is_looked_for_without_an_import(monkeypatch):
    check_installed("igl", "a dream")
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(MissingPackageError, match=r"a dream needs libigl: .*'egad\[sim\]'"):
        check_installed("igl", "a dream")


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (
            "egad.run_trials('random', egad.load('evaluation-set'), 'panda')",
            "the physics engine mujoco is not installed",
        ),
        ("egad.export", "egad.export needs"),
        ("egad.Gripper.from_file('hand.urdf')", "a gripper with a URDF or MJCF file needs MuJoCo"),
    ],
)
def test_functions_say_which_extra_they_need(code, said):
    absent = "sys.modules.update(dict.fromkeys(('collada', 'h5py', 'mujoco')))"
    command = [sys.executable, "-c", f"import sys\n{absent}\nimport egad\n{code}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    last = done.stderr.splitlines()[-1]
    assert said in last
    assert "pip install 'egad[sim]'" in last


def test_meshes_are_measured_without_any_extra(tmp_path):
    trimesh.creation.box((40, 60, 80)).export(tmp_path / "box.stl")
    names = tuple(set(PACKAGES) - {"collada"})  # trimesh only asks whether that is there
    hidden = HIDDEN.replace("PACKAGES", repr(names))
    argv = ["egad", "measure", "box.stl", "--units", "mm", "--out", "measured.csv"]
    code = f"{hidden}\nsys.argv = {argv}\nfrom egad.cli import main\nmain()"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)
    assert (tmp_path / "measured.csv").exists()
