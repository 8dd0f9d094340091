"""The dataset card of a release, its licence and how to cite it.

The front matter is what Hugging Face reads: https://huggingface.co/docs/hub/datasets-cards.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import pandas as pd
import pyarrow as pa
import yaml

from egad._util.markdown import filled, table
from egad.learning.images import SPLITS
from egad.tables.columns import meaning_of
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS

LICENSE = "CC-BY-4.0"
LICENSE_URL = "https://creativecommons.org/licenses/by/4.0/"
PAPER = {
    "authors": "Douglas Morrison, Peter Corke and Jürgen Leitner",
    "title": "EGAD! an Evolved Grasping Analysis Dataset for diversity and reproducibility in "
    "robotic manipulation",
    "journal": "IEEE Robotics and Automation Letters",
    "volume": 5,
    "issue": 3,
    "start": 4368,
    "end": 4375,
    "year": 2020,
    "doi": "10.1109/LRA.2020.2992195",
}
TAGS = ["robotics", "grasping", "robot-manipulation", "simulation", "3d", "quality-diversity"]
SIZES = {  # bounds of Hugging Face's categories
    "1K": 1e3,
    "10K": 1e4,
    "100K": 1e5,
    "1M": 1e6,
    "10M": 1e7,
    "100M": 1e8,
    "1B": 1e9,
    "10B": 1e10,
}


@dataclass(frozen=True)
class ReleaseFacts:
    """What a card says about a release; metres, kg/m3; the engine is empty without any."""

    title: str
    gripper: str
    opening: float
    density: float
    friction: float
    grasps: int
    engine: str
    program: str


def front_matter(title: str, objects: int, grasps: int) -> str:
    """The front matter: licence, tasks, size, and the files of each configuration and split."""
    splits = {"objects": "data/objects/{}.parquet", "grasps": "data/grasps/{}-*.parquet"}
    configs = [
        {
            "config_name": name,
            "data_files": [{"split": split, "path": path.format(split)} for split in SPLITS],
            **({"default": True} if name == "objects" else {}),
        }
        for name, path in splits.items()
    ]
    evaluation = {"split": "test", "path": "data/evaluation_set.parquet"}
    fields = {
        "pretty_name": title,
        "license": LICENSE.lower(),
        "task_categories": ["robotics"],
        "size_categories": [_size(objects + grasps)],
        "tags": TAGS,
        "configs": [*configs, {"config_name": "evaluation_set", "data_files": [evaluation]}],
    }
    return yaml.safe_dump(fields, sort_keys=False, allow_unicode=True)


def card_page(
    facts: ReleaseFacts,
    objects: pd.DataFrame,
    success: Mapping[str, float],
    contents: Iterable[tuple[str, str, int, int]],
) -> str:
    """The page as Markdown, with the front matter, from `RELEASED_OBJECTS` of all splits."""
    grasps = int(objects["n_grasps"].sum())
    text = filled(
        __package__,
        "dataset_card.md",
        title=facts.title,
        program=facts.program,
        objects=len(objects),
        grasps=grasps,
        paper=PAPER["title"],
        bibtex_title=str(PAPER["title"]).removeprefix("EGAD! "),
        **{name: value for name, value in PAPER.items() if name != "title"},
        contents=table(
            ["path", "what it is", "files", "size"],
            [
                (f"`{pattern}`", meaning, files, _bytes(size))
                for pattern, meaning, files, size in contents
            ],
        ),
        splits=_splits(objects, success),
        density=facts.density,
        gripper=facts.gripper,
        opening=facts.opening,
        engine=f" ({facts.engine})" if facts.engine else "",
        friction=facts.friction,
        most=facts.grasps,
        object_columns=markdown_table(RELEASED_OBJECTS),
        grasp_columns=markdown_table(RELEASED_GRASPS),
        evaluation_columns=markdown_table(RELEASED_EVALUATION_SET),
        license=LICENSE,
        license_url=LICENSE_URL,
    )
    return f"---\n{front_matter(facts.title, len(objects), grasps)}---\n\n{text}"


def _splits(objects: pd.DataFrame, success: Mapping[str, float]) -> str:
    parts = [objects[objects["split"] == name] for name in SPLITS]
    held = [success.get(name) for name in SPLITS]
    rows = [
        ("objects", *map(len, parts)),
        ("of these, in the evaluation set", *(int(p["in_evaluation_set"].sum()) for p in parts)),
        ("families", *(part["family"].nunique() for part in parts)),
        ("grasps", *(int(part["n_grasps"].sum()) for part in parts)),
        ("grasps that held", *("" if share is None else f"{share:.1%}" for share in held)),
    ]
    return table(["", *SPLITS], rows)


def _size(count: int) -> str:
    """The category of a number of rows, as Hugging Face names it."""
    lower = [name for name, bound in SIZES.items() if bound <= count]
    upper = next(name for name, bound in SIZES.items() if bound > count)
    return f"{lower[-1]}<n<{upper}" if lower else f"n<{upper}"


def _bytes(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"


CREATOR = "the egad developers"


def licence_text(title: str, version: str) -> str:
    """The licence of a release, with the dataset's title for people and its version."""
    known = {"license": LICENSE, "url": LICENSE_URL, "creator": CREATOR}
    return filled(__package__, "licence.md", title=title, version=version, **known)


def citation_cff(title: str, version: str, date: str | None, url: str | None) -> str:
    """How to cite a release, in the Citation File Format 1.2.0; `date` is YYYY-MM-DD, if known."""
    names = [
        name.rsplit(" ", 1) for name in str(PAPER["authors"]).replace(" and ", ", ").split(", ")
    ]
    paper = {
        "type": "article",
        "title": PAPER["title"],
        "authors": [{"family-names": family, "given-names": given} for given, family in names],
        **{name: PAPER[name] for name in ("journal", "year", "volume", "issue", "start", "end")},
        "doi": PAPER["doi"],
    }
    fields = {
        "cff-version": "1.2.0",
        "message": "If you use this dataset, please cite the paper and the dataset.",
        "type": "dataset",
        "title": title,
        "version": version,
        "license": LICENSE,
        "authors": [{"name": CREATOR}],
        **({"date-released": date} if date else {}),
        **({"url": url} if url else {}),
        "references": [paper],
    }
    return yaml.safe_dump(fields, sort_keys=False, allow_unicode=True)


def markdown_table(schema: pa.Schema) -> str:
    """Columns with type, unit and meaning, as a table in Markdown."""
    rows = [(f"`{field.name}`", field.type, *reversed(meaning_of(field))) for field in schema]
    return table(["column", "type", "unit", "meaning"], rows)
