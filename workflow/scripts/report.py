"""report: an overview of all results, in one HTML file."""

import logging
import platform
from contextlib import suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
from PIL import Image

from egad._util.arrays import RgbImage
from egad._util.files import write_text
from egad._util.progress import phase, progress
from egad._util.workers import Mapper, workers
from egad.bench import ClutterParameters, picture_of, rounds_of
from egad.exchange import model_in, rows_by_id
from egad.io import read_mesh
from egad.report.pictures import png_bytes, render
from egad.report.space_map import shown_objects
from egad.report.summary import MOST_SHOWN, name_stages
from egad.report.viewer import scenes
from egad.sim.world import UnstableError
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import AGREEMENT, EVAL49, MANIFEST, TRIALS
from egad.tables.evolution import HISTORY
from egad.tables.grasping import GRASPS, SCALES, SIZE_EFFECT
from egad.tables.objects import COMPARISON, OBJECTS, REJECTED
from egad_workflow.job import run_job
from egad_workflow.report_page import ByDetector, DatasetReport, ReportData, build, is_listed
from egad_workflow.settings import Settings, select

log = logging.getLogger(__name__)
PACKAGES = (
    *("egad", "snakemake", "numpy", "numba", "trimesh", "scikit-image", "manifold3d"),
    *("neat-python", "embreex", "pybullet", "mujoco", "drake", "pandas", "pyarrow"),
)
THUMBNAIL, PORTRAIT = 96, 192
SHOWN = 4  # scenes of clutter of each kind


def run(settings: Settings, results: Path, out: Path, jobs: int = 1) -> None:
    """Write the report: one HTML file that works offline."""
    with workers(jobs) as mapper:
        datasets = {
            name: _dataset(settings, name, results / name, mapper) for name in settings.datasets
        }
    phase("drawing figures and putting the page together")
    data = ReportData(
        settings=settings,
        comparison=parquet.read(results / "comparison.parquet", COMPARISON),
        datasets=datasets,
        versions=versions(),
    )
    write_text(out, build(data))


def _dataset(settings: Settings, name: str, folder: Path, mapper: Mapper) -> DatasetReport:
    """What was made for a dataset; apart from its objects, only targets are included."""
    objects = parquet.read(folder / "objects.parquet", OBJECTS)
    evolved = settings.datasets[name].source == "evolved"
    history = parquet.read(folder / "history.parquet", HISTORY) if evolved else None
    listed = is_listed(settings, name, objects)
    rejected = name_stages(_rejected(settings, name, folder))
    if settings.datasets[name].source == "meshes":
        _warn(name, rejected)
    shown = objects["label"].tolist() if listed else shown_objects(objects)
    pictures = _pictures(folder / "meshes", shown, THUMBNAIL, mapper)
    if name not in settings.targets.datasets:
        return DatasetReport(objects, rejected, pictures, history=history)
    evalset = parquet.read(folder / "eval49.parquet", EVAL49)
    names = {} if listed else dict(zip(evalset["label"], evalset["object_label"], strict=True))
    portraits = _pictures(folder / "meshes", list(names.values()), PORTRAIT, mapper)
    targets, grippers = settings.targets, settings.targets.grippers

    def each(pattern: str, schema: pa.Schema, wanted: bool = True) -> dict[str, pd.DataFrame]:
        chosen = grippers if wanted else []
        return {name: parquet.read(folder / pattern.format(name), schema) for name in chosen}

    def tried(gripper: str, kind: str, schema: pa.Schema, detectors: list[str]) -> ByDetector:
        tables = {name: folder / kind / gripper / f"{name}.parquet" for name in detectors}
        return {name: parquet.read(path, schema) for name, path in tables.items()}

    grasps = each("grasps/{}.parquet", GRASPS)
    cleared = grippers if targets.clutter else []
    return DatasetReport(
        objects,
        rejected,
        pictures,
        history=history,
        evalset=evalset,
        evalset_pictures={name: portraits[label] for name, label in names.items()},
        grasps=grasps,
        scales=each("rescaled/{}/scales.parquet", SCALES),
        size_effects=each("size_effect/{}.parquet", SIZE_EFFECT),
        scenes=scenes(folder, grippers[0], evalset, grasps[grippers[0]]),
        manifests=each("print/{}/manifest.parquet", MANIFEST),
        trials={
            (gripper, detector): table
            for gripper in grippers
            for detector, table in tried(gripper, "trials", TRIALS, targets.detectors).items()
        },
        clutter={name: tried(name, "clutter", CLUTTER, targets.clutter) for name in cleared},
        clutter_pictures={
            name: scene_pictures(
                select(settings, ClutterParameters, name), folder / "bundle" / name
            )
            for name in cleared
        },
        agreement=each("agreement/{}.parquet", AGREEMENT, targets.agreement),
    )


