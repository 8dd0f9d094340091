"""Croissant: a description of a dataset release that machine learning tools read (version 1.0).

Source: the Croissant format specification, https://docs.mlcommons.org/croissant/.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

from egad.tables.columns import meaning_of

CONFORMS_TO = "http://mlcommons.org/croissant/1.0"
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}


@dataclass(frozen=True)
class Files:
    """Files of a release that are of one kind.

    Attributes:
        name: What they are called.
        meaning: What each file is, or each row of a table.
        pattern: Glob of the files, relative to the release.
        media_type: Media type of each.
    """

    name: str
    meaning: str
    pattern: str
    media_type: str


@dataclass(frozen=True)
class Table(Files):
    """A table of a release, in one file or several.

    Attributes:
        schema: Its columns.
        key: Columns that no two rows share.
    """

    schema: pa.Schema
    key: tuple[str, ...]


def croissant_json(
    about: Mapping[str, object], tables: Sequence[Table], files: Sequence[Files]
) -> str:
    """The description as JSON-LD.

    Args:
        about: Properties of the dataset by the names of schema.org, such as `name`, `license`,
            `version`; those that are None are left out.
        tables: Tables, which can be iterated over.
        files: Other files.
    """
    whole = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS_TO,
        **{name: value for name, value in about.items() if value is not None},
        "distribution": [_file_set(each) for each in (*tables, *files)],
        "recordSet": [_record_set(each) for each in tables],
    }
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _file_set(files: Files) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{files.name}-files",
        "name": f"{files.name}-files",
        "description": files.meaning,
        "encodingFormat": files.media_type,
        "includes": files.pattern,
    }


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
        "source": {"fileSet": {"@id": f"{table}-files"}, "extract": {"column": field.name}},
    }


def _data_type(kind: pa.DataType) -> str:
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"
