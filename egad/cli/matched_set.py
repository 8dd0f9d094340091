"""Failures of a detector with similar objects that it grasps, ready to print."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli import common
from egad.cli.log_sheet import log_sheet
from egad.errors import UserError

if TYPE_CHECKING:
    from egad.bench.failures import FailureAtlas
    from egad_workflow.settings import Settings


def matched_set(
    atlas: Annotated[
        Path, typer.Argument(help="folder of an atlas of failures, see `egad.find_failures`")
    ],
    detector: Annotated[
        str, typer.Option(help="the detector of the atlas, as in `egad benchmark`")
    ],
    out: common.OutFolder,
    weights: common.Weights = None,
    command: common.Command = None,
    gripper: Annotated[str, common.gripper_option(opening=False)] = "panda",
    pairs: Annotated[
        int,
        typer.Option(
            min=1, max=10, help="number of pairs, each a failure and an object that is grasped"
        ),
    ] = 5,
    attempts: Annotated[
        int, typer.Option(min=1, help="simulated attempts at each object in each physics engine")
    ] = 20,
    within: Annotated[
        int,
        typer.Option(
            min=1, help="maximum distance of a partner in complexity and in graspability, cells"
        ),
    ] = 2,
    succeeds: Annotated[
        float,
        typer.Option(
            min=0.05, max=1, help="minimum success rate of the detector at a partner, 0.05 to 1"
        ),
    ] = 0.8,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Pair failures with similar objects that are grasped: plates, bundle, datasheet, log sheet."""
    from egad.bench.failures import FailureAtlas, match_failures
    from egad.cli.matched_folder import write_matched_set
    from egad_workflow.provenance import recorded

    common.check_spare(out, [atlas / "failures.parquet"], "pairs.parquet")
    known = FailureAtlas.load(atlas)
    settings = common.settings_in(config)
    settings, hand, name = _of_atlas(known, settings, gripper, detector, weights, command)
    found = match_failures(
        known,
        settings.detectors[name],
        pairs=pairs,
        attempts=attempts,
        within=within,
        succeeds=succeeds,
        jobs=jobs,
    )
    inputs = [atlas / f"{table}.parquet" for table in ("failures", "examined", "attempts")]
    arguments = {"gripper": hand, "detector": name, "pairs": pairs, "attempts": attempts}
    arguments |= {"within": within, "succeeds": succeeds}
    with recorded("matched-set", settings=settings, inputs=inputs, arguments=arguments):
        write_matched_set(settings, hand, found, name, out, jobs)
    typer.echo(str(found))
    if len(found) < pairs:
        typer.echo(f"fewer pairs than {pairs}: {found.unmatched} failures have no partner")
    typer.echo(f"the chosen objects, and how often each is held: {out / 'eval49/README.md'}")
    page = [out / "log.html"]
    log_sheet(out, name, gripper, out=page, seed=settings.seed, rounds=True, config=config)


def _of_atlas(
    atlas: "FailureAtlas",
    settings: "Settings",
    gripper: str,
    detector: str,
    weights: Path | None,
    command: str | None,
) -> tuple["Settings", str, str]:
    """The settings that the search of an atlas had, and the names of its hand and detector."""
    settings, hand = common.gripper_in(settings, gripper)
    settings, name = common.detector_in(settings, detector, weights, command)
    searched = atlas.searched_with()
    if settings.grippers[hand] != searched.gripper:
        raise UserError(f"--gripper {gripper}: the failures were found with another gripper")
    kept = {"seed": searched.seed, "rescale": searched.rescale, "shape": atlas.shape}
    return settings.model_copy(update=kept), hand, name
