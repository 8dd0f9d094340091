"""Graspability: how good the better grasps of an object are.

Antipodal grasps are sampled on the object scaled to the gripper. Graspability is a percentile of
their quality, so high values mean easy objects (EGAD: Morrison, Corke and Leitner, RA-L 2020, who
call it difficulty). The paper computes it from 100 grasps that keep a minimum distance from each
other. The more grasps there are, the more this distance changes their distribution. So here, grasps
are independent, and as many are sampled as certainty requires.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arrays import Floats, Ints
from egad.errors import NoGraspError, RejectedError
from egad.geometry import (
    SIDE_FRACTION,
    RayCaster,
    box_sides,
    center_of_mass,
    check_mesh,
    scale_factor,
)
from egad.grasps import (
    ContactPairs,
    Sampling,
    SamplingStatistics,
    ferrari_canny,
    join,
    quality_bound,
    robust_ferrari_canny,
    sample_contacts,
    valid_contacts,
)
from egad.grasps.samplers import draw_grasps
from egad.grippers import ANTIPODAL, SUCTION
from egad.measures.grid import graspability_limits
from egad.measures.parameters import MAP_RULE, MeasureParameters
from egad.measures.percentile import (
    BoundedSample,
    confidence_between,
    percentile_rank,
    percentile_std,
)

MAX_CUPS = 4096  # candidates of a suction cup, each rated by 25 perturbed copies
FLAT = 1e-6  # smallest side over longest: below this a surface has no inside
_Sample: TypeAlias = Callable[
    [RayCaster, float, int, Sampling, np.random.Generator], tuple[ContactPairs, SamplingStatistics]
]


class GraspabilityEstimate(NamedTuple):
    """An estimate of the graspability of an object."""

    value: float  # percentile of the quality of sampled grasps
    std: float  # its standard error; NaN if it is not known
    confidence: float  # probability that the percentile of all grasps lies in the cell; or NaN
    grasps: int  # number of grasps that it was computed from


class GraspedSize(NamedTuple):
    """The size of an object while its grasps are sampled."""

    factor: float
    # sides of its scaled box, ascending, metres, (3,): the box along the principal axes for the
    # rule `exact`, the minimum-volume box for the others
    sides: Floats


def grasped_size(mesh: trimesh.Trimesh, settings: MeasureParameters, rule: str) -> GraspedSize:
    """The size at which the grasps of a mesh are sampled; `RejectedError` if it is flat."""
    check_mesh(mesh)
    sides = np.sort(_principal_box(mesh.vertices)[2]) if rule == MAP_RULE else box_sides(mesh)
    return _scaled_size(sides, settings, rule)


def _scaled_size(sides: Floats, settings: MeasureParameters, rule: str) -> GraspedSize:
    factor = scale_factor(rule, sides, settings.gripper.opening, SIDE_FRACTION)
    return GraspedSize(factor, sides * factor)


def graspability(
    mesh: trimesh.Trimesh,
    settings: MeasureParameters,
    max_candidates: int,
    rng: np.random.Generator,
    com: Floats | None = None,
    factor: float | None = None,
) -> GraspabilityEstimate:
    """A percentile of the quality of independent grasps: high values are easy objects (ours).

    A copy of the mesh, its principal axes (of the vertices) as axes, is scaled by the factor, by
    default until its smallest side is `SIDE_FRACTION` of the opening. Grasps without quality count
    as zeros, and so do unsealed cups. The number of candidates doubles until the cell is as certain
    as the space requires, or the budget is spent. The confidence holds on average over objects, but
    not over those selected by their cell. `RejectedError` if there is no grasp, or the mesh is
    flat.
    """
    grasps, enough = _RatedGrasps(mesh, settings, rng, com, factor), settings.space.confidence
    if settings.gripper.grasps_with == SUCTION:
        max_candidates = min(max_candidates, MAX_CUPS)
    draws = min(settings.graspability.candidates, max_candidates)
    while True:
        grasps.draw(draws)
        draws = min(grasps.statistics.candidates, max_candidates - grasps.statistics.candidates)
        if len(grasps) or not draws:
            estimate = grasps.graspability()
            if estimate.confidence >= enough or not draws:
                return estimate


def rough_graspability(
    mesh: trimesh.Trimesh, settings: MeasureParameters, rng: np.random.Generator
) -> GraspabilityEstimate:
    """The percentile from only the first candidates of `graspability`, without its errors (NaN)."""
    grasps = _RatedGrasps(mesh, settings, rng)
    grasps.draw(settings.graspability.candidates)
    return GraspabilityEstimate(grasps.percentile(), math.nan, math.nan, len(grasps))


def spaced_graspability(
    mesh: trimesh.Trimesh, settings: MeasureParameters, count: int, rng: np.random.Generator
) -> GraspabilityEstimate:
    """The paper's percentile (EGAD, III-C), of `count` grasps at a distance, without errors."""
    grasps = _RatedGrasps(mesh, settings, rng)
    grasps.draw(count, sample_contacts)
    return GraspabilityEstimate(grasps.percentile(), math.nan, math.nan, len(grasps))


