"""An object of a dataset or a mesh in 3D, with its labelled grasps."""

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad._util.progress import phase_if_slow
from egad.cli import common
from egad.errors import RejectedError, UserError, check_name
from egad.geometry import Rescale
from egad.grasps import LabelParameters
from egad_workflow.settings import select

if TYPE_CHECKING:
    from egad.report.viewer import GraspScene

log = logging.getLogger(__name__)


class ViewMesh(LabelParameters):
    """Labelled grasps of any mesh, scaled first."""

    rescale: Rescale


def view(
    item: Annotated[
        str, typer.Argument(metavar="OBJECT", help="label of an object, or a mesh file")
    ],
    gripper: Annotated[str | None, common.gripper_option(common.FIRST_TARGET)] = None,
    dataset: common.DatasetIn = common.RUN,
    units: common.Units = None,
    rule: common.Rule = None,
    out: Annotated[Path, common.out_option("page to write: .html")] = Path("view.html"),
    grasps: Annotated[
        int | None,
        typer.Option(min=1, help="number of grasps for a mesh file; default: grasp_label.grasps"),
    ] = None,
    config: common.Config = None,
) -> None:
    """Show an object in 3D with its labelled grasps, as an HTML page that works offline."""
    from egad._util.files import write_text
    from egad.io import ENDINGS, check_ending, check_unit_known
    from egad.report.viewer import page

    check_ending(out, (".html",))
    options = {"--grasps": ("grasp_label.grasps", grasps), "--rule": ("rescale.rule", rule)}
    whole = common.settings_in(config, options)
    if Path(item).suffix.lower() not in ENDINGS and not Path(item).is_file():
        for option, value in {"--rule": rule, "--units": units, "--grasps": grasps}.items():
            if value is not None:
                raise UserError(
                    f"{option} is for mesh files; the grasps of {item} were made for one size"
                )
        whole, name = common.named_gripper(whole, gripper)
        shown = from_dataset(dataset, name, item, whole.grippers[name].opening)
    else:
        check_unit_known([Path(item)], units)
        whole, name = common.gripper_in(whole, gripper or whole.targets.grippers[0])
        shown = from_mesh(Path(item), units, select(whole, ViewMesh, name))
    write_text(out, page(shown, name, whole.grippers[name]))
    free = int(shown.grasps["collision_free"].sum())
    found = shown.note or f"{len(shown.grasps)} grasps of {name}, {free} of them collision-free"
    typer.echo(f"{shown.name}: {found}, at {shown.title}; see {out}")


def from_dataset(folder: Path, gripper: str, name: str, opening: float) -> "GraspScene":
    """An object by its label, with grasps of a gripper; UserError if the opening, m, differs."""
    from egad.exchange import check_opening
    from egad.report.viewer import scene
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49
    from egad.tables.grasping import GRASPS, SCALES

    table = folder / "grasps" / f"{gripper}.parquet"
    scales = folder / "rescaled" / gripper / "scales.parquet"
    if not (folder / "objects.parquet").is_file():
        raise UserError(f"--in {folder}: no dataset here; give its folder, e.g. results/egad")
    for path in (scales, table):
        if not path.is_file():
            raise UserError(f"{path} is missing; make it with: snakemake --cores 2 {table}")
    check_opening(folder, gripper, opening)
    evaluation = folder / "eval49.parquet"
    sizes = parquet.read(scales, SCALES).set_index("label")
    labels = {str(each): str(each) for each in sizes.index}
    if evaluation.is_file():
        chosen = parquet.read(evaluation, EVAL49)
        labels = dict(zip(chosen["label"], chosen["object_label"], strict=True)) | labels
    check_name("object", name, labels, f" in {folder} for {gripper}")
    shown = scene(folder, gripper, labels[name], parquet.read(table, GRASPS))
    return replace(shown, title=_size(sizes.loc[labels[name]].to_dict()))


@phase_if_slow("sampling grasps")
def from_mesh(path: Path, units: str | None, settings: ViewMesh) -> "GraspScene":
    """A mesh file, repaired and scaled to the gripper, with newly labelled grasps."""
    from egad.geometry import ENLARGED, center_of_mass, rescale, units_doubt
    from egad.geometry.repair import repaired_mesh
    from egad.grasps.sampling import Labeller
    from egad.io import read_mesh
    from egad.random import generator
    from egad.report.viewer import GraspScene
    from egad.tables import parquet
    from egad.tables.grasping import GRASPS

    rule = settings.rescale
    try:
        given = read_mesh(path, units)
        if doubt := units_doubt({path.name: float(given.extents.max())}, units):
            log.warning("%s", doubt)
        solid = repaired_mesh(given, path.stem)
        mesh, row = rescale(solid, rule.rule, settings.gripper.opening, rule.side_fraction)
    except RejectedError as reason:
        raise UserError(f"{path}: {reason}") from reason
    if row["factor"] > ENLARGED:
        log.warning(
            "%s is enlarged before it is shown and grasped; --rule none keeps its real size", path
        )
    title = _size(row)
    rng = generator(settings.seed, "grasps", path.stem)
    try:
        rows, _, note = Labeller(settings)(mesh, center_of_mass(mesh), rng)
    except RejectedError as reason:
        note = str(reason)
    shown = parquet.empty(GRASPS) if note else rows
    return GraspScene(path.stem, title, mesh, shown, note)


def _size(row: Mapping[Any, Any]) -> str:
    """The size that grasps are for, from columns of `tables.grasping.SCALES`."""
    from egad.geometry import size_text

    sides = [row[f"after_{number}"] for number in (1, 2, 3)]
    return f"{size_text(sides, row['factor'])} (rule {row['rule']})"
