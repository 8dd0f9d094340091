"""The page of the gallery, without the data."""

from collections.abc import Sequence

from egad.exchange.release import MAX_FILES
from egad.report.axes import AxisPair
from egad.report.gallery.dataset import GalleryData
from egad.report.gallery.details import Download
from egad.report.gallery.files import FOLDER
from egad.report.gallery.sheets import COLUMNS, PER_SHEET
from egad.report.page import render_template
from egad.report.viewer import LABELS


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
