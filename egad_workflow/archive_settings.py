"""The settings that an archive was made with, stored in it so that no others are used with it."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from egad._util.parameters import Archived, Parameters
from egad.errors import UserError
from egad.measures import MeasureParameters
from egad.plugins import source_hash
from egad.tables import parquet


def _marks(group: type[Parameters]) -> dict[str, Archived]:
    """How an archive depends on each section of a group of settings."""
    return {
        name: next((mark for mark in field.metadata if isinstance(mark, Archived)), Archived())
        for name, field in group.model_fields.items()
    }


# what the graspability in an archive depends on
MEASURING = {
    "source",
    *(name for name, mark in _marks(MeasureParameters).items() if mark.graspability),
}


def provenance(settings: Parameters) -> dict[str, Any]:
    """What the measures in an archive depend on: settings, and the user's own measures."""
    marks = _marks(type(settings))
    counts = {name: True if mark.keys is None else set(mark.keys) for name, mark in marks.items()}
    included = {name: keys for name, keys in counts.items() if keys}
    notes: dict[str, Any] = settings.model_dump(mode="json", include=included)
    if isinstance(settings, MeasureParameters):
        functions = settings.measures.functions()
        notes["source"] = {axis: source_hash(name, "measures") for axis, name in functions.items()}
    return notes


def differences(
    path: Path, settings: Parameters, sections: Collection[str] | None = None
) -> list[str]:
    """A line for each setting, in some sections or all, that an archive has with another value."""
    theirs, ours = archive_notes(path), dict(_flat(provenance(settings)))
    return [
        f"  {key}: {theirs[key]} in the archive, {ours[key]} in the configuration"
        for key in sorted(theirs.keys() & ours.keys())
        if theirs[key] != ours[key] and (sections is None or key.split(".")[0] in sections)
    ]


def archive_notes(path: Path) -> dict[str, Any]:
    """The settings that an archive was made with, by dotted names, or `TableError`."""
    return dict(_flat(parquet.notes(path)))


def check_provenance(
    path: Path, settings: Parameters, sections: Collection[str] | None = None
) -> None:
    """Raise `UserError` with both values of each setting that differs from those of an archive."""
    if different := differences(path, settings, sections):
        raise UserError("\n".join([f"{path} was made with other settings:", *different]))


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values of nested tables by their dotted names."""
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
