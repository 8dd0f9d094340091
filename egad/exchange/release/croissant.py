"""Croissant: a description of a dataset release that machine learning tools read (version 1.0).

Source: the Croissant format specification, https://docs.mlcommons.org/croissant/.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

from egad.tables.columns import meaning_of

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
    """Files of a release that are of one kind; the meaning is that of each file, or row of a table.

    The pattern is the name of the only file, relative to the release, or a glob whose `*` also
    stands for folders.
    """

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

    `about` has properties of schema.org or Croissant RAI; None is left out. With the `url` of the
    release, the description can be read from anywhere, otherwise only beside the files. `tables`
    can be iterated over; `sums` are SHA-256 of the files without a glob, by name. Without sums, the
    dataset counts as one that changes.
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
