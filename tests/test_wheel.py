"""The wheel in an environment of its own, away from the repository: what `make wheel` tries.

It takes packages from the package index, in the versions of requirements.lock.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

ROOT = Path(__file__).parents[1]
DIST = ROOT / "build/dist"

pytestmark = pytest.mark.wheel


class Installed:
    """An environment that holds the wheel and what it asks for, and an empty folder to work in."""

    def __init__(self, environment, folder):
        self.programs, self.folder = environment / "bin", folder

    def run(self, program, *arguments):
        """Run a program of the environment; what it prints. An error of it is one of the test."""
        variables = {"PATH": f"{self.programs}{os.pathsep}/usr/bin:/bin", "HOME": str(self.folder)}
        # Compiled with few optimisations: each kernel is used once
        variables["NUMBA_OPT"] = "1"
        done = subprocess.run(
            [self.programs / program, *arguments],
            cwd=self.folder,
            env=variables,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    for old in DIST.glob("egad-*"):
        old.unlink()
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", DIST, ROOT]
    subprocess.run(build, check=True, stdout=subprocess.DEVNULL)
    (wheel,) = DIST.glob("egad-*.whl")  # made from the sdist, so this is whole too
    place = tmp_path_factory.mktemp("wheel")
    lock = (ROOT / "requirements.lock").read_text()
    pins = re.findall(r"^[a-z0-9.-]+==[^\s;]+(?: ;[^\\\n]*)?", lock, flags=re.MULTILINE)
    (place / "versions.txt").write_text("\n".join(pins))
    subprocess.run([sys.executable, "-m", "venv", place / "environment"], check=True)
    (place / "empty").mkdir()
    environment = Installed(place / "environment", place / "empty")
    pip = [place / "environment/bin/python", "-m", "pip", "--disable-pip-version-check"]
    install = [*pip, "install", "--quiet", "--no-compile", "--constraint", place / "versions.txt"]
    # With the settings of the machine, which say where the packages are
    subprocess.run([*install, wheel], check=True, cwd=place)
    return environment


def test_what_the_wheel_asks_for_fits_together(installed):
    assert "No broken requirements found" in installed.run("pip", "check")


def test_it_is_imported_from_the_environment_and_has_its_data(installed):
    code = """
import egad
objects = egad.load("released")
print(egad.__file__, len(objects), objects["M14_3"].mesh.is_volume)
"""
    path, count, closed = installed.run("python", "-c", code).split()
    assert Path(path).is_relative_to(installed.programs.parent)
    assert (count, closed) == ("2198", "True")


def test_commands_run_in_an_empty_folder(installed):
    """All corners of a box are alike: the entropy of their angular deficits is 0."""
    assert "measure" in installed.run("egad", "--help")
    trimesh.creation.box((40, 60, 80)).export(installed.folder / "box.stl")
    installed.run("egad", "measure", "box.stl", "--units", "mm", "--out", "measured.csv")
    names, values = (installed.folder / "measured.csv").read_text().split()
    measured = dict(zip(names.split(","), values.split(","), strict=True))
    assert (measured["name"], float(measured["complexity"])) == ("box", 0)
    assert float(measured["longest_side"]) == pytest.approx(0.08)


def test_pages_find_their_templates(installed):
    trimesh.creation.box((40, 60, 80)).export(installed.folder / "box.stl")
    options = ["--units", "mm", "--gripper", "panda", "--out", "box.html"]
    installed.run("egad", "view", "box.stl", *options)
    assert "<canvas" in (installed.folder / "box.html").read_text()


def test_the_python_of_the_readme_runs(installed):
    """With a mesh and a detector of the test where the text has `my_mesh` and `my_detector`."""
    first, second = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    given = """
import trimesh
from egad.detectors.random_detector import random_grasp as my_detector
my_mesh = trimesh.creation.box((0.03, 0.04, 0.05))
"""
    fewer = second.replace("attempts=20", "attempts=1").replace(
        "evaluations=2000", "evaluations=20"
    )
    assert fewer.count("attempts=1)") == fewer.count("evaluations=20,") == 1
    installed.run("python", "-c", first)
    assert (installed.folder / "M14_3.html").stat().st_size > 10_000
    installed.run("python", "-c", given + fewer)


def test_the_tutorial_runs(installed):
    cells = json.loads((ROOT / "docs/tutorial.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    installed.run("python", "-c", "import matplotlib; matplotlib.use('agg')\n" + "\n".join(code))


def test_a_typed_program_runs_and_passes_mypy(installed):
    client = ROOT / "tests/typed_client.py"
    assert "neither a table of grasps" in installed.run("python", client)  # its last line
    python = installed.programs / "python"
    command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", python, client]
    done = subprocess.run(
        command, cwd=installed.folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout
