"""Base classes of all sections, which are closed and immutable, and their limits in words."""

import operator
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, SupportsIndex, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
)

from egad.errors import UserError, check_name

# A file or folder that the user names; `~` is the home directory, as in a shell.
UserPath = Annotated[str, AfterValidator(os.path.expanduser)]
Name = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_\-]*$")]
Fraction = Annotated[float, Field(ge=0, le=1)]
PositiveFraction = Annotated[float, Field(gt=0, le=1)]
Length = Annotated[float, Field(gt=0, le=10)]
Sigma = Annotated[float, Field(ge=0)]
Range = tuple[float, float]
FractionRange = tuple[Fraction, Fraction]
Offset = Annotated[float, Field(ge=-0.5, le=0.5)]
Axis = Literal["x", "y", "z"]
Place = tuple[float, float, float]  # metres, or a direction
Pixels = Annotated[int, Field(ge=16, le=4096)]
Percent = Annotated[float, Field(ge=0, le=100)]
MAX_SIDE_FRACTION = 3
SideFraction = Annotated[float, Field(gt=0, le=MAX_SIDE_FRACTION)]
Angle = Annotated[float, Field(ge=0, le=60)]
Seed = Annotated[int, Field(ge=0, lt=2**32)]
ScaleRule = Literal["paper", "egad-script", "exact", "none"]
SCALE_RULES = get_args(ScaleRule)


Node = dict[str, Any]
_KINDS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "null": "nothing",
}


class Parameters(BaseModel):
    """A group of settings, immutable, without unknown keys; a text below each says what it is."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        defer_build=True,
    )

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Put the text below each setting on one line, before pydantic builds the schema of it."""
        for field in cls.model_fields.values():
            field.description = field.description and " ".join(field.description.split())


P = TypeVar("P", bound=Parameters)


class ParameterGroup(Parameters):
    """The groups of settings that a function or stage reads."""

    model_config = ConfigDict(use_attribute_docstrings=False)  # settings are in the groups


@dataclass(frozen=True)
class Archived:
    """The part of a section that an archive of elites depends on; without this mark, all of it."""

    keys: frozenset[str] | None = None  # those that count; all if None
    graspability: bool = True  # whether graspability depends on the section, too


# decides which objects are found, not how they are measured
SEARCH_ONLY = Archived(keys=frozenset())


def by_name(what: str, known: Mapping[str, Parameters], given: object) -> object:
    """The section that a name stands for, or `ValueError`; a given section has lists as tuples."""
    if not isinstance(given, str):
        return with_tuples(given)
    if given not in known:
        keys = ", ".join(type(next(iter(known.values()))).model_fields)
        allowed = f"{', '.join(known)}, or a section with {keys}"
        raise ValueError(f"{what} is {given!r}; allowed: {allowed}")
    return known[given]


def with_tuples(given: Any) -> Any:  # noqa: ANN401 (any values of YAML)
    """Values of YAML with lists as tuples, as settings have them, for a validator `before`."""
    if isinstance(given, dict):
        return {name: with_tuples(each) for name, each in given.items()}
    return tuple(map(with_tuples, given)) if isinstance(given, list) else given


def from_arguments(kind: type[P], **values: Any) -> P:  # noqa: ANN401 (fields of any type)
    """Parameters from arguments, or `UserError`: here, `2.0` and `"2"` are no integers."""
    integers = [name for name in values if kind.model_fields[name].annotation is int]
    if wrong := [name for name in integers if _whole(values[name]) is None]:
        known = kind.model_json_schema()["properties"]
        raise UserError("\n".join(_refusal(name, values[name], known[name]) for name in wrong))
    try:
        return kind(**values | {name: _whole(values[name]) for name in integers})
    except ValidationError as error:
        raise UserError(_in_words(error, kind)) from error


def with_defaults(kind: type[P], **values: Any) -> P:  # noqa: ANN401 (fields of any type)
    """Parameters from arguments, with the default section for each that is required."""
    for name, field in kind.model_fields.items():
        if field.is_required() and name not in values and field.annotation:
            values[name] = field.annotation()
    return from_arguments(kind, **values)


def from_file(kind: type[P], values: Mapping[str, Any]) -> P:
    """Parameters from the values of a file; `UserError` has a line for each problem."""
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        raise UserError(_in_words(error, kind, "key")) from error


