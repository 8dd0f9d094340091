"""What simulated success rates of objects say: the tables of docs/studies/success-rates.md.

`python experiments/success_rates.py FOLDER` takes the 49 objects of the released evaluation set.
Measures of them with the hand `panda` in MuJoCo are ranked against how often grasps succeed with
two other hands in PyBullet, with other random numbers.
Tables of grasps are kept in FOLDER; a second call runs what is missing. `--trials FOLDER/20` adds
as another target the success of detectors with `egad_75mm` in MuJoCo, from the tables that
`experiments/cell_errors.py FOLDER` keeps.
"""

import argparse
import pickle
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import egad
from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad._util.workers import workers
from egad.bench.naive_grasps import try_in_free_space, try_on_table
from egad.bench.stats import trend
from egad.geometry import Bundle, Material, make_simulation_object
from egad.grasps import FRICTION, Quality, label_parameters
from egad.grasps.sampling import dataset_grasps
from egad.grippers import GRIPPERS
from egad.learning.images import model_at_size
from egad.objects import NamedMesh, named_meshes, scaled_solid
from egad.random import generator
from egad.sim import EngineName, Lifting, Model, SimulatedLabel, World, open_world
from egad.sim.arms import TurningAxis
from egad.sim.execution import execute
from egad.sim.labelled_trials import floating_pose
from egad.sim.parameters import SimulatedLabelParameters
from egad.sim.robots import free_hand
from egad.sim.simulated_labels import simulate_grasps
from egad.tables import parquet
from egad.tables.columns import vector_names
from egad.tables.outcomes import SIMULATION_FAILURES, Outcome

FIRST, OTHERS = "panda", ("yumi", "robotiq_2f_140")  # openings of 80, and of 50 and 140 mm
SEEDS: dict[EngineName, int] = {"mujoco": 0, "pybullet": 1}
SHIFT, TURN = 0.005, 0.1  # standard deviations of disturbed grasps, metres and radians per axis
DETECTORS = ("antipodal-depth", "ggcnn2-evolved", "ggcnn2-evolved-published")
HELD = (Outcome.SUCCESS, Outcome.SLIPPED_LIFTING, Outcome.DROPPED)


class Prepared(NamedTuple):
    """An object scaled to a hand, with 100 labelled grasps."""

    label: str
    id: str
    model: Model
    grasps: pd.DataFrame


class Kind(NamedTuple):
    """A kind of grasps that are tried.

    Attributes:
        name: What it is called.
        where: free, table: naive grasps; antipodal: labelled ones, as `simulated_label`; disturbed:
            the same with errors of the hand, closed and lifted only.
        friction: Of the pads.
        deepest: Limit of the depth of naive grasps, metres.
    """

    name: str
    where: str
    friction: float = FRICTION
    deepest: float = np.inf


FREE, TABLE = Kind("free", "free"), Kind("table", "table")
ANTIPODAL, DISTURBED = Kind("antipodal", "antipodal"), Kind("disturbed", "disturbed")
PADS = [Kind(f"{each.name}, friction 0.8", each.where, friction=0.8) for each in (FREE, TABLE)]
SHALLOW = [Kind(f"{each.name}, 20 mm", each.where, deepest=0.02) for each in (FREE, TABLE)]
# engine, kind, hands, and grasps of an object in a round
RUNS: list[tuple[EngineName, Kind, tuple[str, ...], int]] = [
    ("mujoco", FREE, (FIRST,), 40),
    ("mujoco", TABLE, (FIRST,), 40),
    ("pybullet", FREE, OTHERS, 20),
    ("pybullet", DISTURBED, OTHERS, 10),
    ("pybullet", TABLE, OTHERS, 10),
    ("mujoco", ANTIPODAL, (FIRST,), 10),
]
VARIANTS: list[tuple[EngineName, Kind, tuple[str, ...], int]] = [
    ("mujoco", kind, (FIRST,), 40) for kind in (*SHALLOW, *PADS)
]
ROUNDS = [RUNS, RUNS, VARIANTS, RUNS, RUNS, VARIANTS]


def prepare(target: NamedMesh) -> dict[str, Prepared]:
    """Scale an object to each hand, and label 100 grasps of it; its convex parts are made once."""
    known: dict[str, Prepared] = {}
    for hand in (FIRST, *OTHERS):
        gripper = GRIPPERS[hand]
        mesh = scaled_solid(target, gripper, "paper")
        if not known:
            first, density = mesh, Material().density
            made = make_simulation_object(mesh, density, Bundle(), target.label)
        factor = float(mesh.scale / first.scale)
        model = model_at_size(made.mesh, made.parts, factor, density)
        grasps = dataset_grasps(mesh, target.id, label_parameters(gripper, 100, 0))
        known[hand] = Prepared(target.label, target.id, model, grasps)
    return known


