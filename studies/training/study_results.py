"""What the networks of the study did, and how they were trained, from the files of its results."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from study import Network, Plan
from study_page import Images, Training, object_sides
from study_tables import CLEARED, COMPARED

from egad.bench.stats import read
from egad.learning.images import files
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import EVAL49
from egad.tables.grasping import SCALES
from egad.tables.training import HISTORY, SCORE


def made_by(found: list[Network], references: list[str]) -> dict[str, Network]:
    """Networks by name of the detector; references stand for themselves, with no training set."""
    return {each.name: each for each in found} | dict.fromkeys(references, Network("", 0))


def all_attempts(made: Path, detectors: Mapping[str, Network], plan: Plan) -> pd.DataFrame:
    """The attempts of these detectors in all tests with single objects, columns of `COMPARED`."""
    parts = [
        attempts(made / "trials" / test / noise / f"{name}.parquet", test, noise, network)
        for test in plan.tests
        for noise in plan.noise
        for name, network in detectors.items()
    ]
    return pd.concat(parts, ignore_index=True)


def all_cleared(made: Path, detectors: Mapping[str, Network], plan: Plan) -> pd.DataFrame:
    """Their attempts in all scenes of several objects, columns of `CLEARED`."""
    parts = [
        cleared_tables(made / "clutter" / test / f"{name}.parquet", test, network)
        for test in (plan.tests if plan.clutter else ())
        for name, network in detectors.items()
    ]
    return pd.concat([parquet.empty(CLEARED), *parts], ignore_index=True)


def attempts(path: Path, test: str, noise: str, network: Network) -> pd.DataFrame:
    """The attempts at single objects of one detector, columns of `COMPARED`."""
    table = read(path)[path.stem].assign(test=test, noise=noise, **network._asdict())
    return table.loc[:, list(COMPARED.names)]


def cleared_tables(path: Path, test: str, network: Network) -> pd.DataFrame:
    """The attempts of one detector in scenes of several objects, columns of `CLEARED`."""
    table = parquet.read(path, CLUTTER).assign(test=test, detector=path.stem, **network._asdict())
    return table.loc[:, list(CLEARED.names)]


def sides_of(dataset: Path, gripper: str) -> dict[str, list[float]]:
    """The sides of each object of a test, metres, by label; from the dataset's results."""
    chosen = parquet.read(dataset / "eval49.parquet", EVAL49)
    return object_sides(
        chosen, parquet.read(dataset / "rescaled" / gripper / "scales.parquet", SCALES)
    )


def widths_of(dataset: Path, gripper: str) -> dict[str, float]:
    """The shortest side of each object of a test, metres, by label."""
    return {label: sides[0] for label, sides in sides_of(dataset, gripper).items()}


def images_of(made: Path, name: str, plan: Plan) -> Images:
    """The images of the split train that the networks of a set are trained on."""
    objects: set[tuple[str, str]] = set()
    count = 0
    for source in plan.image_sets(name):
        dataset = str(plan.training_sets[source].dataset)
        for path in files(made / "images" / source):
            for rows in parquet.batches(path, ["objects", "split"]):
                train = rows.loc[rows["split"] == "train", "objects"]
                objects |= {(dataset, name) for names in train for name in names}
                count += len(train)
    return Images(frozenset(objects), count)


def training_of(folder: Path) -> Training:
    """How the network in a folder was trained."""
    score = parquet.records(parquet.read(folder / "score.parquet", SCORE))[0]
    return Training(parquet.read(folder / "history.parquet", HISTORY), score)
