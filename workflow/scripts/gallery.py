"""gallery: a static site with a map of the objects of a dataset and a page for each of them."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import pyarrow as pa
import trimesh

from egad._util.arrays import RgbImage
from egad._util.files import atomic_output, write_text
from egad._util.progress import progress
from egad._util.workers import Mapper, workers
from egad.errors import RejectedError
from egad.evolution import Lineage, Row, Rules, express, genome_text, packed_surface, rules_of
from egad.exchange import is_simulated
from egad.exchange.release import Gallery, file_stems
from egad.geometry.repair import repair_for_files
from egad.io import read_mesh
from egad.measures import attainable_graspability
from egad.report.axes import AxisPair, axis_pair
from egad.report.gallery.details import Download, GenomeText, ObjectPage, ancestor_data, object_data
from egad.report.gallery.files import (
    ANCESTORS,
    INDEX,
    PAGES,
    SHEETS,
    TILE,
    Place,
    ancestor_sheets,
    cell_ranks,
    data_script,
    file_link,
    sheet,
)
from egad.report.gallery.index import index_data
from egad.report.gallery.page import GalleryData, gallery_page
from egad.report.genome_drawing import genome_svg
from egad.report.pictures import render
from egad.report.space_map import legend_of
from egad.tables import parquet
from egad.tables.columns import ID, LABEL
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.evolution import GENOME, LINEAGE
from egad.tables.grasping import SCALES, SIMULATED_GRASPS
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job

POINTS = [f"{name}_{axis}" for name in ("contact0", "contact1", "approach") for axis in "xyz"]
VIEWED = ["id", "label", "quality", "robust_quality", "collision_free", *POINTS]
SIMULATED = ["simulated_outcome", "simulated_success", "simulated_engine"]


class GalleryItem(NamedTuple):
    """What is known of an object, and the file of the mesh that is shown."""

    page: ObjectPage
    mesh: Path


class Ancestor(NamedTuple):
    """An ancestor that is not released: its number, row of the lineage, and relatives."""

    number: int
    row: Mapping[str, Any]
    relatives: Mapping[str, Any] | None


class Made(NamedTuple):
    """A page as a script, and the picture for a sheet, which is None if there is no shape."""

    script: str
    picture: RgbImage | None


def run(
    settings: Gallery,
    objects: Path,
    meshes: Path,
    out: Path,
    page: Path,
    detectors: list[str] | None = None,
    trials: list[Path] | None = None,
    gripper: str = "",
    scales: Path | None = None,
    grasps: list[Path] | None = None,
    evaluation: Path | None = None,
    archive: Path | None = None,
    ancestry: Path | None = None,
    pieces: list[Path] | None = None,
    archives: list[Path] | None = None,
    jobs: int = 1,
) -> None:
    """Write a static site with a map of the objects of a dataset and a page for each of them."""
    data = GalleryData(
        objects=parquet.read(objects, OBJECTS),
        gripper=gripper,
        factors=_factors(scales),
        grasps=pd.concat(map(_grasps, grasps), ignore_index=True) if grasps else None,
        evaluation=parquet.read(evaluation, EVAL49) if evaluation else parquet.empty(EVAL49),
        trials={
            name: parquet.read(path, TRIALS)
            for name, path in zip(detectors or [], trials or [], strict=True)
        },
        lineage=Lineage(parquet.read(ancestry, LINEAGE)) if ancestry else None,
        genomes=_genomes(archive),
    )
    axes = axis_pair(settings.measures)
    scaled = scales.parent if scales else meshes
    whole, own = _links([*(pieces or []), *(archives or [])])
    items = []
    for row in parquet.records(data.objects):
        label = row["label"]
        folder = scaled if label in data.factors else meshes
        shown = replace(data.page(row), links=own.get(label, []))
        items.append(GalleryItem(shown, folder / f"{label}.obj"))
    with workers(jobs) as mapper, atomic_output(out) as folder:
        for name in (SHEETS, PAGES, ANCESTORS):
            (folder / name).mkdir(parents=True)
        _write_objects(items, settings, axes, folder, mapper)
        _write_ancestors(data, settings, axes, folder, mapper)
        measured = settings.model_copy(update={"gripper": settings.map_gripper})
        limit = attainable_graspability(measured)
        index = index_data(
            data.objects, settings.space, axes, data.member, settings.gripper, limit.rows
        )
        _write(folder, INDEX, data_script(INDEX, index))
    write_text(
        page,
        gallery_page(settings.release.title, data, axes, whole, legend_of(limit, axes.upwards)),
    )


def _factors(scales: Path | None) -> dict[str, float]:
    """Scale factors of the objects that could be scaled, by label."""
    if scales is None:
        return {}
    table = parquet.read(scales, SCALES)
    return dict(zip(table["label"], table["factor"], strict=True))


def _grasps(path: Path) -> pd.DataFrame:
    """What the gallery shows of a table of grasps."""
    names = [*VIEWED, *(SIMULATED if is_simulated(path) else [])]
    return parquet.read(path, pa.schema([SIMULATED_GRASPS.field(name) for name in names]))


def _genomes(archive: Path | None) -> pd.DataFrame:
    schema = pa.schema([ID, *GENOME])
    return parquet.read(archive, schema) if archive else parquet.empty(schema)


def _links(pieces: list[Path]) -> tuple[list[Download], dict[str, list[Download]]]:
    """Links to files of the release: of the whole dataset, and of each object by its label."""
    own: dict[str, list[Download]] = defaultdict(list)
    whole = [Download("Dataset card", "README.md")] if pieces else []
    for piece in pieces:
        if piece.suffix == ".zip":
            whole.append(Download(piece.name, file_link(piece.parent.name, piece.name)))
        for path in sorted(piece.rglob("*.glb")):
            parts = path.relative_to(piece.parent).parts
            own[path.stem].append(Download("Mesh (GLB)", file_link(*parts)))
        for path in sorted(piece.glob("grasps/*.parquet")):
            link = Download(f"Grasps, in {path.name}", file_link(piece.name, "grasps", path.name))
            for label in parquet.read(path, pa.schema([LABEL]))["label"].unique():
                own[label].append(link)
    return whole, own


def _write(folder: Path, name: str, script: str) -> None:
    path = folder / f"{name}.js"
    path.parent.mkdir(exist_ok=True)
    path.write_text(script, encoding="utf-8")


def _write_objects(
    items: list[GalleryItem], settings: Gallery, axes: AxisPair, folder: Path, mapper: Mapper
) -> None:
    """Write the pages of the objects, and the sheets of their pictures."""
    cells = settings.space.cells
    rows = pd.DataFrame([item.page.row for item in items], columns=OBJECTS.names)
    stems = file_stems(rows["label"])
    sheets: dict[int, dict[Place, RgbImage]] = defaultdict(dict)
    made = progress(
        mapper(partial(_object, settings=settings, axes=axes), items), "objects", len(items)
    )
    for item, rank, (script, picture) in zip(items, cell_ranks(rows), made, strict=True):
        row = item.page.row
        _write(folder / PAGES, stems[row["label"]], script)
        place = int(row["complexity_cell"]), cells - 1 - int(row["difficulty_cell"])
        sheets[int(rank)][place] = picture
    for rank, pictures in sheets.items():
        (folder / SHEETS / f"{rank}.webp").write_bytes(sheet(pictures, cells, cells))


def _object(item: GalleryItem, settings: Gallery, axes: AxisPair) -> Made:
    mesh = read_mesh(item.mesh, "m")
    genome = None if item.page.genome is None else _genome(item.page.genome, settings)
    content = object_data(item.page, mesh, genome, axes)
    return Made(data_script(f"{PAGES}/{item.page.row['label']}", content), render(mesh, TILE))


def _genome(row: Row, settings: Gallery) -> GenomeText:
    regions = {name: getattr(settings, name) for name in ("envelope", "keep_solid", "hole")}
    text = genome_text(row, shape=settings.shape, symmetry=settings.symmetry, regions=regions)
    return GenomeText(genome_svg(row), text)


def _write_ancestors(
    data: GalleryData, settings: Gallery, axes: AxisPair, folder: Path, mapper: Mapper
) -> None:
    """The same for the ancestors that are not released."""
    rows = parquet.records(data.ancestors)
    items = [Ancestor(i, row, data.relatives(row["id"])) for i, row in enumerate(rows)]
    work = partial(_ancestor, settings=settings, rules=rules_of(settings), axes=axes)
    stems = file_stems(str(item.number) for item in items)
    pictures: dict[int, RgbImage] = {}
    made = progress(mapper(work, items), "ancestors", len(items))
    for number, (script, picture) in enumerate(made):
        _write(folder / ANCESTORS, stems[str(number)], script)
        if picture is not None:
            pictures[number] = picture
    for number, content in enumerate(ancestor_sheets(pictures, len(items))):
        (folder / SHEETS / f"{ANCESTORS}-{number}.webp").write_bytes(content)


def _ancestor(item: Ancestor, settings: Gallery, rules: Rules, axes: AxisPair) -> Made:
    mesh = _grown(item.row, settings, rules)
    genome = _genome(item.row, settings)
    content = ancestor_data(item.row, mesh, genome, item.relatives, axes)
    script = data_script(f"{ANCESTORS}/{item.number}", content)
    return Made(script, None if mesh is None else render(mesh, TILE))


def _grown(row: Mapping[str, Any], settings: Gallery, rules: Rules) -> trimesh.Trimesh | None:
    """The surface of an ancestor; None if its genome now gives a different shape."""
    solid = express(row, settings, rules)
    if isinstance(solid, str) or solid.id != row["id"]:
        return None
    try:
        return repair_for_files(packed_surface(solid.packed, settings.shape)).mesh
    except RejectedError:
        return None


if __name__ == "__main__":
    run_job(run)
