import re

import matplotlib

from egad.report import drawing


def test_color_scale_is_viridis_clipped():
    ends = [matplotlib.colors.to_hex(matplotlib.colormaps["viridis"](end)) for end in (0.0, 1.0)]
    assert [drawing.scale_color(value, 0.1, 0.3) for value in (0.1, 0.3)] == ends
    assert [drawing.scale_color(value, 0.1, 0.3) for value in (-1, 7)] == ends
    assert drawing.scale_color(float("nan"), 0.1, 0.3) == drawing.UNKNOWN
    assert re.fullmatch("#[0-9a-f]{6}", drawing.scale_color(0.2, 0.2, 0.2))
