"""Results of trials, in simulation or with a real robot: compared, reported, filmed."""

import logging
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli.common import Config, out_option, settings_in
from egad.cli.plan import plan
from egad.cli.replay import film, replay
from egad.cli.run import run
from egad.cli.validate import validate
from egad.cli.verify_trials import verify_trials
from egad.errors import UserError
from egad_workflow.settings import Settings

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)
trials = typer.Typer(
    name="trials",
    no_args_is_help=True,
    help="Grasping trials: run, compare, report, plan, validate, verify, replay, film.",
)
trials.command()(run)

Evaluation = Annotated[
    Path | None,
    typer.Option("--eval", help="eval49.parquet: graspability and complexity by object"),
]


@trials.command()
def compare(
    tables: Annotated[list[Path], typer.Argument(help="results of detectors: .parquet or .csv")],
    out: Annotated[Path | None, out_option("page to write: .html")] = None,
    evaluation: Evaluation = None,
    config: Config = None,
    sequential: Annotated[
        bool,
        typer.Option(
            "--sequential",
            help="also the test that may be repeated after every attempt; rows of a robot must be "
            "in the order of the attempts",
        ),
    ] = False,
) -> None:
    """Compare detectors on the same objects: success rates, differences, significance.

    Simulated results must be of the same evaluation set, scaled to the same gripper. Cleared tables
    must begin with the same scenes; the output says if they were cleared by different rules.
    """
    from egad.bench.stats import gather
    from egad.io import check_ending
    from egad.tables import parquet

    check_ending(out, (".html",))
    is_clutter = [path.suffix == ".parquet" and "scene" in parquet.columns(path) for path in tables]
    if any(is_clutter) and not all(is_clutter):
        one, other = (tables[is_clutter.index(kind)] for kind in (True, False))
        raise UserError(f"{one} is of cleared tables, {other} of trials: compare them separately")
    if sequential and all(is_clutter):
        raise UserError("--sequential is for trials, not for cleared tables")
    if len(tables) > 1 and all(is_clutter):
        _compare_clearing(tables, out)
        return
    chosen = _evaluation_set(evaluation)
    attempts = _of_set({} if all(is_clutter) else gather(tables), chosen)
    if len(attempts) < 2:
        raise UserError("compare needs the results of at least two detectors")
    conclusions = _tell(attempts)
    if sequential:
        _tell_sequential(attempts)
    if out is not None:
        _write(out, attempts, chosen, settings_in(config), conclusions)


@trials.command()
def report(
    table: Annotated[Path, typer.Argument(help="results: .parquet, or .csv of a real robot")],
    out: Annotated[
        list[Path], out_option("file to write: .html, .parquet or .csv; may be repeated")
    ] = [Path("trials.html")],  # noqa: B006 (typer copies it)
    evaluation: Evaluation = None,
    config: Config = None,
) -> None:
    """Report results of a detector, simulated or of a real robot, as a page or a table."""
    import pandas as pd

    from egad.bench.stats import read
    from egad.cli.table_files import write_frame
    from egad.io import check_ending
    from egad.tables.evaluation import RESULTS

    for path in out:
        check_ending(path, (".html", ".parquet", ".csv"))
    chosen, settings = _evaluation_set(evaluation), settings_in(config)
    attempts = _of_set(read(table), chosen)
    conclusions = _tell(attempts)
    for path in out:
        if path.suffix.lower() == ".html":
            _write(path, attempts, chosen, settings, conclusions)
        else:
            write_frame(pd.concat(attempts.values()), RESULTS, path)


trials.command()(plan)
trials.command()(validate)
trials.command()(replay)
trials.command()(film)
trials.command("verify")(verify_trials)


@trials.command()
def template(
    out: Annotated[Path, out_option("table to write: .csv")] = Path("results.csv"),
    evaluation: Annotated[
        Path | None,
        typer.Option("--eval", help="eval49.parquet: use its objects; default: all cells"),
    ] = None,
    detector: Annotated[str, typer.Option(help="name of the detector")] = "",
    config: Config = None,
) -> None:
    """Write a CSV file to fill in at the robot: one row per attempt, `success` is 1 or 0."""
    from egad._util.files import atomic_output
    from egad.bench.stats import template as empty
    from egad.evalset import ATTEMPTS, labels_of
    from egad.io import check_ending
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    check_ending(out, (".csv",))
    if out.exists():
        raise UserError(f"--out {out} exists and may already be filled in; give another file")
    settings = settings_in(config)
    labels = labels_of(settings.select_eval.rows, settings.select_eval.columns)
    if evaluation is not None:
        labels = parquet.read(evaluation, EVAL49)["label"].tolist()
    frame = empty(labels, ATTEMPTS, detector)
    with atomic_output(out) as temporary:
        frame.to_csv(temporary, index=False)
    typer.echo(f"{out}: {len(frame)} attempts at {len(labels)} objects")


