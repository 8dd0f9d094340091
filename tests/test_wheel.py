"""The wheel in environments of its own, away from the repository: what `make wheel` tries.

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
MAX_PACKAGES = 49  # of the core, egad included: half of what all parts took together
MAX_BYTES = 750_000_000  # of the core, without compiled modules
PYTHON_OF_README = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
CORE = """
import egad
objects = egad.load("released")
tube = egad.read_mesh("tube.stl", units="m")
print(egad.measure(tube, gripper="panda").label, egad.similarity(tube, objects["M14_3"].mesh))
archive = egad.evolve(evaluations=20, seed=0)
assert len(archive)
"""
TRIALS = """
import egad
gripper = egad.Gripper(opening=0.11, finger_length=0.05)
few = egad.load("released")[["E08_0", "M14_3"]]
print(egad.run_trials("antipodal-depth", few, gripper, attempts=1).success_rate())
"""

pytestmark = pytest.mark.wheel


class Installed:
    """An environment that holds the wheel and what it asks for, and an empty folder to work in."""

    def __init__(self, environment, folder):
        self.programs, self.folder = environment / "bin", folder

    def attempt(self, program, *arguments):
        """Run a program of the environment."""
        variables = {"PATH": f"{self.programs}{os.pathsep}/usr/bin:/bin", "HOME": str(self.folder)}
        # Compiled with few optimisations: each kernel is used once
        variables["NUMBA_OPT"] = "1"
        return subprocess.run(
            [self.programs / program, *arguments],
            cwd=self.folder,
            env=variables,
            capture_output=True,
            text=True,
            check=False,
        )

    def run(self, program, *arguments):
        """Run a program of the environment; what it prints. An error of it is one of the test."""
        done = self.attempt(program, *arguments)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def wheel():
    for old in DIST.glob("egad-*"):
        old.unlink()
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", DIST, ROOT]
    subprocess.run(build, check=True, stdout=subprocess.DEVNULL)
    (path,) = DIST.glob("egad-*.whl")  # made from the sdist, so this is whole too
    return path


def install(wheel, extras, place):
    """The wheel with some of its extras in a new environment."""
    lock = (ROOT / "requirements.lock").read_text()
    pins = re.findall(r"^[a-z0-9.-]+==[^\s;]+(?: ;[^\\\n]*)?", lock, flags=re.MULTILINE)
    (place / "versions.txt").write_text("\n".join(pins))
    subprocess.run([sys.executable, "-m", "venv", place / "environment"], check=True)
    (place / "empty").mkdir()
    pip = [place / "environment/bin/python", "-m", "pip", "--disable-pip-version-check"]
    command = [*pip, "install", "--quiet", "--no-compile", "--constraint", place / "versions.txt"]
    # With the settings of the machine, which say where the packages are
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run([*command, f"{wheel}{extras}"], check=True, cwd=place, env=variables)
    return Installed(place / "environment", place / "empty")


@pytest.fixture(scope="module")
def core(wheel, tmp_path_factory):
    return install(wheel, "", tmp_path_factory.mktemp("core"))


@pytest.fixture(scope="module")
def workflow(wheel, tmp_path_factory):
    return install(wheel, "[workflow]", tmp_path_factory.mktemp("workflow"))


@pytest.fixture(params=["core", "workflow"])
def installed(request):
    return request.getfixturevalue(request.param)


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
    assert (measured["name"], float(measured["raw_complexity"])) == ("box", 0)
    assert float(measured["longest_side"]) == pytest.approx(0.08)


def test_pages_find_their_templates(installed):
    trimesh.creation.box((40, 60, 80)).export(installed.folder / "box.stl")
    options = ["--units", "mm", "--gripper", "panda", "--out", "box.html"]
    installed.run("egad", "view", "box.stl", *options)
    assert "<canvas" in (installed.folder / "box.html").read_text()


CONTENT = """
import json
from importlib.metadata import distributions
from pathlib import Path
print(json.dumps({
    each.name: sum(
        Path(file.locate()).stat().st_size
        for file in each.files
        if file.suffix != ".pyc" and Path(file.locate()).is_file()
    )
    for each in distributions()
}))
"""


def test_the_core_is_light(core):
    sizes = json.loads(core.run("python", "-c", CONTENT))
    sizes = {name: size for name, size in sizes.items() if name not in {"pip", "setuptools"}}
    assert "egad" in sizes
    assert len(sizes) <= MAX_PACKAGES
    assert not {"matplotlib", "mujoco", "pybullet", "snakemake"} & set(sizes)
    assert sum(sizes.values()) <= MAX_BYTES


def test_the_python_of_the_readme_runs_with_the_core(core):
    (first,) = PYTHON_OF_README
    core.run("python", "-c", first)
    assert (core.folder / "M14_3.html").stat().st_size > 10_000
    trimesh.creation.annulus(0.03, 0.04, height=0.1).export(core.folder / "tube.stl")
    core.run("python", "-c", CORE)


def test_the_core_names_the_extra_that_is_missing(core):
    said = core.attempt("python", "-c", TRIALS).stderr
    assert re.search(r"egad.run_trials needs [\w-]+: pip install 'egad\[sim\]'$", said.strip())
    hand = core.attempt("python", "-c", 'import egad; egad.Gripper.from_file("hand.urdf")').stderr
    assert "a gripper with a URDF or MJCF file needs MuJoCo: pip install 'egad[sim]'" in hand
    done = core.attempt("egad", "benchmark", "my_detector.py")
    assert done.returncode == 1
    assert done.stderr.startswith("egad: ")
    assert done.stderr.count("\n") == 1
    assert "pip install 'egad[sim]'" in done.stderr


def test_trials_run_with_the_extra(workflow):
    workflow.run("python", "-c", TRIALS)


def test_the_tutorial_runs(workflow):
    cells = json.loads((ROOT / "docs/tutorial.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    workflow.run("python", "-c", "import matplotlib; matplotlib.use('agg')\n" + "\n".join(code))


def test_a_typed_program_runs_and_passes_mypy(workflow):
    client = ROOT / "tests/typed_client.py"
    assert "neither a table of grasps" in workflow.run("python", client)  # its last line
    python = workflow.programs / "python"
    command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", python, client]
    done = subprocess.run(command, cwd=workflow.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