def scene_pictures(settings: ClutterParameters, bundle: Path) -> dict[str, list[bytes]]:
    """PNGs of the initial scenes of the first rounds that can be simulated, by kind."""
    models = {name: model_in(bundle, row) for name, row in rows_by_id(bundle).items()}
    found: dict[str, list[bytes]] = {}
    for this in rounds_of(list(models), settings):
        if this.number < SHOWN and this.noise == settings.clutter.noises[0]:
            with suppress(UnstableError):
                found.setdefault(this.scene, []).append(_png(picture_of(this, models, settings)))
    return found


def _png(picture: RgbImage) -> bytes:
    height, width = picture.shape[:2]
    small = Image.fromarray(picture).resize((width // 2, height // 2))
    return png_bytes(np.asarray(small.convert("RGBA")))


def versions() -> dict[str, str]:
    """Versions of Python and of those `PACKAGES` that are installed."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):  # one of the physics engines may be missing
            found[name] = version(name)
    return found


def _rejected(settings: Settings, name: str, folder: Path) -> pd.DataFrame:
    """What was left out of a dataset, of its evaluation set, and of the results for grippers."""
    frames = [parquet.read(folder / "rejected.parquet", REJECTED)]
    if name not in settings.targets.datasets:
        return frames[0]
    frames.append(parquet.read(folder / "eval49.rejected.parquet", REJECTED))
    for gripper in settings.targets.grippers:
        tables = [
            parquet.read(folder / path, REJECTED)
            for path in (
                f"rescaled/{gripper}/rejected.parquet",
                f"grasps/{gripper}.rejected.parquet",
                f"bundle/{gripper}/rejected.parquet",
            )
        ]
        manifest = parquet.read(folder / "print" / gripper / "manifest.parquet", MANIFEST)
        unprinted = manifest[manifest["plate"].isna()]
        tables.append(unprinted[["id"]].assign(stage="print-export", reason=unprinted["note"]))
        frames += [table.assign(stage=table["stage"] + f" {gripper}") for table in tables]
    return pd.concat(frames, ignore_index=True)


def _warn(name: str, rejected: pd.DataFrame) -> None:
    """Tell the user at the terminal which meshes were left out of what, and why."""
    for row in rejected.head(MOST_SHOWN).to_dict("records"):
        log.warning("%s: %s: left out of %s: %s", name, row["id"], row["stage"], row["reason"])
    if (more := len(rejected) - MOST_SHOWN) > 0:
        log.warning("%s: %d more lines like these are in the report", name, more)


def _pictures(meshes: Path, labels: list[str], size: int, mapper: Mapper) -> dict[str, bytes]:
    """A PNG of each object, by its label."""
    drawn = mapper(partial(_picture, size=size), [meshes / f"{label}.obj" for label in labels])
    return dict(zip(labels, progress(drawn, "drawing", len(labels)), strict=True))


def _picture(path: Path, size: int) -> bytes:
    return png_bytes(render(read_mesh(path, "m"), size))


if __name__ == "__main__":
    run_job(run)
