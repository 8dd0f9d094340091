"""How templates are filled: numbers as text, and nothing that breaks a page."""

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

SPACE = "\N{NO-BREAK SPACE}"
DASH = "\N{EN DASH}"


def environment() -> Environment:
    """The templates of this package; filters: `percent`, `count`, `fixed`, `p_value`, `code`."""
    environment = Environment(
        loader=PackageLoader("egad.report"),
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
    """A p-value in short: two digits, but not below 0.001."""
    if pd.isna(value):
        return DASH
    return "< 0.001" if value < 0.001 else f"{value:.3f}" if value < 0.01 else f"{value:.2f}"


def _code(text: str) -> Markup:
    """Text as HTML, with what stands between backticks set as code."""
    parts = [
        Markup("<code>{}</code>").format(part) if index % 2 else escape(part)
        for index, part in enumerate(text.split("`"))
    ]
    return Markup("").join(parts)
