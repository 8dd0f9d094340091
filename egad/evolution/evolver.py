"""Evolution from Python: in one call, or step by step with measures of your own."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arguments import as_floats, check_array
from egad._util.parameters import Range, check_count, from_arguments, with_defaults
from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import RejectedError, UserError, most_common
from egad.evolution.archive import Archive
from egad.evolution.evaluation import GenomeVoxels, Measured
from egad.evolution.growth import packed_surface
from egad.evolution.island import Candidate, Island
from egad.evolution.parameters import Evolution, EvolutionParameters
from egad.grippers import gripper
from egad.measures import Graspability, MeasureSpace, default_measures
from egad.measures.reeb import Similarity
from egad.measures.reeb import graph as reeb

Measure = Callable[[trimesh.Trimesh], tuple[float, float]]
SPACE, POPULATION = MeasureSpace(), Evolution().population
RANGES = SPACE.complexity_range, SPACE.graspability_range


class Evolver:
    """MAP-Elites over CPPN genomes, step by step, with `ask` and `tell` as in pyribs.

    ```python
    evolver = egad.Evolver(seed=0, ranges=((0, 0.2), (0, 1)))
    for _ in range(10):
        evolver.tell([(each.mesh.volume, my_measure(each.mesh)) for each in evolver.ask()])
    evolver.archive.coverage
    ```
    """

    def __init__(
        self,
        *,
        seed: int = 0,
        population: int = POPULATION,
        ranges: tuple[Range, Range] = RANGES,
        cells: int = SPACE.cells,
        elites_per_cell: int = SPACE.elites_per_cell,
    ) -> None:
        """Start with an empty archive; arguments and UserError are as for `egad.evolve`."""
        settings = evolution_parameters(seed, population, ranges, cells, elites_per_cell)
        self.archive = Archive(settings.space, settings.similarity)
        self._settings = settings
        self._island = Island(self.archive, settings, 0, 0)
        self._asked: list[Candidate] | None = None

    def __repr__(self) -> str:
        return f"Evolver({self.archive!r})"

    def _repr_html_(self) -> str:
        return self.archive._repr_html_()

    def ask(self) -> list[Candidate]:
        """The new shapes of the next step: `mesh`, `voxels` and `id` of each.

        Offspring that are empty or known already are left out, so there may be fewer than
        `population`, or none.

        Raises:
            UserError: `tell` was not called with the measures of the last step.
        """
        if self._asked is not None:
            raise UserError("tell the measures of the candidates before asking for more")
        self._asked = self._island.ask()
        return self._asked

    def tell(self, measures: ArrayLike) -> None:
        """Add the candidates that were asked for to the archive.

        Args:
            measures: (n, 2) both measures of each candidate; candidates with NaN are rejected.

        Raises:
            UserError: Nothing was asked for, or the measures are not an array of this shape.
        """
        if self._asked is None:
            raise UserError("ask for candidates before telling their measures")
        values, count = as_floats(measures), len(self._asked)
        if values is None or (values.shape != (count, 2) and (count or values.size)):
            found = repr(measures) if values is None else values.shape
            raise UserError(
                f"expected measures of shape ({count}, 2), one row per candidate, got {found}"
            )
        graphs = self._settings.similarity
        pairs = zip(self._asked, values.reshape(-1, 2).tolist(), strict=True)
        results = [_with_graph(each.mesh, first, second, graphs) for each, (first, second) in pairs]
        self._island.tell(self._asked, results)
        self._asked = None


def evolve(
    evaluations: int = 2000,
    *,
    seed: int = 0,
    measures: Measure | None = None,
    ranges: tuple[Range, Range] = RANGES,
    cells: int = SPACE.cells,
    elites_per_cell: int = SPACE.elites_per_cell,
    population: int = POPULATION,
    jobs: int = 1,
) -> Archive:
    """Evolve objects that span two measures.

    Args:
        evaluations: Total number of offspring, rounded up to whole steps of `population`.
        seed: The same arguments give the same archive, for any number of jobs.
        measures: Function from a closed mesh in metres to two numbers; by default EGAD's complexity
            and graspability for the gripper `yumi`, as in `egad.measure`.
        ranges: Lowest and highest value of each measure; values outside go to the nearest cell.
        cells: Cells along each measure.
        elites_per_cell: Maximum number of objects that a cell keeps: those that are least alike.
        population: Offspring per step.
        jobs: Number of processes; the result does not depend on it.

    Returns:
        The archive: `len`, `coverage`, `qd_score`, `to_frame()`; `egad.load(archive)` gives the
        objects with their meshes.

    Raises:
        UserError: A number is out of bounds; the measures are not a function, do not return two
            numbers, or cannot be sent to other processes; or no object was accepted, such as when
            they are always NaN.

    Source: EGAD (Morrison, Corke and Leitner 2020), section III.
    """
    if not (measures is None or callable(measures)):
        raise UserError(f"measures is {measures!r}; allowed: a function from a mesh to two numbers")
    settings = evolution_parameters(seed, population, ranges, cells, elites_per_cell)
    size, threads = settings.evolution.population, check_count("jobs", jobs)
    total = check_count("evaluations", evaluations)
    steps = Evolution(evaluations=total, population=size).steps
    archive = Archive(settings.space, settings.similarity, threads)
    evaluate = None if measures is None else partial(_measure, measures=measures, settings=settings)
    with workers(threads) as mapper:
        island = Island(archive, settings, 0, 0, mapper=mapper, evaluate=evaluate)
        for _ in progress(range(steps), "evaluations", steps, scale=size):
            island.advance()
    if not len(archive):
        counts = island.outcomes
        raise UserError(f"none of {counts.total()} offspring was accepted: {most_common(counts)}")
    return archive


def evolution_parameters(
    seed: int,
    population: int = POPULATION,
    ranges: tuple[Range, Range] = RANGES,
    cells: int = SPACE.cells,
    elites_per_cell: int = SPACE.elites_per_cell,
) -> EvolutionParameters:
    """The parameters of evolution, the default ones for all others; `UserError` for a wrong one."""
    allowed = "two ranges of finite numbers, each from low to high, such as ((1, 5), (0, 0.004))"
    values = check_array("ranges", ranges, (2, 2), allowed)
    if not (np.diff(values) > 0).all():
        raise UserError(f"ranges is {ranges!r}; allowed: {allowed}")
    first, second = map(tuple, values.tolist())
    space = from_arguments(
        MeasureSpace,
        complexity_range=first,
        graspability_range=second,
        cells=cells,
        elites_per_cell=elites_per_cell,
    )
    measures = dict(default_measures(gripper(Graspability().gripper), seed)) | {"space": space}
    evolution = from_arguments(Evolution, population=population)
    return with_defaults(EvolutionParameters, **measures, evolution=evolution)


def _measure(
    solid: GenomeVoxels, measures: Measure, settings: EvolutionParameters
) -> Measured | str:
    """The measures of a solid by a user's function, or the reason why it has none."""
    mesh = packed_surface(solid.packed, settings.shape)
    try:
        values = measures(mesh)
    except RejectedError as reason:
        return str(reason)
    pair = as_floats(values)
    if pair is None or pair.shape != (2,):
        raise UserError(f"the measures of a mesh must be two numbers, got {values!r}")
    first, second = pair.tolist()
    return _with_graph(mesh, first, second, settings.similarity)


def _with_graph(
    mesh: trimesh.Trimesh, first: float, second: float, similarity: Similarity
) -> Measured | str:
    """Two measures with the Reeb graph that diversity needs, or why the shape is rejected."""
    if not math.isfinite(first + second):
        return f"the measures are not two finite numbers ({first:g} and {second:g})"
    try:
        return Measured(first, second, reeb.extract(mesh, similarity))
    except RejectedError as reason:
        return str(reason)
