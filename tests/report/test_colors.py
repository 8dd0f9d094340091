import re

import matplotlib

from egad.report import colors


def test_color_scale_is_viridis_clipped():
    ends = [matplotlib.colors.to_hex(matplotlib.colormaps["viridis"](end)) for end in (0.0, 1.0)]
    assert [colors.scale_color(value, 0.1, 0.3) for value in (0.1, 0.3)] == ends
    assert [colors.scale_color(value, 0.1, 0.3) for value in (-1, 7)] == ends
    assert colors.scale_color(float("nan"), 0.1, 0.3) == colors.UNKNOWN
    assert re.fullmatch("#[0-9a-f]{6}", colors.scale_color(0.2, 0.2, 0.2))
