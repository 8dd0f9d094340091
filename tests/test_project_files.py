import ast
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LOCK = (ROOT / "requirements.lock").read_text()
PINS = dict(re.findall(r"^([a-z0-9.\-]+)==(\S+)", LOCK, flags=re.MULTILINE))


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


EXTRAS = PROJECT["optional-dependencies"]


@pytest.mark.parametrize(
    "text", PROJECT["dependencies"] + EXTRAS["cluster"] + EXTRAS["dev"], ids=str
)
def test_the_lock_pins_every_dependency_within_its_bounds(text):
    wanted = Requirement(text)
    assert wanted.specifier.contains(PINS[canonical(wanted.name)])


def imported_packages(folder):
    """Top modules that are not ours nor Python's."""
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_bytes())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module]
            yield from (name.partition(".")[0] for name in names)


def test_every_imported_package_is_declared():
    declared = {canonical(Requirement(text).name) for text in PROJECT["dependencies"]} | {
        canonical(Requirement(text).name)
        for extra, texts in EXTRAS.items()
        if extra != "dev"
        for text in texts
    }
    distributions = importlib.metadata.packages_distributions()
    modules = set(imported_packages(ROOT / "egad")) - sys.stdlib_module_names - {"egad"}
    providers = {
        name: {canonical(each) for each in distributions.get(name, [name])} for name in modules
    }
    assert {name for name in modules if not providers[name] & declared} == set()


def test_every_pin_has_a_hash():
    blocks = re.split(r"\n(?=[a-z0-9])", LOCK[LOCK.index("\n" + next(iter(PINS))) :].strip())
    assert len(blocks) == len(PINS)
    assert all("--hash=sha256:" in block for block in blocks)


def test_the_lock_names_no_address_and_no_path():
    assert not re.search(r"https?:|file:/|--find-links|--(extra-)?index-url|(^|\s)/", LOCK)


def test_conda_users_get_the_same_packages():
    environment = yaml.safe_load((ROOT / "envs/egad.yaml").read_text())
    assert environment["dependencies"][-1]["pip"] == PROJECT["dependencies"]


DOCKERFILE = (ROOT / "envs/Dockerfile").read_text()
COPIED = [
    words.split()[:-1] for words in re.findall(r"^COPY (.+)$", DOCKERFILE, flags=re.MULTILINE)
]


def test_the_container_has_the_packages_of_the_lock_and_the_python_of_conda():
    environment = yaml.safe_load((ROOT / "envs/egad.yaml").read_text())
    python = next(each for each in environment["dependencies"] if each.startswith("python="))
    assert f"\nFROM {python.replace('=', ':')}-slim" in DOCKERFILE
    assert "--require-hashes --requirement requirements.lock" in DOCKERFILE
    assert "--no-deps --no-build-isolation" in DOCKERFILE


def test_what_the_container_copies_is_there_and_makes_the_whole_package(tmp_path):
    sources = [ROOT / name for names in COPIED for name in names]
    for source in sources:
        copy = shutil.copytree if source.is_dir() else shutil.copy2
        copy(source, tmp_path / source.name)
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*build, "--wheel-dir", "made", "."], cwd=tmp_path, check=True)
    (wheel,) = (tmp_path / "made").iterdir()
    package = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "egad").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert package - set(zipfile.ZipFile(wheel).namelist()) == set()
    assert {"Snakefile", "config", "envs", "profiles", "workflow"} <= {s.name for s in sources}


def test_make_without_python_says_what_is_needed(tmp_path):
    copied = tmp_path / "Makefile"
    copied.write_text((ROOT / "Makefile").read_text())
    (tmp_path / "requirements.lock").touch()
    result = subprocess.run(
        ["make", "setup", "PYTHON="], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert result.returncode != 0
    assert "Python 3.11 or newer with venv and pip is needed" in result.stderr


def test_ci_can_be_run():
    assert os.access(ROOT / ".ci/run", os.X_OK)
