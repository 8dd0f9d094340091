"""The configuration files and their JSON schema, generated from the settings.

`python -m egad.pipeline.config.files` writes them, `--check` says whether they are up to date.
"""

import json
import sys
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from egad._util.files import write_text
from egad.pipeline.config import TRAINING_SETS, Settings
from egad.pipeline.config.schema import Node, allowed, keys_of, node_at, schema

WIDTH = 98
SCHEMA = Path("workflow/schemas/config.schema.json")
Values = Mapping[str, Any]

DEFAULT_TEXT = """
All settings with their defaults: a quick run. Every line says what it means and what is allowed.
Generated from egad/settings/. Change values here, or better: put just what you want otherwise
into a file of your own and say `snakemake --cores 2 --configfile FILE`. It is laid over this one:
tables of names (datasets, grippers) grow by its entries, lists and values are replaced. With
`--replace-workflow-config` it stands alone, and what it does not name has its default.
"""
PAPER_TEXT = """
The parameters of the paper's Table II: 2000 steps of 100 children on one archive.
`snakemake --cores 8 --configfile config/paper.yaml` lays them over config/config.yaml.
"""
FULL_TEXT = """
As many evaluations as the paper, with parents drawn where there is room: how the archive that egad
ships was made. `snakemake --cores 2 --configfile config/full.yaml` lays it over config/config.yaml.
"""
TEST_TEXT = """
Everything in under a minute, to see that it works: the objects are few and coarsely measured.
`snakemake --cores 2 --configfile config/test.yaml` lays this over config/config.yaml.
"""
YCB_TEXT = """
The YCB object set: 78 objects with a laser scan, in metres. Get the meshes "google_16k" from the
YCB benchmarks site and unpack them all into data/ycb, so that there is
data/ycb/002_master_chef_can/google_16k/nontextured.ply and so on. Then
  snakemake --cores 2 --configfile config/datasets/ycb.yaml --replace-workflow-config \\
    results/comparison.parquet
measures this dataset alone. Without `--replace-workflow-config` it is laid over config/config.yaml
and compared with the evolved dataset; without a file named, the targets below are made.
"""
EGAD_TEXT = """
The published EGAD training set, in millimetres. Unpack it so that all its mesh files lie in the
folder data/egad. Then
  snakemake --cores 2 --configfile config/datasets/egad.yaml --replace-workflow-config \\
    results/comparison.parquet
measures this dataset alone. Without `--replace-workflow-config` it is laid over config/config.yaml
and compared with the evolved dataset; without a file named, the targets below are made.
"""
RELEASED_TEXT = """
The released objects: the whole pipeline from the archive that egad ships, without evolving.
`snakemake --cores 2 --configfile config/released.yaml` lays this over config/config.yaml.
"""
DIVERSITY_TEXT = """
What are diverse objects worth to a network that learns from them? The experiment of
docs/diversity.md, some five hours of CPU time; what is done is not done again. Lay it over
config/config.yaml:
  snakemake --cores 2 --configfile config/diversity.yaml results/diversity/report.html
What you must get for it, besides `pip install safetensors torch`:
  - the YCB meshes in data/ycb, as config/datasets/ycb.yaml says (set and test `ycb`);
  - weights/epoch_50_cornell_statedict.pt, GG-CNN2 as its authors trained it on the Cornell dataset,
    from the releases of the project dougsm/ggcnn (set `cornell`).
To do without, name fewer `sets` and `tests` in a file of your own that is laid over this one.
"""
RELEASED: Values = {
    "shards": 32,
    "datasets": {"egad": {"source": "archive", "archive": "released"}},
    "grasp_label": {"grasps": 500},
    "trials": {"attempts": 20},
}
PAPER: Values = {
    "shards": 32,
    "schedule": {"islands": 1, "epochs": 20},
    "evolution": {
        "steps_per_epoch": 100,
        "population": 100,
        "crossover_probability": 0.5,
        "parents": "uniform",
        "siblings": 1,
        "restart": 0.0,
        "regrade": 0,
    },
    "neat": {"activations": ["sin", "sigmoid", "gaussian", "identity"]},
    "shape": {"resolution": 25, "threshold": 0.5},
    "space": {
        "complexity_range": [1.0, 5.0],
        "difficulty_range": [0.0005, 0.004],
        "cells": 25,
        "elites_per_cell": 4,
        "neighbours": 10,
    },
    "complexity": {"bins": 512},
    "difficulty": {"metric": "plain", "grasps": 100, "percentile": 75.0},
    "trials": {"attempts": 20},
}
FULL: Values = {**PAPER, "evolution": {**PAPER["evolution"], "parents": "sparse"}}
TEST: Values = {
    "shards": 2,
    "schedule": {"islands": 2, "epochs": 2},
    "evolution": {"steps_per_epoch": 2, "population": 10},
    "difficulty": {"grasps": 12},
    "similarity": {"vertices": 1000, "base_count": 20},
    "robust": {"samples": 5},
    "postprocess": {"grasps": 20},
    "grasp_label": {"grasps": 10},
    "size_effect": {"fractions": [0.5, 0.8, 1.2], "grasps": 10, "repeats": 2},
    "select_eval": {"rows": 3, "columns": 3},
    "trials": {"attempts": 2, "image": [200, 150]},
}
YCB: Values = {
    "datasets": {
        "ycb": {
            "source": "meshes",
            "folder": "data/ycb",
            "units": "m",
            "pattern": "*/google_16k/nontextured.ply",
        }
    },
    "targets": {"datasets": ["ycb"]},
    "trials": {"attempts": 20},
}
EGAD: Values = {
    "datasets": {"egad_train": {"source": "meshes", "folder": "data/egad", "units": "mm"}},
    "targets": {"datasets": ["egad_train"]},
    "trials": {"attempts": 20},
}

