"""The cells that objects can be expected in: how high the percentile of grasp quality gets (ours).

studies/search/README.md derives this limit, and has the solids that come close to it or exceed it.
"""

import math
import string
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats
from egad.geometry import SIDE_FRACTION
from egad.grasps import Quality, quality_bound
from egad.grippers import ANTIPODAL
from egad.measures.parameters import MeasureParameters
from egad.measures.percentile import percentile

LEANS, HEIGHTS = 500, 81  # steps of the model


class Attainable(NamedTuple):
    """What objects can attain in the measure of graspability."""

    # highest possible quality of a grasp; infinite if graspability is not the nominal quality of
    # antipodal grasps
    quality: float
    graspability: float  # highest expected value, for an object as thick as its box; or infinite
    rows: int  # number of easiest rows that lie above that graspability
    edge: float  # the lowest graspability of these rows

    @property
    def row_names(self) -> str:
        """The rows above that graspability, such as `rows A and B`; empty if there are none."""
        names = string.ascii_uppercase[: self.rows]
        if self.rows > 2:
            return f"rows {names[0]} to {names[-1]}"
        return f"row{'s' * (self.rows - 1)} {' and '.join(names)}" if names else ""


def attainable_graspability(settings: MeasureParameters) -> Attainable:
    """The highest quality of a grasp, and the highest percentile that is expected.

    In the model, every grasp spans the smallest side of the box, and both contacts lean equally
    with a tangent that is uniform up to the cone. Without lean, it passes through the center of
    mass.
    """
    others = settings.robust is not None or settings.gripper.grasps_with != ANTIPODAL
    if settings.measures.graspability or others:
        return Attainable(math.inf, math.inf, 0, math.inf)
    side = SIDE_FRACTION * settings.gripper.opening
    leans = settings.sampling.cone * (np.arange(LEANS) + 0.5) / LEANS
    heights = np.linspace(0, side, HEIGHTS)
    qualities = np.array([_qualities(height, leans, settings.quality) for height in heights])
    from_both = np.concatenate([qualities, qualities[::-1]], axis=1)  # either contact is the first
    percent = settings.graspability.percentile
    highest = max(percentile(each, percent) for each in from_both)
    best = float(_qualities(0.0, np.zeros(1), settings.quality)[0])
    (low, high), count = settings.space.graspability_range, settings.space.cells
    edges = high - (high - low) * np.arange(1, count) / count  # of rows below the easiest ones
    rows = int(np.sum(edges > highest))
    return Attainable(best, highest, rows, float(edges[rows - 1]) if rows else math.inf)


def _qualities(height: float, leans: Floats, rules: Quality) -> Floats:
    """Quality of grasps that lean by tangents (n,), with the center of mass above one contact."""
    normals = np.tile([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], (len(leans), 1, 1))
    axes = np.stack([leans, np.zeros_like(leans), np.ones_like(leans)], axis=1)
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    first = np.array([0.0, 0.0, -height])
    points = np.stack([np.broadcast_to(first, axes.shape), first + axes], axis=1)
    return quality_bound(points, normals, axes, np.zeros(3), **rules.model_dump())
