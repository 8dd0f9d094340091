"""The configuration for readers of a report: what differs from the defaults, and all of it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import yaml
from pydantic.fields import FieldInfo

from egad._util.parameters import Parameters
from egad_workflow.settings import Settings

WIDE = 110  # characters


@dataclass(frozen=True)
class Parameter:
    """A key that differs from its default, with its section."""

    name: str
    value: str
    default: str
    meaning: str


def settings_text(settings: Settings) -> str:
    """All settings as YAML."""
    values = settings.model_dump(mode="json")
    return yaml.safe_dump(values, sort_keys=False, default_flow_style=None, width=WIDE)


def changed_parameters(settings: Settings) -> list[Parameter]:
    """The keys that differ from their defaults, single ones first; then the entries that do."""
    single: list[Parameter] = []
    inside: list[Parameter] = []
    entries = []
    for name, field in Settings.model_fields.items():
        value = getattr(settings, name)
        if isinstance(value, Parameters):
            for key, each in type(value).model_fields.items():
                inside += _changed(f"{name}.{key}", getattr(value, key), each)
        elif isinstance(value, Mapping):
            usual = _default(field)
            for key, entry in value.items():
                if entry != usual.get(key):
                    values = entry.model_dump(exclude_defaults=True)
                    text = ", ".join(f"{each}: {_text(value)}" for each, value in values.items())
                    entries.append(Parameter(f"{name}.{key}", text, "", ""))
        else:
            single += _changed(name, value, field)
    return [*single, *inside, *entries]


def _changed(name: str, value: object, field: FieldInfo) -> Iterator[Parameter]:
    if not field.is_required() and _default(field) != value:
        default = _text(_default(field)) or "nothing"
        yield Parameter(name, _text(value), default, field.description or "")


def _default(field: FieldInfo) -> Any:  # noqa: ANN401 (of any setting)
    return field.get_default(call_default_factory=True, validated_data={})


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, (tuple, list)):
        return ", ".join(_text(item) for item in value)
    return str(value)
