"""The configuration as tables: every key, its value, its default and its meaning."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pydantic.fields import FieldInfo

from egad._util.parameters import Parameters
from egad.config.settings import Settings

GENERAL = "general"  # the section of keys that are in none


@dataclass(frozen=True)
class Parameter:
    """One key. `default` is empty unless the value differs from it."""

    name: str
    value: str
    default: str
    meaning: str


@dataclass(frozen=True)
class ParameterTable:
    """The keys of one section."""

    name: str
    summary: str
    parameters: list[Parameter]


@dataclass(frozen=True)
class EntryTable:
    """Named entries of one kind, such as grippers, one row per entry."""

    name: str
    summary: str
    columns: list[Parameter]
    rows: dict[str, list[str]]


def parameter_tables(settings: Settings) -> list[ParameterTable]:
    """The sections of the configuration, in the order of the file; single keys come first."""
    single, sections = [], []
    for name, field in Settings.model_fields.items():
        value = getattr(settings, name)
        if isinstance(value, Parameters):
            sections.append(_section(name, value))
        elif not _is_table(value):
            single.append(_parameter(name, value, field))
    return [ParameterTable(GENERAL, "Settings of the whole run.", single), *sections]


def changed_parameters(settings: Settings) -> list[Parameter]:
    """The keys that differ from their defaults, with their sections; then the entries that do."""
    keys = [
        replace(item, name=item.name if table.name == GENERAL else f"{table.name}.{item.name}")
        for table in parameter_tables(settings)
        for item in table.parameters
        if item.default
    ]
    for name, field in Settings.model_fields.items():
        entries = getattr(settings, name)
        if _is_table(entries):
            usual = field.get_default(call_default_factory=True, validated_data={})
            for key, entry in entries.items():
                if entry != usual.get(key):
                    values = entry.model_dump(exclude_defaults=True)
                    text = ", ".join(f"{each}: {_text(value)}" for each, value in values.items())
                    keys.append(Parameter(f"{name}.{key}", text, "", ""))
    return keys


def entry_tables(settings: Settings) -> list[EntryTable]:
    """Tables of named entries, such as datasets and grippers."""
    tables = []
    for name, field in Settings.model_fields.items():
        entries = getattr(settings, name)
        if _is_table(entries):
            fields = type(next(iter(entries.values()))).model_fields
            columns = [
                Parameter(key, "", "", item.description or "") for key, item in fields.items()
            ]
            rows = {
                str(entry): [_text(getattr(section, key)) for key in fields]
                for entry, section in entries.items()
            }
            tables.append(EntryTable(name, field.description or "", columns, rows))
    return tables


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(item, Parameters) for item in value.values()
    )


def _section(name: str, section: Parameters) -> ParameterTable:
    summary = (type(section).__doc__ or "").strip().partition("\n")[0]
    fields = type(section).model_fields
    parameters = [_parameter(key, getattr(section, key), field) for key, field in fields.items()]
    return ParameterTable(name, summary, parameters)


def _parameter(name: str, value: object, field: FieldInfo) -> Parameter:
    default = field.get_default(call_default_factory=True, validated_data={})
    changed = not field.is_required() and default != value
    shown = (_text(default) or "nothing") if changed else ""
    return Parameter(name, _text(value), shown, field.description or "")


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, (tuple, list)):
        return ", ".join(_text(item) for item in value)
    return str(value)