class _RatedGrasps:
    """Grasps on an object, and the percentile of their quality."""

    def __init__(
        self,
        mesh: trimesh.Trimesh,
        settings: MeasureParameters,
        rng: np.random.Generator,
        com: Floats | None = None,
        factor: float | None = None,
    ) -> None:
        check_mesh(mesh)
        middle, axes, extents = _principal_box(mesh.vertices)
        if factor is None:
            factor = _scaled_size(np.sort(extents), settings, MAP_RULE).factor
        place = middle, axes * factor
        scaled = trimesh.Trimesh(_apply(place, mesh.vertices), mesh.faces, process=False)
        self._com = _apply(place, center_of_mass(mesh) if com is None else com)
        self._settings, self._rng = settings, rng
        self._grasps = ContactPairs.empty()
        self._sample = BoundedSample(self._qualities)
        self._mesh, self._caster = scaled, RayCaster(scaled)
        self.statistics = SamplingStatistics()

    def __len__(self) -> int:
        return len(self._sample)

    def draw(self, candidates: int, sample: _Sample = valid_contacts) -> None:
        """Draw more candidates: antipodal ones by `sample`, or those of another gripper."""
        if self._settings.gripper.grasps_with != ANTIPODAL:
            self._draw_others(candidates)
        else:
            self._draw_antipodal(candidates, sample)

    def _draw_others(self, candidates: int) -> None:
        """Draw grasps of another sampler; those of a cup that does not seal have the quality 0."""
        settings = self._settings
        self.statistics += SamplingStatistics(candidates=candidates)
        try:
            quality = draw_grasps(
                self._mesh,
                self._com,
                settings.gripper,
                candidates,
                self._rng,
                robust=settings.robust,
                density=settings.density,
            ).quality
        except NoGraspError:
            if not len(self):
                raise
            quality = np.zeros(candidates if settings.gripper.grasps_with == SUCTION else 0)
        self._sample.extend(quality, exact=True)

    def _draw_antipodal(self, candidates: int, sample: _Sample) -> None:
        settings, opening, rng = self._settings, self._settings.gripper.opening, self._rng
        grasps, statistics = sample(self._caster, opening, candidates, settings.sampling, rng)
        self.statistics += statistics
        quality, robust = settings.quality, settings.robust
        if robust is not None:
            mean, _, _ = robust_ferrari_canny(
                self._caster, grasps, self._com, opening, quality=quality, robust=robust, rng=rng
            )
            self._sample.extend(mean, exact=True)
        else:
            self._grasps = join([self._grasps, grasps])
            contacts = grasps.points, grasps.normals, grasps.axes
            self._sample.extend(quality_bound(*contacts, self._com, **quality.model_dump()))

    def _qualities(self, indices: Ints, floor: float) -> Floats:
        grasps = self._grasps.take(indices)
        contacts = grasps.points, grasps.normals, grasps.axes
        return ferrari_canny(
            *contacts, self._com, **self._settings.quality.model_dump(), floor=floor
        )

    def percentile(self) -> float:
        """The percentile of their quality, or `RejectedError` with the sampling statistics."""
        if not len(self):
            raise RejectedError(f"no grasp ({self.statistics})")
        percent = self._settings.graspability.percentile
        return self._sample.smallest(percentile_rank(len(self), percent))

    def graspability(self) -> GraspabilityEstimate:
        """The percentile and its errors; raises the errors of `percentile`."""
        value, percent = self.percentile(), self._settings.graspability.percentile
        limits = graspability_limits(value, self._settings.space)
        confidence = confidence_between(self._sample, percent, limits)
        return GraspabilityEstimate(
            value, percentile_std(self._sample, percent), confidence, len(self)
        )


def _principal_box(vertices: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Middle of vertices, principal axes as columns, the longest last, and extents, if not flat."""
    vertices = np.asarray(vertices)
    middle = vertices.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov(vertices - middle, rowvar=False))
    axes[:, 0] *= np.sign(np.linalg.det(axes))  # a rotation, no mirror
    extents = np.ptp((vertices - middle) @ axes, axis=0)
    if extents.min() <= FLAT * extents.max():
        raise RejectedError("flat")
    return middle, axes, extents


def _apply(place: tuple[Floats, Floats], points: ArrayLike) -> Floats:
    middle, matrix = place
    return np.asarray((np.asarray(points, dtype=float) - middle) @ matrix)
