"""PyTorch is an extra: training alone needs it, and only once it runs."""

import json
import os
import subprocess
import sys
from pathlib import Path

from egad_workflow.code_version import PACKAGES

ROOT = Path(__file__).parents[3]
SCRIPTS = ROOT / "workflow" / "scripts"

CODE = """
import importlib, json, sys

class Without:
    def find_spec(name, *_):
        if name.partition(".")[0] in ("torch", "safetensors"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Without)
failed = {}
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except ImportError as error:
        failed[name] = str(error)
print(json.dumps(failed))
"""


def failures(names):
    """What the import of modules says where PyTorch and safetensors are not installed."""
    found = os.pathsep.join(map(str, (SCRIPTS, ROOT)))
    command = [sys.executable, "-c", CODE, *names]
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": found}
    )
    return json.loads(done.stdout)


def modules(folder):
    """Names of the modules in a folder of a package, also of those in its folders."""
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        yield ".".join(parts).removesuffix(".__init__")


def test_every_stage_can_be_imported_without_pytorch():
    scripts = sorted(path.stem for path in SCRIPTS.glob("*.py"))
    folders = [PACKAGES[1], PACKAGES[0] / "exchange"]
    shared = [name for folder in folders for name in modules(folder)]
    shared += ["egad.learning.train_on_images", "egad.learning.train_on_scenes"]
    assert {"evolve", "egad_workflow.job", "egad.exchange.grasps.dexnet"} <= {*scripts, *shared}
    networks = ["egad.detectors.networks", "egad.detectors.weights"]
    assert set(failures([*scripts, *shared, *networks])) == set(networks)
