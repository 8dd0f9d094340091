"""Where an object lies in the space: its complexity and its graspability."""

import hashlib
import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import trimesh

from egad.geometry import check_mesh
from egad.measures.complexity import complexity
from egad.measures.custom import plugin_value
from egad.measures.graspability import GraspabilityEstimate, graspability
from egad.measures.parameters import MeasureParameters
from egad.measures.resampling import map_complexity
from egad.random import generator


class MeasureValues(NamedTuple):
    """The measures that span the space."""

    complexity: float  # entropy of the angular deficits, bits; or the user's own measure
    graspability: float  # percentile of grasp quality; high is easy. Or the user's own measure
    graspability_std: float  # standard error of the percentile; NaN for a user's measure
    # probability that the percentile of all grasps lies in the same cell; NaN for a user's
    # measure
    cell_confidence: float
    grasps: int  # number of grasps that the percentile was computed from; 0 for a user's measure
    # complexity by the triangles of the mesh as they are, bits; NaN during evolution, and for a
    # user's measure
    raw_complexity: float = math.nan


Estimate = Callable[[trimesh.Trimesh], GraspabilityEstimate]


def measure_mesh(
    mesh: trimesh.Trimesh, settings: MeasureParameters, estimate: Estimate
) -> MeasureValues:
    """Measure a closed mesh of one body, its graspability by `estimate` unless that is a user's."""
    axes = settings.measures
    along = (
        GraspabilityEstimate(plugin_value(axes.graspability, mesh, axes), math.nan, math.nan, 0)
        if axes.graspability
        else estimate(mesh)
    )
    across = (
        plugin_value(axes.complexity, mesh, axes)
        if axes.complexity
        else complexity(mesh, settings.complexity.bins)
    )
    return MeasureValues(across, *along)


def measure_repeatably(
    mesh: trimesh.Trimesh,
    settings: MeasureParameters,
    max_candidates: int,
    factor: float | None = None,
    *,
    resample: bool = True,
) -> MeasureValues:
    """Measure a closed mesh, one body, by grasps that are seeded by its triangles.

    So it has the same measures in every dataset, under every name and in every unit. `factor` is by
    default that of the rule `exact`; `resample` gives `map_complexity`.
    """
    check_mesh(mesh)
    triangles = hashlib.sha256(np.asarray(mesh.faces, "<i8").tobytes()).hexdigest()
    rng = generator(settings.seed, "regrade", triangles)
    estimate = partial(
        graspability, settings=settings, max_candidates=max_candidates, rng=rng, factor=factor
    )
    values = measure_mesh(mesh, settings, estimate)
    if settings.measures.complexity:
        return values
    raw = values.complexity
    if not resample:
        return values._replace(raw_complexity=raw)
    placed = map_complexity(mesh, settings.complexity.bins)
    return values._replace(complexity=placed, raw_complexity=raw)
