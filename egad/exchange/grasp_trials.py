"""Grasps that other programs wrote, tried in simulation: are their labels and scores right?"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from html import escape
from itertools import product
from typing import Literal

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad._util.arguments import check_positive
from egad._util.arrays import Flags, Floats
from egad._util.parameters import check_count
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench import RestingObject, put
from egad.bench.scenes import STAND, settle_from
from egad.bench.stats import Area, Kappa, Rate, area, cohen_kappa, engine_names, mean_rate, rate
from egad.errors import UserError, check_name
from egad.friction import FRICTION
from egad.geometry import Bundle, Material, RayCaster
from egad.grasps import Grasps, label_parameters, vectors
from egad.grippers import Gripper, as_gripper, body_of, check_jaws
from egad.sim import (
    ContactRules,
    EngineName,
    Lifting,
    Model,
    Pose,
    SimulatedLabel,
    SimulatedLabelParameters,
    UnstableError,
    World,
    check_engine,
    execute_pose,
    free_hand,
    make_simulation_object,
    model_of,
    open_world,
    with_simulated_labels,
)
from egad.sim.model import MIN_MASS
from egad.sim.simulated_labels import simulate_grasps
from egad.sim.success_rates import SHAKEN_AND_HELD
from egad.tables.grasping import TRIED_GRASPS
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

Place = Literal["free", "table"]
Levels = float | Sequence[float] | Floats
OUTCOMES: dict[Place, str] = {"free": "simulated_outcome", "table": "table_outcome"}
SUCCESSES: dict[Place, Sequence[str]] = {"free": SHAKEN_AND_HELD, "table": (Outcome.SUCCESS,)}
WHERE: dict[Place, str] = {"free": "in free space", "table": "on a table"}
RATINGS = ("source_score", "quality", "robust_quality")
MOST = 1000  # grasps of a file
CHUNK = 20  # grasps that a process tries at once
PROBABLE = 0.1  # of stable poses that an object is put down in, relative to the most probable
TERCILES = ("low", "middle", "high")
LEVELS = 5  # values of a column that are told one by one


class GraspTrials:
    """Grasps that were tried in simulation; `first + second` are those of several objects.

    Attributes:
        table: One row per grasp, friction and mass: the columns of labelled grasps
            (`results/README.md`); `simulated_outcome`, in free space, and `table_outcome`;
            `source_success` and `source_score`; `depth` of the fingertips below the surface between
            them, metres; `friction`; and `mass`, kilograms.
        unit: What intervals are over: `objects`, or `grasps` if there is one object.
    """

    def __init__(self, table: pd.DataFrame) -> None:
        """Wrap a table with the columns of `tables.grasping.TRIED_GRASPS`."""
        self.table = table.reset_index(drop=True)
        self.unit = "objects" if table["label"].nunique() > 1 else "grasps"

    def __len__(self) -> int:
        return len(self.table)

    def __add__(self, other: "GraspTrials") -> "GraspTrials":
        return GraspTrials(pd.concat([self.table, other.table]))

    def __repr__(self) -> str:
        return "\n".join(self._lines())

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"

    def rate(self, place: Place = "free") -> Rate:
        """How often grasps held the object when it was shaken, `free`, or lifted off a `table`."""
        tried, success = self._tried(place)
        marked = tried.assign(success=success, label=self._groups(tried))
        if not marked["label"].duplicated().any():
            return rate(marked)
        mean, count = mean_rate(marked), self._names(tried).nunique()  # levels add none
        fewer, more = (sign * (sign * mean.successes * count // len(tried)) for sign in (1, -1))
        low, high = Rate(fewer, count).interval[0], Rate(more, count).interval[1]
        return replace(mean, ci_low=min(mean.ci_low, low), ci_high=max(mean.ci_high, high))

    def agreement(self, place: Place = "free") -> Kappa:
        """The label of the file (first) against the simulated success (second)."""
        tried, success = self._tried(place)
        known = tried["source_success"].notna().to_numpy()
        labels = tried["source_success"].to_numpy(np.float64) == 1
        return cohen_kappa(labels[known], success[known], self._groups(tried)[known])

    def area(self, rating: str = "source_score", place: Place = "free") -> Area:
        """Area under the ROC curve of `source_score`, `quality` or `robust_quality` as a rating."""
        check_name("rating", rating, RATINGS)
        tried, success = self._tried(place)
        values = tried[rating].to_numpy(np.float64)
        known = np.isfinite(values)
        return area(values[known], success[known], self._groups(tried)[known])

    def by(self, column: str, place: Place = "free") -> pd.DataFrame:
        """Labels and simulated success by a column, such as `depth`, `width`, `friction` or `mass`.

        Returns:
            For each friction, value if there are at most five, or tercile, its smallest and largest
            value, the number of grasps, the rates of success by the labels of the file and in
            simulation, and how often these agree. Grasps without a value are left out.
        """
        check_name("column", column, map(str, self.table.select_dtypes("number")))
        tried, success = self._tried(place, column)
        whole = tried[column].to_numpy(np.float64)
        thirds = np.array_split(np.argsort(whole, kind="stable"), 3)
        rows, levels, parts = [], np.unique(whole), list(zip(TERCILES, thirds, strict=True))
        if column == "friction" or len(levels) <= LEVELS:
            parts = [(f"{level:g}", np.flatnonzero(whole == level)) for level in levels]
        for name, chosen in parts:
            values, labels = tried[column].iloc[chosen], tried["source_success"].iloc[chosen]
            agreed = (labels == success[chosen])[labels.notna()]
            shares = (each.mean() for each in (labels, pd.Series(success[chosen]), agreed))
            rows.append((name, values.min(), values.max(), len(chosen), *shares))
        names = [column, "from", "to", "grasps", "labelled", "simulated", "agreement"]
        return pd.DataFrame(rows, columns=names)

    def _tried(self, place: Place, column: str = "label") -> tuple[pd.DataFrame, Flags]:
        """The grasps that have a value and that the engine could judge; whether they succeeded."""
        check_name("place", place, OUTCOMES)
        outcome = self.table[OUTCOMES[place]]
        known = self.table[column].notna() & ~outcome.isin(SIMULATION_FAILURES)
        return self.table[known], outcome[known].isin(SUCCESSES[place]).to_numpy()

    def _groups(self, tried: pd.DataFrame) -> NDArray[np.str_]:
        """What intervals resample: the object of each grasp, or the grasp at all levels."""
        return np.asarray(tried["label"] if self.unit == "objects" else self._names(tried), str)

    def _names(self, tried: pd.DataFrame) -> pd.Series:
        """The grasp of each row, by object and number: the same at all frictions and masses."""
        number = self.table.groupby(["label", "friction", "mass"]).cumcount()[tried.index]
        return tried["label"].astype(str) + " " + number.astype(str)

    def _lines(self) -> Iterator[str]:
        engine = engine_names(self.table.assign(engine=self.table["simulated_engine"]))
        once, over = self.table[~self._names(self.table).duplicated()], ""
        if len(once) < len(self):
            levels = self.table.value_counts(["label", "friction", "mass"]).groupby("label").size()
            over = f" at {levels.max()} frictions and masses ({len(self)} trials, counted below)"
        yield f"{len(once)} grasps{over} in {engine}, {once['collision_free'].sum()} collision-free"
        friction, mass = (_from_to(self.table[each]) for each in ("friction", "mass"))
        yield f"friction {friction}, mass {mass} kg"
        for place in OUTCOMES:
            yield f"{WHERE[place]}: success {self.rate(place)}"
            found = self.agreement(place)
            if found.agreement.attempts:
                yield (
                    f"  labels agree {found.agreement.value:.0%}: both succeed {found.both}, only "
                    f"the label {found.only_first}, only simulated {found.only_second}, neither "
                    f"{found.neither}; kappa {_estimate(found)} over {self.unit}"
                )
            areas = {name: self.area(name, place) for name in RATINGS}
            known = [f"{n} {_estimate(a)}" for n, a in areas.items() if np.isfinite(a.value)]
            yield f"  area under the ROC curve: {', '.join(known) or 'all alike'}"


def _from_to(values: pd.Series) -> str:
    return " to ".join(f"{each:.3g}" for each in np.unique([values.min(), values.max()]))


def _estimate(found: Kappa | Area) -> str:
    low, high = found.interval
    value = "unknown" if np.isnan(found.value) else f"{found.value:.2f}"
    return value if np.isnan(low) else f"{value} ({low:.2f} to {high:.2f})"


def try_grasps(
    grasps: Grasps,
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    n: int = 100,
    *,
    name: str = "object",
    engine: EngineName = "mujoco",
    friction: Levels = FRICTION,
    mass: Levels | None = None,
    jobs: int = 1,
) -> GraspTrials:
    """Try grasps in simulation, and compare the labels and scores of their file with the results.

    In free space, the fingers close on an object that floats without weight, and must hold it when
    it is shaken, as for the labels of ACRONYM (Eppner 2021). On a table, it lies in the stable pose
    in which the approach points down most, of those at least a tenth as probable as any other. The
    hand comes from 5 cm away, closes, and retreats by 10 cm; it must not touch anything on its way.

    Args:
        grasps: What `egad.read_grasps` returns with this mesh and gripper, or sampled ones.
        mesh: The object, a closed mesh in metres, at the size that the grasps are for.
        gripper: A gripper with jaws, or its name.
        n: How many grasps are tried at most, up to 1000: evenly spaced, in the order of the file.
        name: What the object is called in the table.
        engine: What computes the physics: `mujoco`, `pybullet` or `drake`.
        friction: Friction of the fingers on the object, up to 2. Each grasp is tried with each of
            several numbers. Qualities stay those that the grasps were rated with.
        mass: Mass of the object, 0.05 to 100 kg, or several; by default that of 400 kg/m3, and at
            least 0.05 kg.
        jobs: Number of processes; the result does not depend on it.

    Raises:
        UserError: There is no such gripper or engine, the gripper has a suction cup, the grasps
            were read without a mesh, or a number is out of bounds.
        RejectedError: The mesh is not a closed solid, or cannot be simulated.

    Warns:
        PartsWarning: The object needs more convex parts than are allowed.
    """
    hand, frictions = as_gripper(gripper), _levels("friction", friction, 0.0, 2.0)
    check_jaws(hand, "a grasp that is tried")
    check_engine(engine)
    if check_count("n", n) > MOST:
        raise UserError(f"n is {n}; allowed: a whole number from 1 to {MOST}")
    rows = np.linspace(0, len(grasps) - 1, min(n, len(grasps))).round().astype(np.int64)
    _ = grasps.quality, grasps.collision_free  # an error without them
    table = grasps[rows].to_frame().assign(id=name, label=name)
    table = table.assign(depth=fingertip_depths(mesh, table, hand))
    masses = None if mass is None else _levels("mass", mass, MIN_MASS, 100.0)
    model, stable = _object_at_rest(mesh, name)
    work = partial(_try, model=model, stable=stable, gripper=hand, engine=engine)
    chunks = [
        table.iloc[first : first + CHUNK].assign(friction=each, mass=kilograms)
        for each, kilograms in product(frictions, masses or [model.mass])
        for first in range(0, len(table), CHUNK)
    ]
    with workers(jobs) as mapper:
        tried = list(progress(mapper(work, chunks), "trying grasps", len(chunks)))
    return GraspTrials(pd.concat(tried).reindex(columns=TRIED_GRASPS.names))


def _levels(name: str, given: Levels, least: float, most: float) -> list[float]:
    """Numbers to try, once each; `UserError` if one is out of bounds."""
    several, levels = np.atleast_1d(np.asarray(given, dtype=object)).tolist(), [-1.0]
    with suppress(UserError):
        levels = [check_positive(name, each, most) for each in several]
    if min(levels, default=-1.0) < least:
        bounds = f"from {least:g}" if least else "above 0"
        raise UserError(f"{name} is {given!r}; allowed: numbers {bounds} to {most:g}, one or more")
    return list(dict.fromkeys(levels))


def fingertip_depths(mesh: trimesh.Trimesh, grasps: pd.DataFrame, gripper: Gripper) -> Floats:
    """How far fingertips reach below a surface between the fingers, (n,) metres; 0 without one."""
    palm, tip = gripper.kind.span
    approach = vectors(grasps, "approach")
    hits = RayCaster(mesh).first_hits(vectors(grasps, "center") + palm * approach, approach)
    inside = np.isfinite(hits.distances) & ~hits.entering
    return np.maximum(tip - palm - np.where(inside, 0.0, hits.distances), 0.0)


def _object_at_rest(mesh: trimesh.Trimesh, name: str) -> tuple[Model, list[Pose]]:
    """An object, and the stable poses that it is put down in, slightly above the table."""
    made = make_simulation_object(mesh, Material().density, Bundle(), name)
    model = model_of(made.mesh, made.parts, made.physics, made.volume_error)
    least = PROBABLE * max(each.probability for each in made.poses)
    poses = []
    for each in made.poses:
        if each.probability >= least:
            turn = each.rotation @ model.to_principal[:3, :3].T
            position = np.array([0.0, 0.0, each.height + STAND])
            poses.append(Pose(position, Rotation.from_matrix(turn).as_quat()))
    return model, poses


def _try(
    grasps: pd.DataFrame, model: Model, stable: Sequence[Pose], gripper: Gripper, engine: EngineName
) -> pd.DataFrame:
    """Grasps of one friction and mass with the columns that simulation fills in."""
    friction, mass = map(float, grasps[["friction", "mass"]].iloc[0])
    model = replace(model, mass=mass, inertia=model.inertia * (mass / model.mass))
    settings = SimulatedLabelParameters(
        gripper=gripper,
        quality=label_parameters(gripper, 1, 0, friction=friction).quality,
        trials=Lifting(),
        simulated_label=SimulatedLabel(engine=engine),
    )
    fitting = np.flatnonzero(grasps["fits"])
    free = simulate_grasps(model, grasps.iloc[fitting], settings)
    tried = with_simulated_labels(grasps, fitting, free, settings)
    tried["simulated_outcome"] = tried["simulated_outcome"].fillna(Outcome.COLLIDED.value)
    gripper = gripper.model_copy(update={"friction": friction})
    poses = open_hand_poses(Grasps(grasps), gripper)
    with open_world(engine, [model], free_hand(gripper)) as world:
        found = [_on_table(world, pose, stable, gripper).value for pose in poses]
    return tried.assign(table_outcome=found)


def open_hand_poses(grasps: Grasps, gripper: Gripper) -> Floats:
    """Poses of the open hand, (n, 4, 4): jaws on arcs, or one of which is fixed, shift it."""
    poses, widths, opening = grasps.poses, grasps.widths, np.array([gripper.opening])
    body = body_of(gripper)
    behind = body.reach(widths) - body.reach(opening)
    poses[:, :3, 3] += body.aside(widths, opening)[:, None] * poses[:, :3, 0]
    poses[:, :3, 3] -= behind[:, None] * poses[:, :3, 2]
    return poses


def _on_table(world: World, pose: Floats, stable: Sequence[Pose], gripper: Gripper) -> Outcome:
    """Try a grasp at a pose of the hand in the frame of the mesh, (4, 4)."""
    from_mesh = world.model.to_principal
    approach = from_mesh[:3, :3] @ pose[:3, 2]
    start = min(stable, key=lambda each: float(each.matrix[2, :3] @ approach))
    try:
        rest = settle_from(world, [RestingObject(0, start)])
    except UnstableError:
        return Outcome.FAILED
    if not rest:
        return Outcome.FAILED  # it rolled away
    put(world, rest)
    in_world = rest[0].pose.matrix @ from_mesh @ pose
    return execute_pose(world, in_world, gripper.opening, ContactRules("collided")).outcome
