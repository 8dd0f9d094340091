"""Declaration of the inputs, outputs and command of a stage, by its function.

    @command()
    def run(
        settings: Volumes,
        objects: Annotated[Path, Input()],
        out: Annotated[Path, Output("D/volumes.parquet", VOLUMES)],
        jobs: Jobs = 1,
    ) -> None:

A module in `egad/pipeline/stages/` with such a function is a command of `egad`. Options, help,
provenance and the manual of the results follow from its parameters and its docstring. All other
parameters are arguments, which the provenance records as well.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import typer
from pydantic import BaseModel

if TYPE_CHECKING:
    import pyarrow as pa

F = TypeVar("F", bound=Callable[..., Any])
M = TypeVar("M")


@dataclass(frozen=True)
class Input:
    """Files or folders that are read. Their hashes are recorded with the outputs.

    Attributes:
        files: Returns the files from all arguments, if they are not the value itself.
        names: For files by name, the argument under which the names are recorded; none if empty.
    """

    files: Callable[[Mapping[str, Any]], Iterable[Path]] | None = None
    names: str = ""


@dataclass(frozen=True)
class Output:
    """A file or folder that is written.

    Attributes:
        path: Where the workflow puts it in `results/`, for the manual: `D` stands for the dataset,
            `G` for the gripper, `P` for the detector. Empty for intermediate files.
        schema: The columns of a table.
        files: Names of the files in a folder that are recorded, instead of the whole folder.
    """

    path: str = ""
    schema: "pa.Schema | None" = None
    files: tuple[str, ...] = ()


@dataclass(frozen=True)
class NotNoted:
    """A parameter that does not affect the result, or is a part of an input."""


@dataclass(frozen=True)
class ShardOf:
    """The number of a shard and the number of shards, as two options."""


@dataclass(frozen=True)
class Renamed:
    """An argument that is recorded under another name."""

    name: str


Shard = Annotated[tuple[int, int], ShardOf()]
Jobs = Annotated[
    int, typer.Option(min=1, help="cores to use; results do not depend on it"), NotNoted()
]
Evaluation = Annotated[Path, typer.Option("--eval"), Input()]


@dataclass(frozen=True)
class Declared:
    """A parameter of a stage.

    Attributes:
        name: Its name.
        kind: Its type.
        marks: Its annotations.
        default: Its default; `Parameter.empty` if it has none.
    """

    name: str
    kind: Any
    marks: tuple[object, ...]
    default: Any

    def mark(self, kind: type[M]) -> M | None:
        """The first annotation of a class, if there is one."""
        return next((mark for mark in self.marks if isinstance(mark, kind)), None)

    @property
    def is_settings(self) -> bool:
        """Whether these are the settings of the stage."""
        return isinstance(self.kind, type) and issubclass(self.kind, BaseModel)

    @property
    def is_not_noted(self) -> bool:
        """Whether it does not affect the result."""
        return any(isinstance(mark, NotNoted) for mark in self.marks)

    @property
    def outputs(self) -> list[Output]:
        """The outputs that it names."""
        return [mark for mark in self.marks if isinstance(mark, Output)]


def command(name: str = "") -> Callable[[F], F]:
    """Make a function of a stage a command of `egad`.

    `egad.pipeline.cli.stages` reads this from the source, so that `egad --help` imports no stage.

    Args:
        name: Name of the command; default: that of the module.
    """
    del name
    return lambda function: function


def declared(function: Callable[..., Any]) -> list[Declared]:
    """The parameters of a stage, in their order."""
    hints = get_type_hints(function, include_extras=True)
    return [_declared(each, hints[each.name]) for each in signature(function).parameters.values()]


def settings_type(function: Callable[..., Any]) -> type[BaseModel] | None:
    """The class of the settings that a stage reads, if it reads any."""
    return next((each.kind for each in declared(function) if each.is_settings), None)


def _declared(parameter: Parameter, hint: Any) -> Declared:  # noqa: ANN401 (a type)
    kind, *marks = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    return Declared(parameter.name, kind, tuple(marks), parameter.default)
