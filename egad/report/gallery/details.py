"""What the page of an object or of an ancestor shows, loaded when it is opened."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import pandas as pd
import trimesh

from egad.bench.stats import rate, wilson
from egad.evolution import Lineage
from egad.report.axes import AxisPair
from egad.report.gallery.files import rounded
from egad.report.viewer import LABELS, GraspScene, label_codes, pack
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

SHOWN = 100  # grasps of an object in the viewer
ONE_SIGMA = math.erf(math.sqrt(0.5))  # probability within one standard error of a mean
Row = Mapping[str, Any]
Relative = str | list[Any]
"""A released object by its label; an ancestor by its id and its number, which names its files."""


@dataclass(frozen=True)
class Download:
    """A file to download; its address is relative to the page."""

    text: str
    address: str


@dataclass(frozen=True)
class Relatives:
    """Who descends from whom, and the names of the pages of relatives."""

    lineage: Lineage
    labels: Mapping[str, str]  # labels of the released objects by id
    numbers: Mapping[str, int]  # numbers of the ancestors that are not released, by id

    def data(self, name: str) -> dict[str, list[Relative]]:
        """For JSON: `parents`, `children`, oldest first, and `line`, from the founder on."""
        line = self.lineage.line(name)
        return {
            "parents": self._named(self.lineage.parents(name)),
            "children": self._named(self.lineage.children(name)),
            "line": self._named(reversed(line)),
        }

    def _named(self, ids: Iterable[str]) -> list[Relative]:
        return [self.labels.get(each) or [each, self.numbers[each]] for each in ids]


@dataclass(frozen=True)
class GenomeText:
    """A genome as expressions, and as a drawing, an SVG file."""

    drawing: str
    text: str


@dataclass(frozen=True)
class ObjectPage:
    """What is known of an object, `tables.objects.OBJECTS`."""

    row: Row
    # columns of `GRASPS` or `SIMULATED_GRASPS`; None if there are no tables
    grasps: pd.DataFrame | None = None
    factor: float = 1.0  # size at which it is shown / size in the dataset
    note: str = ""  # why it has no grasps, or other remarks
    # what `Relatives.data` returned; None if there is no lineage
    relatives: Mapping[str, Any] | None = None
    genome: Row | None = None
    # attempts with the object by grasp detector: a column `success`
    trials: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    links: Sequence[Download] = ()


def object_data(
    page: ObjectPage, mesh: trimesh.Trimesh, genome: GenomeText | None, axes: AxisPair
) -> dict[str, Any]:
    """The data of an object, ready for JSON; the mesh is in metres, at the size that is shown."""
    grasps = page.grasps if page.grasps is not None else empty(GRASPS)
    counts = None if page.grasps is None else _label_counts(grasps)
    simulated = _simulated(counts) if counts else []
    scene = GraspScene(str(page.row["label"]), "", mesh, grasps.head(SHOWN))
    return {
        "id": page.row["id"],
        "facts": [*_measures(page.row, axes), *simulated, *_solid_facts(page.row, page.factor)],
        "scene": pack(scene),
        "labels": counts,
        "note": page.note,
        "relatives": page.relatives,
        "genome": genome and asdict(genome),
        "trials": [_trial(name, table) for name, table in sorted(page.trials.items())],
        "links": [[link.text, link.address] for link in page.links],
    }


def ancestor_data(
    row: Row,
    mesh: trimesh.Trimesh | None,
    genome: GenomeText,
    relatives: Mapping[str, Any] | None,
    axes: AxisPair,
) -> dict[str, Any]:
    """The data of an unreleased ancestor, `LINEAGE`, ready for JSON; mesh in metres, or None."""
    grown = [
        ("epoch", row["epoch"], None, "", 0),
        ("island", row["island"], None, "", 0),
        ("step", row["step"], None, "", 0),
    ]
    return {
        "id": str(row["id"]),
        "facts": [*_measures(row, axes), *_facts(grown)],
        "scene": mesh and pack(GraspScene(str(row["id"]), "", mesh, empty(GRASPS))),
        "labels": None,
        "note": "" if mesh else "Its shape cannot be rebuilt from its genome.",
        "relatives": relatives,
        "genome": asdict(genome),
        "trials": [],
        "links": [],
    }


Fact = tuple[str, Any, float | None, str, int]
"""Name, value, standard error, unit and decimals."""


def _facts(found: Iterable[Fact]) -> list[list[Any]]:
    """Facts whose value is known, ready for JSON."""
    return [
        [name, _number(value), rounded(error), unit, decimals]
        for name, value, error, unit, decimals in found
        if not pd.isna(value)
    ]


def _number(value: Any) -> Any:  # noqa: ANN401 (numbers and texts)
    return value if isinstance(value, str) else rounded(float(value))


def _measures(row: Row, axes: AxisPair) -> list[list[Any]]:
    across, upwards = axes
    error = row["graspability_std"] * upwards.factor
    return _facts(
        [
            (across.value, row["complexity"] * across.factor, None, across.printed_unit, 2),
            (upwards.value, row["graspability"] * upwards.factor, error, upwards.printed_unit, 2),
            ("cell confidence", 100 * row["cell_confidence"], None, "%", 0),
        ]
    )


def _solid_facts(row: Row, factor: float) -> list[list[Any]]:
    """What is known of a solid, at the size at which it is shown."""
    sides = sorted((1000 * factor * row[f"extents_{axis}"] for axis in "xyz"), reverse=True)
    size = " \N{MULTIPLICATION SIGN} ".join(f"{side:.0f}" for side in sides)
    return _facts(
        [
            ("diversity", row["diversity"], None, "", 3),
            ("size", None if pd.isna(sides[0]) else size, None, "mm", 0),
            ("mass", 1000 * factor**3 * row["mass"], None, "g", 0),
            ("volume", 1e6 * factor**3 * row["volume"], None, "cm³", 1),
            ("surface", 1e4 * factor**2 * row["area"], None, "cm²", 1),
        ]
    )


def _label_counts(grasps: pd.DataFrame) -> list[int]:
    """Number of grasps with each of `LABELS`; without simulation, only collisions are known."""
    if "simulated_success" not in grasps:
        grasps = grasps.assign(simulated_success=None)
    codes = label_codes(grasps)
    return [int((codes == code).sum()) for code in range(len(LABELS))]


def _simulated(counts: list[int]) -> list[list[Any]]:
    """Fraction of the grasps that held, with half the Wilson interval of 68 %, which is never 0."""
    held, simulated = counts[1], counts[1] + counts[2]
    if not simulated:
        return []
    low, high = wilson(held, simulated, ONE_SIGMA)
    share = held / simulated
    return _facts([("antipodal success", 100 * share, 50 * (high - low), "%", 0)])


def _trial(name: str, attempts: pd.DataFrame) -> list[Any]:
    """Detector, successes, attempts and the ends of the interval."""
    found = rate(attempts)
    low, high = found.interval
    return [name, found.successes, found.attempts, rounded(low), rounded(high)]