def _compare_clearing(tables: list[Path], out: Path | None) -> None:
    """Print rates of detectors that cleared tables, and comparisons of pairs; write a page."""
    from egad._util.files import write_text
    from egad.cli.terminal_tables import cleared, clearing_compared
    from egad.report.clutter import clearing_results, page
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER

    several = len({path.stem for path in tables}) < len(tables)
    names = [str(path.with_suffix("")) if several else path.stem for path in tables]
    attempts = {name: parquet.read(path, CLUTTER) for name, path in zip(names, tables, strict=True)}
    results = clearing_results(attempts)
    cleared(results.rates, results.engines)
    if results.warning:
        typer.echo(results.warning)
    if results.pairs:
        clearing_compared(results.pairs)
        for sentence in results.conclusions:
            typer.echo(sentence)
    else:
        typer.echo("No two tables have a round in common: same scene, noise, objects and seed")
    if out is not None:
        write_text(out, page(results))


def _tell(attempts: "Mapping[str, pd.DataFrame]") -> list[str]:
    """Print success rates, and comparisons of pairs of detectors; return what these show."""
    from egad.bench.stats import conclusion, mean_rate, simulated_in
    from egad.cli.terminal_tables import compared, succeeded
    from egad.report.trials import pairs

    engines = {name: simulated_in(table) for name, table in attempts.items()}
    if len(set(filter(None, engines.values()))) > 1:
        typer.echo("Not all were simulated in the same way: see the column simulated in", err=True)
    succeeded({name: mean_rate(table) for name, table in attempts.items()}, engines)
    results = pairs(attempts)
    if results:
        compared(results)
    conclusions = [
        conclusion(
            pair.first, pair.second, pair.result, (attempts[pair.first], attempts[pair.second])
        )
        for pair in results
    ]
    for sentence in conclusions:
        typer.echo(sentence)
    return conclusions


def _tell_sequential(attempts: "Mapping[str, pd.DataFrame]") -> None:
    """Print the sequential test of pairs of detectors, simulated attempts grouped into rounds."""
    from itertools import combinations

    from egad.bench.stats import (
        NothingInCommonError,
        attempts_in_a_row,
        engine_names,
        in_rounds,
        sequential_test,
    )
    from egad.cli.terminal_tables import decided

    attempts = {
        name: in_rounds(table) if engine_names(table) else table for name, table in attempts.items()
    }
    tests = {}
    for one, other in combinations(attempts, 2):
        with suppress(NothingInCommonError):
            tests[one, other] = sequential_test(attempts[one], attempts[other])
    decided(tests)
    for name, table in attempts.items():
        if (longest := attempts_in_a_row(table)) > 2:
            typer.echo(
                f"{name}: up to {longest} attempts at one object follow each other: the result of "
                "the sequential test then holds for these objects only",
                err=True,
            )


def _evaluation_set(path: Path | None) -> "pd.DataFrame | None":
    """The table of the option `--eval`."""
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    return None if path is None else parquet.read(path, EVAL49)


def _of_set(
    attempts: "Mapping[str, pd.DataFrame]", chosen: "pd.DataFrame | None"
) -> "Mapping[str, pd.DataFrame]":
    """The attempts at objects of the evaluation set; a warning names the others."""
    if chosen is None:
        return attempts
    kept = {name: table[table["label"].isin(chosen["label"])] for name, table in attempts.items()}
    for name, table in kept.items():
        others = sorted(set(attempts[name]["label"]) - set(chosen["label"]))
        if table.empty:
            raise UserError(f"{name} has no attempt at an object of --eval")
        if others:
            log.warning("%s: not in --eval, left out: %s", name, ", ".join(others))
    return kept


def _write(
    out: Path,
    attempts: "Mapping[str, pd.DataFrame]",
    chosen: "pd.DataFrame | None",
    settings: Settings,
    conclusions: Sequence[str],
) -> None:
    from egad._util.files import write_text
    from egad.report.axes import axis_pair
    from egad.report.trials import EvaluationSet, page

    rows, columns = settings.select_eval.rows, settings.select_eval.columns
    if chosen is not None:
        rows = max(rows, int(chosen["row"].max()) + 1)
        columns = max(columns, int(chosen["column"].max()) + 1)
    evaluation_set = EvaluationSet(rows, columns, chosen, axis_pair(settings.measures))
    write_text(out, page(attempts, evaluation_set, conclusions))
