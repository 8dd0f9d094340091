"""What an archive was made with, kept in its file, so that nothing else is laid on top of it."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from egad import tables
from egad.errors import UserError
from egad.stage_settings import StageSettings

SECTIONS = (
    "seed",
    "gripper",
    "axes",
    "complexity",
    "difficulty",
    "similarity",
    "sampling",
    "quality",
    "robust",
    "shape",
    "space",
)


def provenance(settings: StageSettings, sections: Collection[str] = SECTIONS) -> dict[str, Any]:
    """The settings that the measures in an archive depend on."""
    return settings.model_dump(mode="json", include=set(sections))


def check_provenance(
    path: Path, settings: StageSettings, sections: Collection[str] = SECTIONS
) -> None:
    """Make sure that an archive was made with the settings that are to be used with it.

    Archives that do not say what they were made with are taken as they are.

    Args:
        path: The archive.
        settings: Those to be used.
        sections: What must be equal.

    Raises:
        UserError: Some are not; the message names both values.
        TableError: The file is damaged.
    """
    theirs = tables.notes(path)
    if not theirs:
        return
    ours = provenance(settings, sections)
    there, here = (
        dict(_flat({name: each.get(name) for name in sections})) for each in (theirs, ours)
    )
    different = [
        f"  {key}: {there.get(key)} in the archive, {here.get(key)} in the configuration"
        for key in sorted(there.keys() | here.keys())
        if there.get(key) != here.get(key)
    ]
    if different:
        raise UserError("\n".join([f"{path} was made with other settings:", *different]))


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values of nested tables by their dotted names."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
