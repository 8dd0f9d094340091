"""report: everything at a glance, in one HTML file."""

import platform
from importlib.metadata import version
from pathlib import Path

import pandas as pd
import pyarrow as pa

from egad import tables
from egad.exchange.meshes import read_mesh
from egad.files import write_text
from egad.progress import progress
from egad.report.data import DatasetReport, ReportData
from egad.report.page import build
from egad.report.render import png_bytes, render
from egad.settings import Settings

PACKAGES = [
    "egad",
    "snakemake",
    "numpy",
    "numba",
    "trimesh",
    "scikit-image",
    "manifold3d",
    "neat-python",
    "embreex",
    "pybullet",
    "pandas",
    "pyarrow",
]
THUMBNAIL, PORTRAIT = 96, 192


def run(settings: Settings, results: Path, out: Path) -> None:
    """Write the report of a run.

    Args:
        settings: The whole configuration.
        results: Folder of all results.
        out: The HTML file.
    """
    data = ReportData(
        settings=settings,
        comparison=tables.read(results / "comparison.parquet", tables.COMPARISON),
        datasets={name: _dataset(settings, name, results / name) for name in settings.datasets},
        versions={"python": platform.python_version()} | {name: version(name) for name in PACKAGES},
    )
    write_text(out, build(data))


def _dataset(settings: Settings, name: str, folder: Path) -> DatasetReport:
    """What was made for a dataset; only targets are taken beyond their objects."""
    objects = tables.read(folder / "objects.parquet", tables.OBJECTS)
    evolved = settings.datasets[name].source == "evolved"
    history = tables.read(folder / "history.parquet", tables.HISTORY) if evolved else None
    rejected = _rejected(
        folder, settings.targets.grippers if name in settings.targets.datasets else []
    )
    pictures = _pictures(folder / "meshes", objects["label"].tolist(), THUMBNAIL)
    if name not in settings.targets.datasets:
        return DatasetReport(objects, rejected, pictures, history=history)
    evalset = tables.read(folder / "eval49.parquet", tables.EVAL49)
    portraits = _pictures(folder / "meshes", evalset["object_label"].tolist(), PORTRAIT)
    grippers = settings.targets.grippers
    return DatasetReport(
        objects,
        rejected,
        pictures,
        history=history,
        evalset=evalset,
        evalset_pictures=dict(zip(evalset["label"], portraits.values(), strict=True)),
        grasps=_each(grippers, folder / "grasps", "{}.parquet", tables.GRASPS),
        scales=_each(grippers, folder / "rescaled", "{}/scales.parquet", tables.SCALES),
        manifests=_each(grippers, folder / "print", "{}/manifest.parquet", tables.MANIFEST),
        trials={
            (gripper, policy): tables.read(
                folder / "trials" / gripper / f"{policy}.parquet", tables.TRIALS
            )
            for gripper in grippers
            for policy in settings.targets.policies
        },
    )


def _rejected(folder: Path, grippers: list[str]) -> pd.DataFrame:
    """What was left out of a dataset, and of what was made of it for grippers."""
    frames = [tables.read(folder / "rejected.parquet", tables.REJECTED)]
    for gripper in grippers:
        for path in (f"rescaled/{gripper}/rejected.parquet", f"grasps/{gripper}.rejected.parquet"):
            left_out = tables.read(folder / path, tables.REJECTED)
            frames.append(left_out.assign(stage=left_out["stage"] + f" {gripper}"))
    return pd.concat(frames, ignore_index=True)


def _pictures(meshes: Path, labels: list[str], size: int) -> dict[str, bytes]:
    return {
        label: png_bytes(render(read_mesh(meshes / f"{label}.obj", "m"), size))
        for label in progress(labels, "drawing", len(labels))
    }


def _each(
    grippers: list[str], folder: Path, pattern: str, schema: pa.Schema
) -> dict[str, pd.DataFrame]:
    """One table a gripper."""
    return {gripper: tables.read(folder / pattern.format(gripper), schema) for gripper in grippers}
