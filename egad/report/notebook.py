"""How notebooks show results: HTML with facts, tables and thumbnails."""

from collections.abc import Mapping

import pandas as pd
import trimesh

from egad.report.page import data_uri, render_template
from egad.report.pictures import png_bytes, render

THUMBNAIL = 160  # pixels along each side
ROWS = 10  # of a long table


def facts_html(title: str, facts: Mapping[str, object], mesh: trimesh.Trimesh | None) -> str:
    """A result: its title, its facts by name as a table, and a thumbnail of its mesh."""
    picture = "" if mesh is None else data_uri(png_bytes(render(mesh, 2 * THUMBNAIL)))
    return render_template(
        "facts.html.j2", title=title, facts=facts, picture=picture, size=THUMBNAIL
    )


def table_html(title: str, table: pd.DataFrame) -> str:
    """A table under its title; for a long one, only its first and last rows."""
    with pd.option_context("display.max_colwidth", None):
        rows = table.to_html(max_rows=ROWS, border=0, float_format="{:.4g}".format)
    return render_template("facts.html.j2", title=title, facts={}, picture="", size=0) + rows
