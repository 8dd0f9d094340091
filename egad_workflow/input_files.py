"""Whether the files and folders that a configuration names can be read, before anything runs."""

import hashlib
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from pathlib import Path

from egad.detectors import DetectorConfig, fingerprint
from egad.errors import TableError, UserError
from egad.exchange import NamedGripper, check_format, files_of_grasps
from egad.grasps.samplers import check_sampler
from egad.grippers import Gripper, files_of
from egad.io import EVERY_FILE, check_unit_known, checksum, mesh_files
from egad.plugins import source_hash
from egad.tables.evolution import GENOME
from egad.tables.parquet import check_columns
from egad_workflow.datasets import DatasetSection
from egad_workflow.settings import Settings

MAX_LINES = 10


def check_input_files(settings: Settings) -> None:
    """Open all that datasets and targets read; a `UserError` has a line for each problem."""
    problems: dict[str, None] = {}
    for where, check in _checks(settings):
        try:
            check()
        except (TableError, UserError) as error:
            prefix = f"{where}: " if where else ""
            problems |= dict.fromkeys(f"{prefix}{line}" for line in str(error).split("\n"))
    if problems:
        raise UserError("\n".join(problems))


def _checks(settings: Settings) -> Iterator[tuple[str, Callable[[], object]]]:
    """The checks to make, each with its key in the configuration; empty if the error says it."""
    for name, dataset in settings.datasets.items():
        yield f"datasets.{name}", partial(_check_dataset, dataset)
    for key in ("envelope", "keep_solid", "hole"):
        if file := getattr(settings, key).mesh:
            yield f"{key}.mesh", partial(check_readable, [Path(file)])
    for measure in settings.measures.functions().values():
        yield "", partial(source_hash, measure, "measures")
    targets = settings.targets
    for name in dict.fromkeys([*targets.detectors, *targets.clutter, *targets.failures]):
        detector = settings.detectors[name]
        where = f"detectors.{name}" if detector.known_grasps else ""
        yield where, partial(_check_detector, detector)
    for name in dict.fromkeys([settings.graspability.gripper, *settings.targets.grippers]):
        yield f"grippers.{name}", partial(_check_gripper, settings.grippers[name])
    for name in settings.targets.grippers:
        hand = NamedGripper(name, settings.grippers[name])
        for style in settings.targets.exports:
            yield "targets.exports", partial(check_format, style, hand)


def is_result(file: str) -> bool:
    """Whether a file is one that a workflow makes."""
    return file.startswith("results/")


def _check_detector(detector: DetectorConfig) -> None:
    made = detector.weights and is_result(detector.weights)
    if not made or Path(str(detector.weights)).is_file():
        fingerprint(detector)
    if detector.known_grasps:
        files_of_grasps(detector.known_grasps)


def _check_dataset(dataset: DatasetSection) -> None:
    if dataset.folder is not None:
        folder = Path(dataset.folder)
        files = mesh_files(folder, dataset.pattern or EVERY_FILE)
        check_readable(files)
        check_unit_known(files, dataset.units)
    if dataset.selection == "labels":
        check_readable([Path(str(dataset.evaluation_set))])
    if dataset.archive not in (None, "released"):
        check_readable([Path(dataset.archive)])
        check_columns(Path(dataset.archive), ["id", *GENOME.names, "voxels"])


def _check_gripper(gripper: Gripper) -> None:
    check_readable(files_of(gripper))
    check_sampler(gripper)


def check_readable(files: Iterable[Path]) -> None:
    """Open files; a `UserError` has a line for each that cannot be opened."""
    lines = [f"{path} {reason}" for path in files if (reason := _unreadable(path))]
    more = len(lines) - MAX_LINES
    if lines:
        end = [f"and {more} more files cannot be read"] if more > 0 else []
        raise UserError("\n".join([*lines[:MAX_LINES], *end]))


def _unreadable(path: Path) -> str:
    """Why a file cannot be read; empty if it can."""
    try:
        with path.open("rb"):
            return ""
    except FileNotFoundError:
        if path.is_symlink():
            return f"is a link to {path.readlink()}, which does not exist"
        return "does not exist"
    except OSError as error:
        return f"cannot be read: {error.strerror}"


def contents(files: Iterable[str]) -> str:
    """A checksum of inputs that are not results; an older file may have replaced them."""
    return _contents(tuple(file for file in files if not is_result(file)))


@cache
def _contents(files: tuple[str, ...]) -> str:
    sums = [checksum(Path(file)) for file in files if Path(file).exists()]
    return hashlib.sha256("".join(sums).encode()).hexdigest()[:16]
