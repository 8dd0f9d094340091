"""The commands of the stages, made from the functions of the modules in `egad/pipeline/stages/`.

Their names and summaries are read from the source, so that `egad --help` imports no stage.
"""

import ast
import importlib
import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperCommand, TyperGroup

from egad.errors import UserError
from egad.pipeline.parameters import Declared, ShardOf, declared

PANEL = "Stages of the pipeline"
STAGES = Path(__file__).parents[1] / "stages"
SETTINGS = "settings of this stage, as JSON"
NUMBERS = {"shard": "number of this shard, from 0", "shards": "number of shards"}
Option = inspect.Parameter


class StageCommand(NamedTuple):
    """A command of a stage: where its function is, and what it does in a sentence."""

    module: str
    function: str
    summary: str


class StageGroup(TyperGroup):
    """Commands of which those of the stages are imported when they are called."""

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401 (of typer)
        """All names, those of the stages first."""
        return [*stage_commands(), *super().list_commands(ctx)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ANN401 (of typer)
        """A command; that of a stage without its options, for the list of commands."""
        stage = stage_commands().get(cmd_name)
        if stage is None:
            return super().get_command(ctx, cmd_name)
        return TyperCommand(cmd_name, help=stage.summary, rich_help_panel=PANEL)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:  # noqa: ANN401 (of typer)
        """The command that is called, and its arguments."""
        name, command, rest = super().resolve_command(ctx, args)
        stage = stage_commands().get(name or "")
        return (name, loaded_command(stage), rest) if stage else (name, command, rest)


@cache
def stage_commands() -> Mapping[str, StageCommand]:
    """The commands of all stages, by name."""
    found = dict(pair for path in sorted(STAGES.glob("[!_]*.py")) for pair in _commands_in(path))
    return dict(sorted(found.items()))


def stage_function(module: str, function: str = "run") -> Callable[..., Any]:
    """The function of a stage, by the name of its module in `egad.pipeline.stages`."""
    found: Callable[..., Any] = getattr(
        importlib.import_module(f"egad.pipeline.stages.{module}"), function
    )
    return found


def loaded_command(stage: StageCommand) -> Any:  # noqa: ANN401 (of typer)
    """The command of a stage with its options, which run the stage and note what it did."""
    from egad.pipeline.provenance.record import run_recorded

    function = stage_function(stage.module, stage.function)
    parameters, texts = declared(function), described(function)

    def call(**words: Any) -> None:  # noqa: ANN401 (words of the command line)
        ordered = sorted(parameters, key=lambda each: each.is_settings)  # these are checked last
        given = {each.name: _value(each, words, texts) for each in ordered}
        if isinstance(told := run_recorded(function, **given), str):
            typer.echo(told)

    options = [option for each in parameters for option in _options(each, texts)]
    call.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command(help=introduction(function))(call)
    return typer.main.get_command(app)


def introduction(function: Callable[..., Any]) -> str:
    """The docstring of a function up to its sections."""
    return re.split(r"\n\n[A-Z]\w+:\n", inspect.getdoc(function) or "")[0]


def described(function: Callable[..., Any]) -> dict[str, str]:
    """What the docstring of a function says of each argument, on one line."""
    text = (inspect.getdoc(function) or "").partition("\nArgs:\n")[2]
    section = re.split(r"\n(?=\S)", text)[0]
    entries = re.findall(r"^    (\w+): (.*(?:\n {8}.*)*)", section, re.MULTILINE)
    return {name: " ".join(text.split()).removesuffix(".") for name, text in entries}


def _commands_in(path: Path) -> Iterator[tuple[str, StageCommand]]:
    """The functions of a module that are commands."""
    source = path.read_text(encoding="utf-8")
    if "@command" not in source:
        return
    for node in ast.parse(source).body:
        if not isinstance(node, ast.FunctionDef):
            continue
        for mark in node.decorator_list:
            if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "command":
                names = [ast.literal_eval(word) for word in mark.args]
                name = names[0] if names else path.stem.replace("_", "-")
                summary = (ast.get_docstring(node) or "").partition("\n")[0]
                yield name, StageCommand(path.stem, node.name, summary)


def _options(parameter: Declared, texts: Mapping[str, str]) -> list[inspect.Parameter]:
    """The options of a parameter: one, but two for a shard."""
    if parameter.is_settings:
        return [_option("settings", Annotated[str, typer.Option(help=SETTINGS)])]
    if parameter.mark(ShardOf):
        return [
            _option(name, Annotated[int, typer.Option(help=text)]) for name, text in NUMBERS.items()
        ]
    kind = list[str] if _by_name(parameter) else parameter.kind
    marks = (typer.models.OptionInfo, typer.models.ArgumentInfo)
    info = next((mark for mark in parameter.marks if isinstance(mark, marks)), typer.Option())
    info.help = info.help or texts.get(parameter.name)
    return [_option(parameter.name, Annotated[kind, info], parameter.default)]


def _option(name: str, kind: Any, default: Any = Option.empty) -> inspect.Parameter:  # noqa: ANN401
    return Option(name, Option.KEYWORD_ONLY, default=default, annotation=kind)


def _value(parameter: Declared, words: Mapping[str, Any], texts: Mapping[str, str]) -> Any:  # noqa: ANN401
    """The value of a parameter, from the words of the command line."""
    from egad.pipeline.cli.common import parse

    if parameter.is_settings:
        return parse(parameter.kind, words["settings"])
    if parameter.mark(ShardOf):
        return tuple(words[name] for name in NUMBERS)
    value = words[parameter.name]
    return files_by_name(value or [], texts[parameter.name]) if _by_name(parameter) else value


def _by_name(parameter: Declared) -> bool:
    """Whether a parameter is files by name, which may be none if it has a default."""
    return bool(parameter.kind in (dict[str, Path], dict[str, Path] | None))


def files_by_name(words: list[str], needed: str) -> dict[str, Path]:
    """Files by the names before their equals signs.

    Args:
        words: Such as `NAME=objects.parquet`.
        needed: What they should be, for error messages.

    Raises:
        UserError: One has no name.
    """
    named = [word.partition("=") for word in words]
    if wrong := [name for name, _, path in named if not path]:
        raise UserError(f"{wrong[0]!r} has no name; expected: {needed}")
    return {name: Path(path) for name, _, path in named}
