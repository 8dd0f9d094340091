"""Budgets of what there is to read. A commit that raises one says what it leaves out instead."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# What a reader meets who came for objects and grasps.
ABOVE_THE_LINE = [
    *("__init__.py", "__init__.pyi", "errors.py", "friction.py", "random.py", "plugins.py"),
    "objects.py",
    *("_util", "geometry", "io", "tables", "evolution", "measures", "grippers", "grasps", "data"),
]


def lines(*paths):
    files = [file for path in paths for file in ([path] if path.is_file() else path.rglob("*.py"))]
    return sum(len(file.read_text().splitlines()) for file in files)


def lines_in_all():
    return lines(ROOT / "egad", ROOT / "egad_workflow", ROOT / "workflow")


def words_of(pattern):
    return lambda: sum(len(path.read_text().split()) for path in ROOT.glob(pattern))


def lines_above_the_line():
    return lines(*(ROOT / "egad" / name for name in ABOVE_THE_LINE))


def entries():
    return sum(path.name != "__pycache__" for path in (ROOT / "egad").iterdir())


def settings():
    manual = (ROOT / "config/README.md").read_text().partition("<!-- settings -->")[2]
    return len(re.findall(r"^\| `", manual, flags=re.MULTILINE))


@pytest.mark.parametrize(
    ("what", "size", "limit"),
    [
        ("lines of egad/ above the line", lines_above_the_line, 21_190),
        ("lines of egad/, egad_workflow/ and workflow/", lines_in_all, 62_750),
        ("entries of egad/", entries, 26),
        ("settings", settings, 300),
        ("words of README.md", words_of("README.md"), 850),
        ("words of docs/", words_of("docs/**/*.md"), 30_000),
        ("words of docs/results.md", words_of("docs/results.md"), 1_200),
    ],
)
def test_what_there_is_to_read_is_within_its_budget(what, size, limit):
    found = size()
    assert found <= limit, f"{what}: {found:,}, {found - limit:,} over the budget of {limit:,}"


@pytest.mark.skipif(not shutil.which("git"), reason="git is not installed")
def test_the_repository_holds_no_large_file():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git repository")
    files = [ROOT / name for name in listed.stdout.split("\0") if name]
    sizes = {path: path.stat().st_size for path in files if path.is_file()}
    assert not {path.name: size for path, size in sizes.items() if size > 5e6}
