"""The page beside the files of objects for simulators: what they are, and how to load them."""

from typing import Any

import pandas as pd

from egad._util.markdown import filled
from egad._util.markdown import table as markdown
from egad.geometry import MAX_BURIED, Bundle
from egad.tables import parquet

HEAD = ("object", "parts", "volume error", "deviation, mm", "buried", "mass, g", "poses")


def page(
    table: pd.DataFrame, left_out: list[dict[str, str]], density: float, bundle: Bundle
) -> str:
    """The page as Markdown, from `BUNDLE` and `REJECTED`; the density of objects is in kg/m3."""
    missing = [f"- {row['id']}: {row['reason']}" for row in left_out]
    return filled(
        __package__,
        "simulation_page.md",
        count=len(table),
        density=density,
        friction=bundle.friction,
        bound=bundle.volume_error,
        depth=1000 * bundle.deviation,
        buried=MAX_BURIED,
        objects=markdown(HEAD, map(_cells, parquet.records(table))),
        rejected="\n".join(["", "## Left out", "", *missing, ""]) if missing else "",
    )


def _cells(row: dict[str, Any]) -> list[Any]:
    mark = "" if row["within"] else " !"
    return [
        row["label"],
        row["parts"],
        f"{row['volume_error']:.1%}{mark}",
        f"{1000 * row['deviation']:.2f}",
        f"{row['buried']:.1%}",
        f"{1000 * row['mass']:.1f}",
        row["poses"],
    ]
