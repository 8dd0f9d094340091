"""PyTorch is an extra: training alone needs it, and only once it runs."""

import json
import subprocess
import sys

from egad.pipeline.code_version import PACKAGE

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
    command = [sys.executable, "-c", CODE, *names]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def test_every_stage_can_be_imported_without_pytorch():
    stages = sorted(
        f"egad.pipeline.stages.{path.stem}"
        for path in (PACKAGE / "pipeline/stages").glob("[!_]*.py")
    )
    networks = ["egad.learning.networks", "egad.learning.weights"]
    assert set(failures([*stages, *networks])) == set(networks)