def try_grasps(
    this: Prepared, hand: str, engine: EngineName, kind: Kind, numbers: range
) -> pd.DataFrame:
    """The outcome of each grasp of one kind at an object."""
    outcomes = _outcomes(this, hand, engine, kind, numbers)
    return pd.DataFrame({"label": this.label, "outcome": [each.value for each in outcomes]})


def _outcomes(
    this: Prepared, hand: str, engine: EngineName, kind: Kind, numbers: range
) -> list[Outcome]:
    gripper = GRIPPERS[hand].model_copy(update={"friction": kind.friction})
    purpose = ("success-rates", kind.where, this.id)
    rngs = [generator(SEEDS[engine], *purpose, number) for number in numbers]
    if kind.where == "table":
        with open_world(engine, [this.model], free_hand(gripper)) as world:
            return [try_on_table(world, rng, kind.deepest) for rng in rngs]
    arm = TurningAxis(gripper)
    if kind.where == "free":
        with open_world(engine, [this.model], arm.robot) as world:
            return [try_in_free_space(world, arm, Lifting(), rng, kind.deepest) for rng in rngs]
    chosen = this.grasps[this.grasps["collision_free"]].iloc[numbers.start : numbers.stop]
    if kind.where == "disturbed":
        moved = disturb(chosen, generator(SEEDS[engine], *purpose, hand, numbers.start))
        with open_world(engine, [this.model], arm.robot) as world:
            return [_lifted(world, arm, row) for row in parquet.records(moved)]
    settings = SimulatedLabelParameters(
        gripper=gripper,
        quality=Quality(friction=kind.friction),
        trials=Lifting(engine=engine),
        simulated_label=SimulatedLabel(engine=engine),
    )
    return [each.outcome for each in simulate_grasps(this.model, chosen, settings)]


def _lifted(world: World, arm: TurningAxis, row: dict[str, Any]) -> Outcome:
    """A labelled grasp, closed in free space and lifted."""
    start, grasp = floating_pose(world.model, row, arm.robot.gripper)
    world.reset()
    world.place(start)
    return execute(world, arm, Lifting(), grasp, afloat=True, contact=row["width"]).outcome


