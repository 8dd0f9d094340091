"""HTML pages: sections, templates, numbers as text, and escaping.

A section of the report is a module of this package, which turns tables into what the template of
the same name shows.
"""

import base64
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import ChoiceLoader, Environment, FileSystemLoader, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

SPACE = "\N{NO-BREAK SPACE}"
DASH = "\N{EN DASH}"


@dataclass(frozen=True)
class Section:
    """A part of a page: anchor, title of the link to it, and the section itself."""

    id: str
    title: str
    html: Markup


def section_of(template: str, title: str, /, **values: Any) -> Section:  # noqa: ANN401 (as Jinja)
    """Fill the template of a section; its anchor is the name of the template without endings."""
    html = render_template(template, **values)
    return Section(template.partition(".")[0], title, Markup(html))  # noqa: S704 (templates escape what they show)


def report_page(sections: Iterable[Section], *, alone: bool = False) -> str:
    """One HTML page of sections with links, that needs no other file; of one dataset if `alone`."""
    return render_template("report.html.j2", sections=list(sections), alone=alone)


def render_template(
    name: str,
    folder: Path | None = None,
    /,
    **values: Any,  # noqa: ANN401 (as Jinja)
) -> str:
    """The text of a template, which may extend one of this package if it is in another folder."""
    return _environment(folder).get_template(name).render(**values)


@cache
def _environment(folder: Path | None) -> Environment:
    """The templates of this package; filters: `percent`, `count`, `fixed`, `p_value`, `code`."""
    own = PackageLoader("egad.report")
    environment = Environment(
        loader=ChoiceLoader([FileSystemLoader(folder), own]) if folder else own,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        percent=_percent, count=_count, fixed=_fixed, p_value=p_value, code=_code
    )
    return environment


def _percent(value: float, digits: int = 0) -> str:
    number = f"{100 * value:.{digits}f}".replace("-", "\N{MINUS SIGN}")
    return DASH if pd.isna(value) else f"{number}{SPACE}%"


def _count(value: int) -> str:
    return f"{value:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def _fixed(value: float, digits: int = 2) -> str:
    return DASH if pd.isna(value) else f"{value:.{digits}f}"


def p_value(value: float) -> str:
    """A short p-value: two digits, but not below 0.001."""
    if pd.isna(value):
        return DASH
    return "< 0.001" if value < 0.001 else f"{value:.3f}" if value < 0.01 else f"{value:.2f}"


def _code(text: str) -> Markup:
    """Text as HTML, with anything between backticks set as code."""
    parts = [
        Markup("<code>{}</code>").format(part) if index % 2 else escape(part)
        for index, part in enumerate(text.split("`"))
    ]
    return Markup("").join(parts)


def counted(count: int, noun: str) -> str:
    """A number and its noun, with an s in the plural."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def data_uri(content: bytes, kind: str = "image/png") -> str:
    """Content as a data URI, which needs no file; empty for no content."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}" if content else ""


def svg_uri(svg: str) -> str:
    """The text of an SVG figure as a data URI."""
    return data_uri(svg.encode(), "image/svg+xml")