def _in_words(error: ValidationError, kind: type[BaseModel], what: str = "argument") -> str:
    """A sentence for each wrong argument: what was given, and what is allowed."""
    schema = kind.model_json_schema()
    sentences = []
    for each in error.errors(include_url=False):
        try:
            sentences.append(_sentence(each, schema, what))
        except UserError as unknown:
            sentences.append(str(unknown))
    return "\n".join(sentences)


def _sentence(error: Mapping[str, Any], schema: Node, what: str) -> str:
    """The sentence for one error of pydantic; `UserError` if there is no argument of this name."""
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    name, *inside = error["loc"]
    check_name(what, str(name), schema["properties"])
    where, node = str(name), resolved(schema["properties"][name], schema)
    for key in inside:
        if "properties" in node:
            check_name(f"key of {where}", str(key), node["properties"])
            node = resolved(node["properties"][key], schema)
        where += f"[{key}]"
    if error["type"] == "missing":
        return f"{where} is missing; allowed: {wanted(node)}"
    return _refusal(where, error["input"], node)


def resolved(node: Node, schema: Node) -> Node:
    """A part of a schema with its reference resolved; an optional section counts as the section."""
    optional = [option for option in node.get("anyOf", []) if "$ref" in option]
    reference = str(node.get("$ref", optional[0]["$ref"] if optional else ""))
    return node | schema["$defs"][reference.rpartition("/")[2]] if reference else node


def _refusal(where: str, given: object, node: Node) -> str:
    """The sentence for a wrong argument, with the schema of what is allowed."""
    return f"{where} is {given!r}; allowed: {wanted(node)}"


def _whole(given: object) -> int | None:
    """An integer of Python or numpy; None for a string, a float, or True and False."""
    if isinstance(given, bool) or not isinstance(given, SupportsIndex):
        return None
    try:
        return operator.index(given)
    except TypeError:  # an array
        return None


class UserParameters(Parameters):
    """Parameters that users make: outside a configuration, a wrong argument is a `UserError`."""

    if not TYPE_CHECKING:  # which knows the arguments from the fields

        def __init__(self, /, **values: Any) -> None:  # noqa: ANN401 (fields of any type)
            try:
                super().__init__(**values)
            except ValidationError as error:
                raise UserError(_in_words(error, type(self))) from error

        __init__.__pydantic_base_init__ = True  # else pydantic calls it for configurations, too


def check_count(name: str, given: object) -> int:
    """A whole number of at least 1, the argument of a public function; otherwise `UserError`."""
    count = _whole(given)
    if count is None or count < 1:
        raise UserError(f"{name} is {given!r}; allowed: a whole number, at least 1")
    return count


def check_ascending(section: Parameters, *names: str) -> None:
    """Raise ValueError for a range that does not go from low to high."""
    for name in names:
        low, high = getattr(section, name)
        if not low < high:
            raise ValueError(f"{name} must go from low to high, got {low} to {high}")


def keys_of(node: Node) -> list[str]:
    """The keys that a section can have; none for a table whose names the user chooses."""
    return list(node.get("properties", {}))


def allowed(node: Node) -> str:
    """What a value may be, as a phrase: `a whole number, at least 1`."""
    if "properties" in node:
        return f"a section with the keys {', '.join(keys_of(node))}"
    if "anyOf" in node:
        return " or ".join(allowed(option) for option in node["anyOf"])
    choices = [node["const"]] if "const" in node else node.get("enum")
    if choices:
        return " or ".join(map(str, choices))
    if node["type"] == "array":
        if items := node.get("prefixItems"):
            return f"a list of {len(items)}, each {allowed(items[0])}"
        filled = " (not empty)" if node.get("minItems") else ""
        return f"a list{filled}, each {allowed(node['items'])}"
    if node["type"] == "object":
        return "a table with at least one name"
    if "pattern" in node:
        return "a name of lowercase letters, digits, _ and -"
    return ", ".join([_KINDS[node["type"]], *_limits(node)])


def wanted(node: Node) -> str:
    """What is allowed, and what it means."""
    meaning = node.get("description") if "properties" not in node else None
    return f"{allowed(node)} ({meaning})" if meaning else allowed(node)


def _limits(node: Node) -> list[str]:
    low, high = node.get("minimum"), node.get("maximum")
    if low is not None and high is not None:
        return [f"{low:g} to {high:g}"]
    words = {
        "exclusiveMinimum": "above {:g}",
        "minimum": "at least {:g}",
        "exclusiveMaximum": "below {}",
        "maximum": "at most {:g}",
    }
    return [words[key].format(node[key]) for key in words if key in node]