def disturb(grasps: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Grasps at which the hand is displaced from the planned pose."""
    turns = Rotation.from_rotvec(rng.normal(0, TURN, (len(grasps), 3)))
    moved = {
        **_columns("center", grasps, lambda at: at + rng.normal(0, SHIFT, at.shape)),
        **_columns("axis", grasps, turns.apply),
        **_columns("approach", grasps, turns.apply),
    }
    return grasps.assign(**moved)


def _columns(
    name: str, grasps: pd.DataFrame, change: Callable[[Floats], Floats]
) -> dict[str, Floats]:
    names = vector_names(name)
    changed = change(grasps[names].to_numpy(dtype=np.float64, copy=True))
    return {name: changed[:, part] for part, name in enumerate(names)}


def run(folder: Path, jobs: int) -> None:
    """Try all grasps that are missing."""
    folder.mkdir(parents=True, exist_ok=True)
    with workers(jobs) as mapper:
        if not (path := folder / "objects.pickle").exists():
            found = list(mapper(prepare, named_meshes(egad.load("evaluation-set"))))
            with atomic_output(path) as out:
                out.write_bytes(pickle.dumps(found))
        objects = _prepared(folder)
        for number, runs in enumerate(ROUNDS):
            for engine, kind, hands, count in runs:
                done = sum(runs == each for each in ROUNDS[:number]) * count
                for hand in hands:
                    path = folder / engine / kind.name / hand / f"{number}.parquet"
                    if path.exists():
                        continue
                    tried = partial(
                        try_grasps,
                        hand=hand,
                        engine=engine,
                        kind=kind,
                        numbers=range(done, done + count),
                    )
                    table = pd.concat(mapper(tried, [each[hand] for each in objects]))
                    path.parent.mkdir(parents=True, exist_ok=True)
                    with atomic_output(path) as out:
                        table.to_parquet(out)
                    print(path, flush=True)


def measures(folder: Path) -> pd.DataFrame:
    """Measures of the objects with the first hand, by label; high is easy."""
    known = {each[FIRST].label: each[FIRST].grasps for each in _prepared(folder)}
    grasps = pd.concat(known, names=["label"])
    each = grasps.groupby("label")
    table: pd.DataFrame = pd.DataFrame(
        {
            "antipodal grasps that hold": _rates(folder, "mujoco", ANTIPODAL, FIRST),
            "75th percentile of robust quality": each["robust_quality"].quantile(0.75),
            "75th percentile of quality": each["quality"].quantile(0.75),
            "mean robust success rate": each["robust_success_rate"].mean(),
            "antipodal grasps without collision": each["collision_free"].mean(),
            "naive, free space": _rates(folder, "mujoco", FREE, FIRST),
            "naive, table": _rates(folder, "mujoco", TABLE, FIRST),
        }
    )
    ranks = table.rank()
    robust, free, on_table = (ranks[table.columns[number]] for number in (1, 5, 6))
    return table.assign(
        **{
            "ranks: robust quality, free space": robust + free,
            "ranks: robust quality, table": robust + on_table,
            "ranks: robust quality, free space, table": robust + free + on_table,
            "free space, collisions left out": _rates(
                folder, "mujoco", FREE, FIRST, left_out=Outcome.COLLIDED
            ),
            "table, collisions left out": _rates(
                folder, "mujoco", TABLE, FIRST, left_out=Outcome.COLLIDED
            ),
            "free space, held after closing": _rates(folder, "mujoco", FREE, FIRST, HELD),
            **{
                kind.name: _rates(folder, "mujoco", kind, FIRST)
                for kind in (*SHALLOW, *PADS)
                if (folder / "mujoco" / kind.name).exists()
            },
        }
    )


def targets(folder: Path, trials: Path | None) -> pd.DataFrame:
    """What the measures are ranked against, by label."""
    found = {
        name: pd.concat([_rates(folder, "pybullet", kind, hand) for hand in OTHERS], axis=1).mean(
            axis=1
        )
        for name, kind in (
            ("naive, free space", FREE),
            ("naive, table", TABLE),
            ("disturbed antipodal", DISTURBED),
        )
    }
    if trials is not None:
        files = [
            trials / "mujoco" / contact / "typical" / f"{name}.parquet"
            for contact in ("collided", "close")
            for name in DETECTORS
        ]
        tried = pd.concat([pd.read_parquet(file) for file in files])
        found["detectors"] = tried.groupby("label")["success"].mean()
    return pd.DataFrame(found)


def _rates(
    folder: Path,
    engine: EngineName,
    kind: Kind,
    hand: str,
    held: tuple[Outcome, ...] = (Outcome.SUCCESS,),
    left_out: Outcome | None = None,
) -> pd.Series:
    """How often the grasps of each object succeeded; 0 where none is left."""
    files = sorted((folder / engine / kind.name / hand).glob("*.parquet"))
    table = pd.concat([pd.read_parquet(file) for file in files])
    known = table[~table["outcome"].isin([*SIMULATION_FAILURES, left_out])]
    rates = known["outcome"].isin(held).groupby(known["label"]).mean()
    return rates.reindex(table["label"].unique()).fillna(0.0)


def report(folder: Path, trials: Path | None) -> None:
    """Print how many grasps there are, the rank correlations, and how far each is from the best."""
    for path in sorted(folder.glob("*/*/*")):
        count = sum(len(pd.read_parquet(file)) for file in path.glob("*.parquet"))
        print(f"{path.relative_to(folder)}: {count} grasps")
    wanted = targets(folder, trials)
    names = list(map(str, wanted))
    print(f"\n| measure | {' | '.join(names)} | spread |\n{'| --- ' * (len(names) + 2)}|")
    for name, values in measures(folder).items():
        cells = [str(_cell(values, wanted[target])) for target in names]
        low, high = np.percentile(values, (10, 90))
        print(f"| {name} | {' | '.join(cells)} | {low:.3g} to {high:.3g} |")
    print(f"\n{wanted.corr('spearman').round(2).to_markdown()}")


def _cell(values: pd.Series, rates: pd.Series) -> str:
    found = trend(values.reindex(rates.index).to_numpy(), rates.to_numpy())
    return f"{found.rho:.2f} ({found.ci_low:.2f} to {found.ci_high:.2f})"


def _prepared(folder: Path) -> list[dict[str, Prepared]]:
    data = (folder / "objects.pickle").read_bytes()
    return pickle.loads(data)  # type: ignore[no-any-return]  # noqa: S301 (this file is ours)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--trials", type=Path)
    parser.add_argument("--report", action="store_true", help="only print what is there")
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    if not chosen.report:
        run(chosen.folder, chosen.jobs)
    report(chosen.folder, chosen.trials)