DIVERSITY: Values = {
    "datasets": {
        **RELEASED["datasets"],
        **YCB["datasets"],
        "primitives": {"source": "primitives", "objects": 500},
    },
    "grasp_label": {"grasps": 500},
    "trials": {"attempts": 20, "between": "anew"},
    "training": {"patience": None},
    "diversity": {
        "sets": ["evolved", "third", "simple", "complex", "ycb", "primitives", "cornell"],
        "seeds": 2,
        "tests": ["egad", "ycb"],
        "references": ["antipodal-depth", "labels", "random"],
    },
    "training_sets": {
        **{name: each.model_dump(exclude_none=True) for name, each in TRAINING_SETS.items()},
        "ycb": {"dataset": "ycb", "hold_out": False},
        "primitives": {"dataset": "primitives", "hold_out": False},
        "cornell": {"weights": "weights/epoch_50_cornell_statedict.pt"},
    },
}


def files() -> dict[Path, str]:
    """The generated files, by their path in the repository."""
    documents = {
        "config/config.yaml": (DEFAULT_TEXT, defaults()),
        "config/paper.yaml": (PAPER_TEXT, PAPER),
        "config/full.yaml": (FULL_TEXT, FULL),
        "config/released.yaml": (RELEASED_TEXT, RELEASED),
        "config/diversity.yaml": (DIVERSITY_TEXT, DIVERSITY),
        "config/test.yaml": (TEST_TEXT, TEST),
        "config/datasets/ycb.yaml": (YCB_TEXT, YCB),
        "config/datasets/egad.yaml": (EGAD_TEXT, EGAD),
    }
    return {
        SCHEMA: json.dumps(schema(), indent=2) + "\n",
        **{Path(path): document(Path(path), *parts) for path, parts in documents.items()},
    }


def defaults() -> Values:
    """All settings with their defaults, without those that are nothing."""
    values: Values = json.loads(Settings().model_dump_json(exclude_none=True))
    return values


def document(path: Path, text: str, values: Values) -> str:
    """A commented YAML file.

    Args:
        path: Where it will be in the repository.
        text: What the file is, for its head.
        values: Settings, all or some; they come in the order of the models.
    """
    head = [
        f"# yaml-language-server: $schema={'../' * len(path.parent.parts)}{SCHEMA.as_posix()}",
        *(f"# {line}" for line in text.strip().splitlines()),
    ]
    return "\n".join([*head, *_section((), values)]) + "\n"


def _section(path: tuple[str, ...], values: Values) -> Iterator[str]:
    """The lines of a section: every value under its comment."""
    indent = "  " * len(path)
    for key in keys_of(node_at(path) or {}):
        if key not in values:
            continue
        node = node_at((*path, key)) or {}
        if not path:
            yield ""
        if "properties" in node:
            yield from _comment(node["description"], indent)
            yield f"{indent}{key}:"
            yield from _section((*path, key), values[key])
        elif node.get("type") == "object":
            yield from _table(key, node, values[key])
        else:
            yield from _comment(f"{node['description']} [{allowed(node)}]", indent)
            yield f"{indent}{key}: {_flow(values[key])}"


def _table(key: str, node: Node, entries: Values) -> Iterator[str]:
    """The lines of a table of names: the keys of an entry are explained once."""
    yield from _comment(f"{node['description']}; an entry has", "")
    for name in keys_of(node_at((key, "any")) or {}):
        entry = node_at((key, "any", name)) or {}
        yield from _comment(f"{name}: {entry['description']} [{allowed(entry)}]", "", "  ")
    yield f"{key}:"
    for name, entry in entries.items():
        yield f"  {name}:"
        yield from (f"    {inner}: {_flow(value)}" for inner, value in entry.items())


def _comment(text: str, indent: str, inset: str = "") -> list[str]:
    start = f"{indent}# {inset}"
    return textwrap.wrap(
        text, WIDTH, initial_indent=start, subsequent_indent=start + "  " * bool(inset)
    )


def _flow(value: object) -> str:
    """A value as YAML on one line."""
    text: str = yaml.safe_dump(value, default_flow_style=True, width=10_000)
    return text.removesuffix("...\n").strip()


def main(arguments: list[str]) -> int:
    """Write the files, or with `--check` compare them; the exit status says if all is well."""
    status = 0
    for path, text in files().items():
        if "--check" not in arguments:
            write_text(path, text)
        elif not path.is_file() or path.read_text(encoding="utf-8") != text:
            print(f"{path} is not up to date: run `python -m egad.pipeline.config.files`")
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
