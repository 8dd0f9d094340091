"""The page of the gallery, and everything that it shows of a dataset, apart from meshes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import pandas as pd

from egad.evolution import Lineage
from egad.report.axes import AxisPair
from egad.report.gallery.details import Download, ObjectPage, Relatives
from egad.report.gallery.files import COLUMNS, FOLDER, PER_SHEET
from egad.report.gallery.index import Membership
from egad.report.page import render_template
from egad.report.viewer import LABELS
from egad.sim import antipodal_success_rates
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import GENOME
from egad.tables.parquet import empty, records
from egad.tables.release import MAX_FILES


@dataclass(frozen=True)
class GalleryData:
    """A dataset for the gallery, with a gripper; empty name: nothing is scaled."""

    objects: pd.DataFrame
    gripper: str = ""
    # scale factors by label, without objects that cannot be scaled
    factors: Mapping[str, float] = field(default_factory=dict)
    # labelled grasps; None if there is no table. A table with `simulated_success` also needs the
    # other columns that `antipodal_success_rates` reads
    grasps: pd.DataFrame | None = None
    evaluation: pd.DataFrame = field(default_factory=lambda: empty(EVAL49))
    # attempts with the evaluation set by grasp detector: columns label and success
    trials: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    lineage: Lineage | None = None
    # columns id and those of `tables.evolution.GENOME`
    genomes: pd.DataFrame = field(default_factory=lambda: empty(GENOME).assign(id=[]))

    @cached_property
    def labels(self) -> dict[str, str]:
        """Labels of the objects by id."""
        return dict(zip(self.objects["id"], self.objects["label"], strict=True))

    @cached_property
    def ancestors(self) -> pd.DataFrame:
        """The ancestors that are not among the objects, oldest first."""
        if self.lineage is None:
            return self.objects.iloc[:0]
        table = self.lineage.table
        return table[~table["id"].isin(set(self.labels))].reset_index(drop=True)

    @cached_property
    def member(self) -> Membership:
        """Families, labels in the evaluation set, and antipodal success rates, by id."""
        families: dict[str, str] = {}
        if self.lineage is not None:
            families = {
                name: self.lineage.family(name) for name in self.labels if name in self._related
            }
        places = dict(zip(self.evaluation["id"], self.evaluation["label"], strict=True))
        return Membership(families, places, self._simulated_success())

    def _simulated_success(self) -> dict[str, float]:
        """The fraction of the simulated grasps that held, by id; empty without simulation."""
        if self.grasps is None or "simulated_success" not in self.grasps:
            return {}
        found = antipodal_success_rates(self.grasps)
        return dict(zip(found["id"], found["antipodal_success_rate"], strict=True))

    @cached_property
    def _relatives(self) -> Relatives | None:
        if self.lineage is None:
            return None
        numbers = {name: number for number, name in enumerate(self.ancestors["id"])}
        return Relatives(self.lineage, self.labels, numbers)

    def relatives(self, name: str) -> dict[str, Any] | None:
        """The relatives of an object or ancestor by its id, as `Relatives.data`, if known."""
        if self._relatives is None or name not in self._related:
            return None
        return self._relatives.data(name)

    @cached_property
    def _related(self) -> set[str]:
        return set() if self.lineage is None else set(self.lineage.table["id"])

    @cached_property
    def _genomes(self) -> dict[str, Mapping[str, Any]]:
        return {str(row["id"]): row for row in records(self.genomes)}

    @cached_property
    def _grasps(self) -> dict[str, pd.DataFrame]:
        if self.grasps is None:
            return {}
        return {str(label): own for label, own in self.grasps.groupby("label")}

    def page(self, row: Mapping[str, Any]) -> ObjectPage:
        """What is known of an object, a row of `objects`."""
        label, name = row["label"], row["id"]
        factor = self.factors.get(label)
        grasps = None if self.grasps is None else self._grasps.get(label, self.grasps.iloc[:0])
        note = ""
        if self.gripper and factor is None:
            note = f"This object cannot be scaled to {self.gripper}, so it has no grasps."
        elif grasps is not None and grasps.empty:
            note = "No grasp was found."
        return ObjectPage(
            row=row,
            grasps=grasps,
            factor=1.0 if factor is None else factor,
            note=note,
            relatives=self.relatives(name),
            genome=self._genomes.get(name),
            trials=self._attempts(self.member.places.get(name)),
        )

    def _attempts(self, place: str | None) -> dict[str, pd.DataFrame]:
        """Attempts with an object of the evaluation set, by detector."""
        found = {name: table[table["label"] == place] for name, table in self.trials.items()}
        return {name: table for name, table in found.items() if len(table)}


def gallery_page(
    title: str, data: GalleryData, axes: AxisPair, links: Sequence[Download], legend: str = ""
) -> str:
    """The HTML page of the data beside it; the legend says what the hatched rows of the map are."""
    return render_template(
        "gallery.html.j2",
        title=title,
        facts=_facts(data),
        axes=axes,
        gripper=data.gripper,
        links=links,
        legend=legend,
        folder=FOLDER,
        labels=LABELS,
        ancestor_columns=COLUMNS,
        ancestors_per_sheet=PER_SHEET,
        ancestors=len(data.ancestors),
        max_files=MAX_FILES,
    )


def _facts(data: GalleryData) -> list[str]:
    """Facts about the dataset, in a few words each."""
    facts = [f"{len(data.objects)} objects"]
    if data.grasps is not None and "simulated_success" in data.grasps:
        simulated = int(data.grasps["simulated_success"].notna().sum())
        facts.append(f"{simulated} simulated grasps of {data.gripper}")
    elif data.grasps is not None:
        facts.append(f"{len(data.grasps)} grasps of {data.gripper}, not simulated")
    return facts
