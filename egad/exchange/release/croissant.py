"""What a release contains, and its description for machine learning tools: Croissant 1.0.

Source: the Croissant format specification, https://docs.mlcommons.org/croissant/.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

from egad.tables.columns import meaning_of
from egad.tables.release import RELEASED_EVALUATION_SET, RELEASED_GRASPS, RELEASED_OBJECTS

CONFORMS_TO = ["http://mlcommons.org/croissant/1.0", "http://mlcommons.org/croissant/RAI/1.0"]
OWN_WORDS = (
    "citeAs column equivalentProperty extract field fileObject fileProperty fileSet format "
    "includes isLiveDataset jsonPath key md5 parentField path recordSet references regex repeated "
    "replace samplingRate separator source subField transform"
)
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "rai": "http://mlcommons.org/croissant/RAI/",
    "sc": "https://schema.org/",
    **{name: f"cr:{name}" for name in OWN_WORDS.split()},
}
HUB = "https://huggingface.co/datasets/"


@dataclass(frozen=True)
class Files:
    """Files of a release of one kind; the meaning is that of each file or row; a glob or a name."""

    name: str
    meaning: str
    pattern: str
    media_type: str


@dataclass(frozen=True)
class Table(Files):
    """A table of a release, in one file; no two rows share the columns of its key."""

    schema: pa.Schema
    key: tuple[str, ...]


def croissant_json(
    about: Mapping[str, object],
    tables: Sequence[Table],
    files: Sequence[Files],
    sums: Mapping[str, str] | None = None,
) -> str:
    """The description as JSON-LD.

    `about` has properties of schema.org or Croissant RAI, None is left out. With the `url` it can
    be read from anywhere. `sums` are SHA-256 by name; without them, the dataset may change.
    """
    url = str(about.get("url") or "")
    whole = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        **{name: value for name, value in about.items() if value is not None},
        **({} if sums else {"isLiveDataset": True}),
        "distribution": [_distribution(each, url, sums or {}) for each in (*tables, *files)],
        "recordSet": [_record_set(each) for each in tables],
    }
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _distribution(files: Files, url: str, sums: Mapping[str, str]) -> dict[str, Any]:
    common = {
        "@id": f"{files.name}-files",
        "name": f"{files.name}-files",
        "description": files.meaning,
        "encodingFormat": files.media_type,
    }
    if "*" in files.pattern:
        return {"@type": "cr:FileSet", **common, "includes": files.pattern}
    known = {"sha256": sums[files.pattern]} if files.pattern in sums else {}
    return {
        "@type": "cr:FileObject",
        **common,
        "contentUrl": _folder_url(url) + files.pattern,
        **known,
    }


def _folder_url(url: str) -> str:
    """Where the files of a release are, as text to put before their names."""
    folder = url.removesuffix("index.html").rstrip("/")
    return folder and folder + ("/resolve/main/" if url.startswith(HUB) else "/")


def _record_set(table: Table) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": table.name,
        "name": table.name,
        "description": table.meaning,
        "key": [{"@id": f"{table.name}/{name}"} for name in table.key],
        "field": [_field(table.name, field) for field in table.schema],
    }


def _field(table: str, field: pa.Field) -> dict[str, Any]:
    meaning, unit = meaning_of(field)
    return {
        "@type": "cr:Field",
        "@id": f"{table}/{field.name}",
        "name": field.name,
        "description": f"{meaning}, {unit}" if unit else meaning,
        "dataType": _data_type(field.type),
        "source": {"fileObject": {"@id": f"{table}-files"}, "extract": {"column": field.name}},
    }


def _data_type(kind: pa.DataType) -> str:
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"


PARQUET = "application/x-parquet"
ABSTRACT = (
    "Closed objects from simple to complex and from easy to hard to grasp, and parallel-jaw grasps "
    "on them that were labelled in simulation."
)
# Properties of Croissant RAI 1.0, https://docs.mlcommons.org/croissant/docs/croissant-rai-spec.html
RAI = {
    "rai:dataCollection": "An evolutionary search made the objects; no objects, images or data of "
    "people were collected.",
    "rai:dataCollectionType": ["Software Collection", "Others"],
    "rai:dataAnnotationProtocol": "A physics engine closed the fingers on the floating object, "
    "shook it and lifted it; a grasp succeeds if both fingers still hold the object at the end.",
    "rai:machineAnnotationTools": ["MuJoCo or PyBullet, as the column simulated_engine says"],
    "rai:dataLimitations": [
        "Grasps, labels and scales are for one gripper, friction and density.",
        "Labels were simulated with rigid bodies, and with convex parts in place of the true "
        "surface. They are not trials of a real robot.",
        "Only collision-free grasps were simulated, so the share that held is not that of random "
        "grasps.",
    ],
    "rai:dataBiases": [
        "Objects are abstract shapes of one uniform material, spread evenly over complexity and "
        "difficulty. They do not follow the frequencies of objects in homes or factories."
    ],
    "rai:dataUseCases": ["Training, validation and testing of grasp detectors for parallel jaws."],
    "rai:dataSocialImpact": "Robots that grasp more reliably can replace manual labor.",
    "rai:personalSensitiveInformation": ["None."],
}
TABLES = (
    Table(
        "objects",
        "one row per object: measures, mass properties, scale factor, split",
        "data/objects.parquet",
        PARQUET,
        RELEASED_OBJECTS,
        ("id",),
    ),
    Table(
        "grasps",
        "one row per grasp with a simulated label",
        "data/grasps.parquet",
        PARQUET,
        RELEASED_GRASPS,
        ("id", "grasp"),
    ),
    Table(
        "evaluation_set",
        "one row per object of the evaluation set",
        "data/evaluation_set.parquet",
        PARQUET,
        RELEASED_EVALUATION_SET,
        ("label",),
    ),
)
OTHER_FILES = (
    Files("splits", "objects and grasps again, in files by split", "data/*/*.parquet", PARQUET),
    Files(
        "meshes", "closed surface of each object, not scaled", "meshes/*.glb", "model/gltf-binary"
    ),
    Files("previews", "picture of each object", "previews/*.png", "image/png"),
    Files(
        "archives",
        "objects for simulators, scaled to the gripper: a folder each with description, convex "
        "parts, mass, friction, poses at rest",
        "archives/*.zip",
        "application/zip",
    ),
    Files(
        "network",
        "grasp networks that egad ships as detectors of the same names, with their model cards",
        "networks/*/weights.safetensors",
        "application/octet-stream",
    ),
    Files(
        "gallery",
        "page to view the objects in a browser, with its data in the folder `gallery`",
        "index.html",
        "text/html",
    ),
)
