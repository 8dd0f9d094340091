"""The colors and fonts of charts, maps and pages."""

import math

INK, SOFT, FAINT = "#1c2430", "#667080", "#e4e7ec"
UNKNOWN = "#c4c9d1"
LINES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#882255", "#8a6d3b"]
COLOR_MAP = "viridis"  # of values on maps of objects
FONTS = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


def line_color(number: int) -> str:
    """Color of a line of a chart, by its number; colors repeat after the last one."""
    return LINES[number % len(LINES)]


def scale_color(value: float, low: float, high: float) -> str:
    """Color `#rrggbb` on the scale `COLOR_MAP`, clipped to `low` and `high`; grey for NaN."""
    import matplotlib  # noqa: PLC0415 (an extra)
    from matplotlib.colors import to_hex  # noqa: PLC0415

    if math.isnan(value):
        return UNKNOWN
    share = (value - low) / (high - low) if high > low else 0.5
    return to_hex(matplotlib.colormaps[COLOR_MAP](min(max(share, 0.0), 1.0)))


def ink_on(color: str) -> str:
    """Dark or white text, whichever is more readable on a color."""
    from matplotlib.colors import to_rgb  # noqa: PLC0415 (an extra)

    red, green, blue = to_rgb(color)
    return INK if 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 > 0.25 else "white"
