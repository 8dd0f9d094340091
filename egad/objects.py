"""Datasets of objects in Python: the released one, those of a run, any archive, or meshes."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import NamedTuple, overload

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Flags
from egad._util.display import facts_html, table_html
from egad._util.files import as_path
from egad.data import evaluation_set, released, released_ancestry, released_simulated
from egad.errors import RejectedError, UserError, check_name
from egad.evolution import (
    Archive,
    Lineage,
    Row,
    Shape,
    check_regrown,
    check_resolution,
    genome_mesh,
    packed_surface,
    unpack,
)
from egad.geometry import SIDE_FRACTION, check_units, rescale, wind_outwards
from egad.geometry.repair import repair_for_files
from egad.grippers import Gripper
from egad.io import read_mesh
from egad.measures import labels
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, GENOME, LINEAGE
from egad.tables.grasping import ANTIPODAL_RATES
from egad.tables.objects import OBJECTS

RELEASED, EVALUATION_SET = "released", "evaluation-set"
FACTS = {
    "complexity": "{:.3f} bit",
    "graspability": "{:.4g}",
    "cell_confidence": "{:.3f}",
    "diversity": "{:.3f}",
}


class EvolvedObject:
    """One object of a dataset.

    Attributes:
        id: Hash of its voxels, or the name of its mesh file.
        label: Its name in the dataset: `M14_3` is the fourth object of cell (14, M).
        row: Its row of the table of the dataset.
        shape: How its genome was turned into voxels, and the voxels into a mesh.
    """

    def __init__(
        self, row: pd.Series, meshes: Path | None, elite: pd.Series | None, shape: Shape
    ) -> None:
        """Made by `Dataset`."""
        self.id, self.label, self.row = str(row["id"]), str(row["label"]), row
        self._meshes, self._elite, self.shape = meshes, elite, shape

    def __repr__(self) -> str:
        return f"EvolvedObject({self.label!r})"

    def _repr_html_(self) -> str:
        facts = {
            name.replace("_", " "): form.format(self.row[name])
            for name, form in FACTS.items()
            if name in self.row
        }
        try:
            return facts_html(self.label, facts, self.mesh)
        except UserError as error:  # the dataset is broken; the measures are there
            return facts_html(self.label, facts | {"mesh": str(error)})

    @cached_property
    def mesh(self) -> trimesh.Trimesh:
        """The closed surface, in metres, in single precision: the same in every format in metres.

        Raises:
            UserError: The mesh file of a dataset folder is missing or damaged.
        """
        if self._meshes is not None:
            path = self._meshes / f"{self.label}.obj"
            try:
                return read_mesh(path, "m")
            except RejectedError as reason:  # the dataset is broken, not the object
                raise UserError(f"{path}: {reason}") from reason
        return repair_for_files(packed_surface(self._evolved["voxels"], self.shape)).mesh

    def mesh_at(self, resolution: int) -> trimesh.Trimesh:
        """The closed surface at another resolution of its voxels, in metres.

        At the resolution of the archive it is made from the voxels there, as `mesh` is. At others,
        the genome is evaluated again; see `egad.genome_mesh`.

        Args:
            resolution: Voxels along each side of the cube, 8 to 200.

        Raises:
            UserError: The object comes from a mesh, or was evolved within constraints, or the
                resolution is out of range.
            RejectedError: Nothing is left of it at this resolution.
        """
        check_resolution(resolution)
        if resolution == self.shape.resolution:
            return repair_for_files(packed_surface(self._evolved["voxels"], self.shape)).mesh
        try:
            check_regrown(self.genome, self.voxels, self.shape.threshold)
        except UserError as error:
            raise UserError(f"{self.label}: {error}") from error
        return repair_for_files(genome_mesh(self.genome, resolution, shape=self.shape)).mesh

    @cached_property
    def voxels(self) -> Flags:
        """Which cells of the cube are solid, (r, r, r); `UserError` if it comes from a mesh."""
        return unpack(self._evolved["voxels"], self.shape.resolution)

    @cached_property
    def genome(self) -> Row:
        """The CPPN, columns of `tables.evolution.GENOME`; `UserError` if it comes from a mesh."""
        return {name: self._evolved[name] for name in GENOME.names}

    @property
    def _evolved(self) -> pd.Series:
        if self._elite is None:
            raise UserError(f"{self.label} comes from a mesh: it has no voxels and no genome")
        return self._elite


Some = NDArray[np.bool_ | np.str_] | pd.Series | pd.Index | list[bool] | list[str]


class Dataset:
    """Objects by label or id. Meshes are made or read when they are asked for.

    Attributes:
        table: One row per object, sorted by label unless `select` gave them another order.
        shape: How genomes were turned into voxels, and the voxels into meshes.
    """

    def __init__(
        self,
        table: pd.DataFrame,
        archive: pd.DataFrame | None,
        shape: Shape,
        meshes: Path | None,
        ancestry: Path | None,
    ) -> None:
        """Made by `load`."""
        self.table = table
        self._archive = None if archive is None else archive.set_index("id", drop=False)
        self.shape, self._meshes, self._ancestry = shape, meshes, ancestry
        self._place = {str(name): i for key in ("id", "label") for i, name in enumerate(table[key])}

    def __len__(self) -> int:
        return len(self.table)

    def __iter__(self) -> Iterator[EvolvedObject]:
        return map(self._object, range(len(self)))

    def __contains__(self, name: object) -> bool:
        return name in self._place

    @overload
    def __getitem__(self, chosen: str) -> EvolvedObject: ...

    @overload
    def __getitem__(self, chosen: Some) -> "Dataset": ...

    def __getitem__(self, chosen: str | Some) -> "EvolvedObject | Dataset":
        """One object, or a dataset of some of the objects.

        `objects["M14_3"]` is an object; `objects[["M14_3", "E08_0"]]` is a dataset, and so is
        `objects[objects.table["complexity"] > 3]`.

        Args:
            chosen: A label or an id; several of them, as for `select`; or a mask in the order of
                `table`: a column of booleans derived from it, or (n,) booleans.

        Raises:
            UserError: There is no such object (the text names similar labels), there is not one
                boolean for each object, or `chosen` is something else, such as a position.
        """
        if isinstance(chosen, str) or not isinstance(chosen, Iterable):
            return self._object(self._position(chosen))
        given = chosen if isinstance(chosen, pd.Series) else pd.Series(list(chosen), dtype=object)
        if pd.api.types.infer_dtype(given, skipna=True) == "boolean":
            return self._taken(np.flatnonzero(self._mask(given)).tolist())
        return self.select(given)

    def __repr__(self) -> str:
        return f"Dataset({len(self)} objects)"

    def _repr_html_(self) -> str:
        shown = self.table.set_index("label")
        return table_html(repr(self), shown[[name for name in FACTS if name in shown]])

    def select(self, names: str | Iterable[str]) -> "Dataset":
        """A dataset of only some of the objects.

        Args:
            names: Labels or ids, or a single one. The new dataset keeps their order; repeated names
                are left out.

        Raises:
            UserError: One of the names is unknown.
        """
        wanted = names if isinstance(names, Iterable) and not isinstance(names, str) else [names]
        return self._taken(list(dict.fromkeys(map(self._position, wanted))))

    def _taken(self, positions: list[int]) -> "Dataset":
        """The dataset of the objects in some rows."""
        table = self.table.iloc[positions].reset_index(drop=True)
        return Dataset(table, self._archive, self.shape, self._meshes, self._ancestry)

    @property
    def archive(self) -> pd.DataFrame:
        """Columns of `tables.evolution.ARCHIVE`; `UserError` if the objects come from meshes."""
        if self._archive is None:
            raise UserError("these objects come from meshes: they have no voxels and no genomes")
        return self._archive.loc[self.table["id"]].reset_index(drop=True)

    @cached_property
    def lineage(self) -> Lineage:
        """Parents, children and families of the objects, by their ids.

        It also holds the ancestors, which need not be objects of the dataset. Objects that come
        from the released archive have the lineage that egad ships.

        Raises:
            UserError: The dataset is an archive that is not a file.
        """
        if self._ancestry is None:
            raise UserError(
                "an archive returned by `egad.evolve` has no lineage; that of a run has one"
            )
        return Lineage(parquet.read(self._ancestry, LINEAGE))

    def _mask(self, given: pd.Series) -> Flags:
        """Booleans, (n,); UserError if too many or few, some missing, or of other rows."""
        rows = self.table.index
        if len(given) != len(rows):
            raise UserError(f"got {len(given)} booleans for {len(rows)} objects")
        if given.isna().any():
            raise UserError("booleans that select objects must be true or false; some are missing")
        if not given.index.equals(rows):
            if not (given.index.is_unique and given.index.isin(rows).all()):
                raise UserError(
                    "the booleans belong to rows of another table; "
                    "make them from `dataset.table`, or give an array"
                )
            given = given.reindex(rows)
        return given.to_numpy(dtype=bool)

    def _position(self, name: object) -> int:
        if not isinstance(name, str):
            raise UserError(
                f"an object is selected by its label or id, got {name!r}; "
                "`dataset.table` lists them, and `list(dataset)` has all objects by position"
            )
        if name not in self._place:
            check_name("object", name, self.table["label"])
        return self._place[name]

    def _object(self, place: int) -> EvolvedObject:
        row = self.table.iloc[place]
        elite = None
        if self._archive is not None and row["id"] in self._archive.index:
            elite = self._archive.loc[row["id"]]
        return EvolvedObject(row, self._meshes, elite, self.shape)


def load(source: str | Path | Archive = RELEASED) -> Dataset:
    """Load objects.

    A label names the cell that an object has in this source. The pipeline measures objects again,
    with other grasps than evolution used. Some objects of `results/egad` therefore have another
    label than in the archive that they come from, and the same label may name another object. The
    id of an object stays the same.

    Args:
        source: `released`: the archive that egad ships, whose table also has
            `antipodal_success_rate` and `held_shaking` (docs/released.md); `evaluation-set`: the 49
            of them that detectors are tested on, with the labels A0 to G6; the folder of a dataset,
            such as `results/egad`; a file `archive.parquet`; or an archive that `egad.evolve`
            returned.

    Raises:
        UserError: There is no such file or folder, or it is not a path.
        TableError: A table is damaged or of another version.
    """
    if isinstance(source, Archive):
        return dataset_of(source.to_frame(), Shape())
    if source == EVALUATION_SET:
        return _evaluation_set()
    path = released() if source == RELEASED else as_path("source", source)
    if path.is_dir() and (path / "objects.parquet").is_file():
        archive = path / "archive.parquet"
        elites = parquet.read(archive, ARCHIVE) if archive.is_file() else None
        shape = _shape(archive) if elites is not None else Shape()
        table = parquet.read(path / "objects.parquet", OBJECTS)
        return Dataset(table, elites, shape, path / "meshes", _ancestry(path))
    if not path.is_file():
        raise UserError(
            f"{source} is neither {RELEASED!r}, nor {EVALUATION_SET!r}, nor a folder with "
            "objects.parquet, nor an archive"
        )
    dataset = dataset_of(parquet.read(path, ARCHIVE), _shape(path), _ancestry(path.parent))
    if source == RELEASED:
        rates = parquet.read(released_simulated(), ANTIPODAL_RATES).set_index("id")
        shares = rates[["antipodal_success_rate", "held_shaking"]]
        dataset.table = dataset.table.join(shares, on="id")
    return dataset


def _evaluation_set() -> Dataset:
    """The released objects that are in the evaluation set, with their labels in it."""
    path, chosen = released(), pd.read_csv(evaluation_set())
    known = load().table.set_index("id", drop=False)
    table = known.loc[chosen["id"]].assign(label=chosen["label"].to_numpy())
    elites = parquet.read(path, ARCHIVE)
    return Dataset(table.reset_index(drop=True), elites, _shape(path), None, released_ancestry())


def _ancestry(folder: Path) -> Path:
    """The ancestors of the objects of a folder: its own table, or that of the released objects."""
    path = folder / "ancestry.parquet"
    return path if path.is_file() else released_ancestry()


def dataset_of(elites: pd.DataFrame, shape: Shape, ancestry: Path | None = None) -> Dataset:
    """The objects of an archive, a table with the columns of `tables.evolution.ARCHIVE`."""
    order = ["difficulty_cell", "complexity_cell", "slot"]
    elites = elites[ARCHIVE.names].sort_values(order, ignore_index=True)
    table = elites.drop(columns=[*GENOME.names, "voxels"])
    names = labels(table["complexity_cell"], table["difficulty_cell"])
    return Dataset(table.assign(label=names), elites, shape, None, ancestry)


def _shape(archive: Path) -> Shape:
    """How the voxels of an archive become meshes, as it says itself."""
    return Shape.model_validate(parquet.notes(archive).get("shape", {}))


class NamedMesh(NamedTuple):
    """A mesh that is made when it is needed."""

    label: str
    id: str  # name of its shape, which seeds everything random about it
    mesh: Callable[[], trimesh.Trimesh]  # metres


def named_meshes(objects: Dataset | Mapping[str, trimesh.Trimesh]) -> list[NamedMesh]:
    """The objects of a dataset, or meshes by name; `UserError` if there are none."""
    if not isinstance(objects, Dataset | Mapping):
        raise UserError(_not_objects(type(objects).__name__))
    if not len(objects):
        raise UserError("there are no objects; give a dataset or meshes by name")
    if isinstance(objects, Dataset):
        return [NamedMesh(each.label, each.id, partial(getattr, each, "mesh")) for each in objects]
    for name in objects:
        if not isinstance(name, str):
            raise UserError(_not_objects(f"the name {name!r}"))
    if isinstance(objects, dict):  # a process that gets a mesh need not get all of them
        return [NamedMesh(name, name, partial(_itself, mesh)) for name, mesh in objects.items()]
    return [NamedMesh(name, name, partial(objects.__getitem__, name)) for name in objects]


def _not_objects(given: str) -> str:
    return (
        "objects must be a dataset, as `egad.load` and `dataset.select` return, or a dictionary of "
        f"meshes by name, such as {{'mug': mesh}}; got {given}"
    )


def scaled_solid(target: NamedMesh, gripper: Gripper, rule: str) -> trimesh.Trimesh:
    """A mesh as it is grasped: closed, wound outwards and scaled, metres; or `RejectedError`."""
    mesh = target.mesh()
    check_units(mesh, f"the mesh {target.label!r}")
    solid = wind_outwards(mesh)
    return rescale(solid, rule, gripper.opening, SIDE_FRACTION)[0]


def _itself(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    return mesh
