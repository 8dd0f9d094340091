"""Grasps that other programs wrote: checked, converted, and tried in simulation."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad.cli import common
from egad.errors import UserError
from egad.friction import FRICTION
from egad.grippers import GRIPPERS

if TYPE_CHECKING:
    import trimesh

    from egad.grippers import Gripper

grasps = typer.Typer(
    name="grasps", no_args_is_help=True, help="Grasps of other programs: check, convert, try."
)

File = Annotated[Path, typer.Argument(help="file of grasps")]
Mesh = Annotated[Path, typer.Option("--mesh", help="mesh file of the object")]
Hand = Annotated[str, common.gripper_option()]
FileFormat = Annotated[str | None, typer.Option("--format", help="format of the file")]
Frame = Annotated[str | None, typer.Option(help="closing axis and approach, such as 'x z'")]
Depth = Annotated[float | None, typer.Option(help="how far ahead of the poses the contacts are")]
PoseUnits = Annotated[str | None, typer.Option(help="unit of plain poses: m, cm or mm")]
REFERENCE = "text file with the (4, 4) pose of the camera or scene; `object` if it is the identity"
Reference = Annotated[Path | None, typer.Option(help=REFERENCE)]
FRICTIONS = f"friction of the fingers; may be repeated; default: {FRICTION}"
ObjectId = Annotated[str | None, typer.Option(help="object, segment or scene of the file")]
MaxFriction = Annotated[float | None, typer.Option(help="largest friction coefficient: graspnet")]


@contextmanager
def _options_named() -> Iterator[None]:
    """Errors of a command name its options where those of the library name arguments."""
    try:
        yield
    except UserError as error:
        text = str(error).replace("`units`", "--pose-units").replace("`object_id`", "--object-id")
        text = text.replace("`max_friction`", "--max-friction")
        raise UserError(re.sub("`(frame|depth|reference)`", r"--\1", text)) from error


@grasps.command()
@_options_named()
def check(
    file: File,
    mesh: Mesh,
    gripper: Hand,
    format_name: FileFormat = None,
    frame: Frame = None,
    depth: Depth = None,
    pose_units: PoseUnits = None,
    reference: Reference = None,
    object_id: ObjectId = None,
    max_friction: MaxFriction = None,
    units: common.Units = None,
    fix: Annotated[Path | None, typer.Option(help="plain poses to write, corrected: .npz")] = None,
    picture: Annotated[Path | None, typer.Option(help="ten grasps to draw: .svg")] = None,
    config: common.Config = None,
) -> None:
    """Name what is wrong with a file of grasps: axes, depth, units, frame of the object, ..."""
    from egad.exchange.checking import check_grasps
    from egad.io import check_ending

    check_ending(fix, (".npz",))
    check_ending(picture, (".svg",))
    said = _said(frame, depth, pose_units, reference, object_id, max_friction)
    (solid,), hand = _objects([mesh], units, gripper, config)
    found = check_grasps(file, solid, hand, format_name, **said)
    typer.echo(repr(found))
    if picture is not None:
        found.plot().save(picture)
    if fix is not None:
        found.save(fix)
        typer.echo(f"{fix}: the grasps as plain poses")


@grasps.command()
@_options_named()
def convert(
    file: File,
    mesh: Mesh,
    gripper: Hand,
    to: Annotated[str, typer.Option(help="format to write, as of `egad export`")],
    out: common.OutFolder,
    format_name: FileFormat = None,
    frame: Frame = None,
    depth: Depth = None,
    pose_units: PoseUnits = None,
    reference: Reference = None,
    object_id: ObjectId = None,
    max_friction: MaxFriction = None,
    units: common.Units = None,
    config: common.Config = None,
) -> None:
    """Convert labelled grasps to another format."""
    from egad.exchange.export import export_grasps
    from egad.exchange.reading import read_grasps

    (solid,), hand = _objects([mesh], units, gripper, config)
    said = _said(frame, depth, pose_units, reference, object_id, max_friction)
    read = read_grasps(file, format_name, solid, hand, **said)
    export_grasps(read, solid, to, hand, out, mesh.stem)
    typer.echo(f"{out}: {len(read)} grasps of {mesh.stem}")


@grasps.command("try")
@_options_named()
def try_files(
    files: Annotated[list[Path], typer.Argument(help="files of grasps")],
    meshes: Annotated[
        list[Path], typer.Option("--mesh", help="mesh file of the object; one for each file")
    ],
    gripper: Hand,
    n: Annotated[int, typer.Option("--n", min=1, help="grasps of a file, evenly spaced")] = 100,
    engine: Annotated[str, typer.Option(help="mujoco, pybullet or drake")] = "mujoco",
    friction: Annotated[list[float] | None, typer.Option(help=FRICTIONS)] = None,
    mass: Annotated[list[float] | None, typer.Option(help="kilograms; may be repeated")] = None,
    format_name: FileFormat = None,
    frame: Frame = None,
    depth: Depth = None,
    pose_units: PoseUnits = None,
    reference: Reference = None,
    object_id: ObjectId = None,
    max_friction: MaxFriction = None,
    units: common.Units = None,
    out: common.TableFile = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Try grasps in simulation: do the labels and scores of their files predict success?"""
    from egad.cli.table_files import write_frame
    from egad.cli.terminal_tables import terciles
    from egad.exchange.grasp_trials import try_grasps
    from egad.exchange.reading import read_grasps
    from egad.io import check_ending, object_names
    from egad.tables.columns import meaning_of
    from egad.tables.grasping import TRIED_GRASPS

    check_ending(out, (".parquet", ".csv"))
    if len(files) != len(meshes):
        raise UserError(f"--mesh is given {len(meshes)} times; allowed: once for each file")
    said = _said(frame, depth, pose_units, reference, object_id, max_friction)
    names = {path: name for name, path in object_names(meshes).items()}
    solids, hand = _objects(meshes, units, gripper, config)
    levels = {"friction": friction or FRICTION, "mass": mass or None}
    options: Any = {"engine": engine, "jobs": jobs, **levels}
    tried = []
    for file, mesh, solid in zip(files, meshes, solids, strict=True):
        read = read_grasps(file, format_name, solid, hand, **said)
        tried.append(try_grasps(read, solid, hand, n, name=names[mesh], **options))
    whole = reduce(add, tried)
    if out is not None:
        write_frame(whole.table, TRIED_GRASPS, out)
    typer.echo(repr(whole))
    for column in ("depth", "width", "friction", "mass"):
        if column in ("depth", "width") or whole.table[column].nunique() > 1:
            terciles(whole.by(column), meaning_of(TRIED_GRASPS.field(column))[1])


def _objects(
    meshes: list[Path], units: str | None, gripper: str, config: Path | None
) -> "tuple[list[trimesh.Trimesh], Gripper | str]":
    """The objects and the gripper of a command line; by its name if it is one of egad's."""
    from egad.io import check_unit_known, read_mesh

    check_unit_known(meshes, units)
    settings, name = common.gripper_in(common.settings_in(config), gripper)
    known = config is None and name in GRIPPERS
    return [read_mesh(each, units) for each in meshes], name if known else settings.grippers[name]


def _said(
    frame: str | None,
    depth: float | None,
    units: str | None,
    reference: Path | None,
    object_id: str | None,
    max_friction: float | None,
) -> Any:  # noqa: ANN401 (`egad.exchange.reading.Said`, which takes long to import)
    import numpy as np

    pose = None
    if reference is not None:
        try:
            pose = np.eye(4) if str(reference) == "object" else np.loadtxt(reference)
        except (OSError, ValueError) as error:
            raise UserError(f"--reference {reference}: no lines of numbers: {error}") from error
    named = {"frame": frame, "depth": depth, "units": units, "reference": pose}
    return named | {"object_id": object_id, "max_friction": max_friction}
