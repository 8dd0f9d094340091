"""The folder of a matched set: a dataset with an evaluation set, its prints and its datasheet."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.failures import MatchedSet
from egad.bench.failures.matched_page import introduction
from egad.errors import RejectedError
from egad.evalset import DataSheets, PrintFiles, SelectEval, take, write_print_files
from egad.evolution import PostprocessSolids, Shape, packed_surface
from egad.exchange import RescaleMeshes, evaluation_objects, rescale_files, write_bundle
from egad.grasps import LabelParameters
from egad.grasps.sampling import dataset_grasps
from egad.io import read_mesh, write_meshes
from egad.measures import CellsAndDiversities, arrange, solid_row
from egad.measures.reeb import graph as reeb
from egad.measures.reeb import similarity_matrix
from egad.report.datasheet import write_datasheet
from egad.sim import SimulationBundle
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import GRASPS
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.settings import Settings, select

ROWS = 2


def write_matched_set(
    settings: Settings, gripper: str, found: MatchedSet, detector: str, out: Path, jobs: int = 1
) -> None:
    """Write a matched set as a dataset folder, with everything that the workflow makes for one."""
    settings = settings.model_copy(
        update={
            "select_eval": SelectEval(rows=ROWS, columns=len(found)),
            "print_export": settings.print_export.model_copy(update={"engraving": True}),
            "shape": found.shape,
        }
    )
    with atomic_output(out) as folder:
        folder.mkdir()
        found.save(folder)
        notes = {"shape": found.shape.model_dump(mode="json")}
        parquet.write(found.table, ARCHIVE, folder / "archive.parquet", notes)
        objects = _write_objects(settings, found, folder, jobs)
        scaled, grasps = folder / "rescaled" / gripper, folder / "grasps" / f"{gripper}.parquet"
        meshes = sorted((folder / "meshes").glob("*.obj"))
        rescale_files(select(settings, RescaleMeshes, gripper), meshes, "m", scaled, jobs=jobs)
        _write_grasps(select(settings, LabelParameters, gripper), objects, scaled, grasps, jobs)
        evaluation, prints = folder / "eval49.parquet", folder / "print" / gripper
        write_print_files(
            select(settings, PrintFiles, gripper),
            gripper,
            evaluation,
            scaled,
            scaled / "scales.parquet",
            prints,
            grasps,
        )
        bundled = evaluation_objects(evaluation, scaled)
        bundle = folder / "bundle" / gripper
        write_bundle(select(settings, SimulationBundle), bundled, "m", bundle, jobs)
        write_datasheet(
            select(settings, DataSheets),
            out.name,
            evaluation,
            [gripper],
            [prints / "manifest.parquet"],
            [grasps],
            folder / "eval49",
            introduction(found, out.name, detector),
        )


def _write_objects(settings: Settings, found: MatchedSet, folder: Path, jobs: int) -> pd.DataFrame:
    """Write `objects.parquet`, returned, `rejected.parquet`, `meshes/`, and `eval49.parquet`."""
    work = partial(_solid, shape=found.shape, settings=select(settings, PostprocessSolids))
    records = parquet.records(found.table)
    with workers(jobs) as mapper:
        rows = list(progress(mapper(work, records), "repairing and measuring", len(records)))
    objects = arrange(pd.DataFrame(rows), select(settings, CellsAndDiversities), evolved=True)
    parquet.write(objects, OBJECTS, folder / "objects.parquet")
    parquet.write(parquet.empty(REJECTED), REJECTED, folder / "rejected.parquet")
    write_meshes(objects, folder / "meshes", jobs)
    graphs = [reeb.unpack(packed) for packed in objects["graph"]]
    distances = 1 - similarity_matrix(graphs, settings.similarity.weight)
    labels = dict(zip(found.table["id"], found.table["label"], strict=True))
    chosen = take(objects, labels, distances, settings.select_eval)
    parquet.write(chosen, EVAL49, folder / "eval49.parquet")
    return objects


def _solid(row: dict[str, Any], shape: Shape, settings: PostprocessSolids) -> dict[str, Any]:
    measured = solid_row(packed_surface(row["voxels"], shape), row["id"], settings, resample=False)
    return measured | {"archive_graspability": np.nan}


def _write_grasps(
    settings: LabelParameters, objects: pd.DataFrame, scaled: Path, out: Path, jobs: int
) -> None:
    """Write the labelled grasps of all objects; an object without grasps has no rows."""
    work = partial(_grasps, settings=settings, scaled=scaled)
    names = list(zip(objects["id"], objects["label"], strict=True))
    with workers(jobs) as mapper:
        tables = list(progress(mapper(work, names), "labelling grasps", len(names)))
    parquet.write(pd.concat(tables, ignore_index=True), GRASPS, out)


def _grasps(name: tuple[str, str], settings: LabelParameters, scaled: Path) -> pd.DataFrame:
    object_id, label = name
    try:
        mesh = read_mesh(scaled / f"{label}.obj", "m")
        found = dataset_grasps(mesh, object_id, settings)
    except RejectedError:
        return parquet.empty(GRASPS)
    return found.assign(id=object_id, label=label)
