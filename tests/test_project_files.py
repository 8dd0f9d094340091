import ast
import importlib.metadata
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from itertools import chain
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

from egad._util.extras import PACKAGES

ROOT = Path(__file__).parents[1]
OURS = [ROOT / "egad", ROOT / "egad_workflow"]
SPELLED = {  # packages that are imported by another name
    "PIL": "pillow",
    "collada": "pycollada",
    "igl": "libigl",
    "pxr": "usd-core",
    "pydrake": "drake",
    "skimage": "scikit-image",
    "zmq": "pyzmq",
}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LOCKS = {
    name: (ROOT / name).read_text()
    for name in (
        "requirements.lock",
        "requirements-dev.lock",
        "requirements-docs.lock",
        "envs/installer.lock",
    )
}


def pins(name):
    """Versions in a lock file by package."""
    return dict(re.findall(r"^([a-z0-9.\-]+)==(\S+)", LOCKS[name], flags=re.MULTILINE))


USERS, DEVELOPERS, WRITERS, _ = map(pins, LOCKS)


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


EXTRAS = PROJECT["optional-dependencies"]


def packages(*extras):
    """The requirements of extras, those of other extras that they name included, each once."""
    found = []
    for extra in extras:
        for text in EXTRAS[extra]:
            wanted = Requirement(text)
            found += packages(*sorted(wanted.extras)) if wanted.name == "egad" else [text]
    return list(dict.fromkeys(found))


BUILD = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]


@pytest.mark.parametrize(
    ("text", "locked"),
    [
        *((text, USERS) for text in PROJECT["dependencies"] + packages("cluster") + BUILD),
        *((text, USERS | DEVELOPERS) for text in packages("dev")),
        *((text, USERS | WRITERS) for text in packages("docs")),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_locks_pin_every_dependency_within_its_bounds(text, locked):
    wanted = Requirement(text)
    assert wanted.specifier.contains(locked[canonical(wanted.name)])


def test_users_get_no_tools_of_developers():
    assert set(USERS) & set(DEVELOPERS) == set()
    assert not {"mkdocs", "mypy", "opencv-python", "pytest", "ruff"} & set(USERS)


def test_the_site_is_made_with_the_versions_that_users_and_developers_have():
    others = USERS | DEVELOPERS
    assert {name: others.get(name, version) for name, version in WRITERS.items()} == WRITERS


def imported_packages(folder):
    """Top modules that are not ours nor Python's."""
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_bytes())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module]
            yield from (name.partition(".")[0] for name in names)


def test_a_missing_package_is_named_with_the_extra_that_installs_it():
    """Every package of an extra, by its extra; `ggcnn` is an old name of `vision`."""
    named = {(SPELLED.get(module, module), package.extra) for module, package in PACKAGES.items()}
    groups = set(EXTRAS) - {"all", "cluster", "dev", "docs", "ggcnn"}
    declared = {
        (canonical(Requirement(text).name), extra)
        for extra in groups
        for text in EXTRAS[extra]
        if Requirement(text).name != "egad"
    }
    assert named == declared - {("networkx", "sim")}  # it is trimesh that imports this one


def test_every_imported_package_is_declared():
    declared = {
        canonical(Requirement(text).name) for text in PROJECT["dependencies"] + packages("all")
    }
    distributions = importlib.metadata.packages_distributions()
    modules = set(chain.from_iterable(map(imported_packages, OURS))) - sys.stdlib_module_names
    modules -= {each.name for each in OURS}
    providers = {
        name: {canonical(each) for each in distributions.get(name, [name])} for name in modules
    }
    assert {name for name in modules if not providers[name] & declared} == set()


@pytest.mark.parametrize("name", LOCKS)
def test_every_pin_has_a_hash(name):
    text = LOCKS[name]
    blocks = re.split(r"\n(?=[a-z0-9])", text[text.index("\n" + next(iter(pins(name)))) :].strip())
    assert len({block.partition("==")[0] for block in blocks}) == len(pins(name))
    assert all("--hash=sha256:" in block for block in blocks)


@pytest.mark.parametrize("name", LOCKS)
def test_the_locks_name_no_address_and_no_path(name):
    address = r"https?:|file:/|--find-links|--(extra-)?index-url|(^|\s)/"
    assert not re.search(address, LOCKS[name])


def test_conda_users_get_the_same_packages():
    environment = yaml.safe_load((ROOT / "envs/egad.yaml").read_text())
    wanted = PROJECT["dependencies"] + packages("workflow")
    assert environment["dependencies"][-1]["pip"] == sorted(wanted)


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
        for folder in OURS
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert package - set(zipfile.ZipFile(wheel).namelist()) == set()
    assert {"Snakefile", "config", "envs", "profiles", "workflow"} <= {s.name for s in sources}


def test_make_without_python_says_what_is_needed(tmp_path):
    for name in ("Makefile", "requirements.lock", "pyproject.toml"):
        shutil.copy2(ROOT / name, tmp_path)
    shutil.copytree(ROOT / "envs", tmp_path / "envs")
    result = subprocess.run(
        ["make", "setup", "PYTHON="], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert result.returncode != 0
    assert "Python 3.11 or newer with venv and pip is needed" in result.stderr


def test_the_citation_names_the_version_of_the_package():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == importlib.metadata.version("egad")
    assert citation["preferred-citation"]["doi"] == "10.1109/LRA.2020.2992195"


def test_the_hooks_before_a_commit_are_the_checks_of_make_lint():
    makefile = (ROOT / "Makefile").read_text()
    recipe = re.search(r"^lint: tools\n((?:\t.+\n)+)", makefile, flags=re.MULTILINE)[1]
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    commands = [f".venv/bin/{line.strip()}" for line in recipe.splitlines()]
    assert [hook["entry"] for hook in hooks] == commands
