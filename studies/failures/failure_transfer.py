"""Whether failures last: on fresh drops, on a changed mesh, and for other detectors.

    python studies/failures/failure_transfer.py RUNS OUT.parquet --weights GGCNN2.pt --vgn VGN.pth
        [--failures 30] [--drops 20] [--show]

RUNS is the folder of `failures.py`. For each detector there, at most 30 failures from
all its atlases are tried from 20 fresh drops in each engine: as they are; with a surface that is
simplified by 0.3 mm, moved along its normals by noise of 1 mm, or 5 % smaller or larger, for which
the reference is chosen again; and with every other detector. OUT.parquet keeps the counts, and a
second call resumes. The script prints, with 95 % intervals (Wilson), the share of failures that
last (reference at least 80 %, difference at least 50 points in each engine), and for each detector
and each atlas the success rates of detector and reference. README.md has the tables.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh
from failures import detectors

from egad._util.files import atomic_output
from egad.bench.failures import Examination, FailureAtlas, FailureParameters
from egad.bench.failures.evidence import PairedDrop, pairs_of
from egad.bench.failures.models import model_of_attempts, scaled_surface
from egad.bench.failures.object_runner import ObjectRunner
from egad.bench.failures.reference import ReferencePolicy, read_attempt
from egad.bench.stats import Rate
from egad.detectors import DetectorConfig, opened
from egad.errors import RejectedError, UserError
from egad.geometry import to_mesh, to_solid
from egad.geometry.repair import repair
from egad.random import generator
from egad.tables import parquet

CHANGES = ("none", "simplified", "noise", "smaller", "larger")
WHO = ("detector", "reference")
MIN_REFERENCE, MIN_DIFFERENCE = 0.8, 0.5
LEARNT = ("screen", "choose")  # purposes of the attempts that a reference learns from
PATIENCE = 2  # drops for each one wanted, as the object does not come to rest in all


def learned_from(attempts: pd.DataFrame) -> ReferencePolicy:
    """A reference that learned from an object's attempts for `screen` and `choose`."""
    policy = ReferencePolicy()
    carried_out = attempts["pose"].map(len) > 0
    for row in parquet.records(attempts[attempts["purpose"].isin(LEARNT) & carried_out]):
        policy.remember(*read_attempt(row), row["success"])
    return policy


class Repetition(Examination):
    """Tries detector and reference again at an object that was examined."""

    def paired(
        self, purpose: str, count: int, before: pd.DataFrame, least: int = 0
    ) -> pd.DataFrame:
        """Try both from `count` fresh drops in each engine, with a reference that knows `before`.

        Trying stops once one cannot succeed `least` times in an engine. RejectedError if the object
        cannot be simulated, or does not come to rest.
        """
        self._reference = learned_from(before)
        grasps = self._labelled()
        chosen = before.loc[before["purpose"] == "choose", "drop"]
        left = range(int(chosen.max()) + 1 if len(chosen) else 0, self._search.choose)
        if left:
            rough = model_of_attempts(self._mesh, "choose", self._settings, self._id)
            with self._runners(rough, grasps) as runners:
                for number in left:
                    self._choose_at(runners, number)
        exact = model_of_attempts(self._mesh, purpose, self._settings, self._id)
        with self._runners(exact, grasps) as runners:
            for runner in runners:
                if not self._try_pairs(runner, purpose, count, least):
                    break
        return self._recorder.table()

    def _try_pairs(self, runner: ObjectRunner, purpose: str, count: int, least: int) -> bool:
        """Try both from `count` drops; return False once one cannot succeed often enough."""
        pairs: list[PairedDrop] = []
        for number in range(PATIENCE * count):
            pair = self._paired(runner, purpose, number)
            if pair is None:
                continue
            pairs.append(pair)
            lost = max(len(pairs) - sum(won) for won in zip(*pairs, strict=True))
            if count - lost < least:
                return False
            if len(pairs) == count:
                return True
        raise RejectedError(f"it comes to rest in {len(pairs)} of {PATIENCE * count} drops")


def changed(mesh: trimesh.Trimesh, change: str, name: str) -> trimesh.Trimesh:
    """A mesh with one change, metres.

    Raises:
        RejectedError: It no longer bounds a solid.
    """
    match change:
        case "simplified":
            return to_mesh(to_solid(mesh.vertices, mesh.faces).simplify(0.0003))
        case "noise":
            moved = mesh.copy()
            heights = generator(0, "noise", name).normal(scale=0.001, size=(len(mesh.vertices), 1))
            moved.vertices = mesh.vertices + heights * mesh.vertex_normals
            return repair(moved).mesh
        case "smaller" | "larger":
            return mesh.copy().apply_scale(0.95 if change == "smaller" else 1.05)
    return mesh


def failures_of(runs: Path, most: int) -> tuple[list[dict[str, Any]], FailureParameters]:
    """Failures of a detector from all its searches, with their attempts, and the settings."""
    atlases = [FailureAtlas.load(path.parent) for path in sorted(runs.glob("*/failures.parquet"))]
    rows = {
        row["id"]: row | {"past": atlas.attempts[atlas.attempts["id"] == row["id"]]}
        for atlas in atlases
        for row in atlas.table.to_dict("records")
    }
    settings = atlases[0].settings
    if settings is None:
        raise UserError(f"{runs}: the settings of the search are not known")
    order = generator(0, "failures that are tried again").permutation(sorted(rows))
    return [rows[name] for name in order[:most]], settings


def tried(
    row: dict[str, Any],
    change: str,
    config: DetectorConfig,
    settings: FailureParameters,
    drops: int,
) -> dict[str, int]:
    """Counts of fresh drops in each engine; none if the object cannot be tried."""
    mesh = scaled_surface(row["voxels"], settings)
    past = row["past"] if change == "none" else row["past"].iloc[:0]
    approach = settings.failures.model_copy(update={"approach": None})
    own = settings.model_copy(update={"failures": approach})
    counts = {}
    try:
        solid = changed(mesh, change, row["id"])
        with opened(config, own.planning_time) as asked:
            attempts = Repetition(solid, row["id"], asked, own).paired("again", drops, past)
    except RejectedError:
        return counts
    for engine in settings.failures.engines:
        pairs = pairs_of(attempts, engine, "again")
        counts |= {
            f"drops_{engine}": len(pairs),
            f"reference_{engine}": sum(pair.reference for pair in pairs),
            f"detector_{engine}": sum(pair.detector for pair in pairs),
        }
    return counts


def lasts(row: pd.Series, engines: list[str]) -> bool:
    """Whether an object is a failure in every engine, by the rates of fresh drops."""
    rates = [
        (row[f"reference_{engine}"] / row[f"drops_{engine}"])
        - np.array([0, row[f"detector_{engine}"] / row[f"drops_{engine}"]])
        for engine in engines
    ]
    return all(held >= MIN_REFERENCE and difference >= MIN_DIFFERENCE for held, difference in rates)


def show(table: pd.DataFrame) -> None:
    """Print both tables."""
    engines = [name.removeprefix("drops_") for name in table if name.startswith("drops_")]
    known = table.dropna(subset=[f"drops_{engine}" for engine in engines])
    known = known.assign(lasts=[lasts(row, engines) for _, row in known.iterrows()])
    print("\n| atlas | change | last |\n| --- | --- | --- |")
    own = known[known["atlas"] == known["detector"]]
    for (atlas, change), rows in own.groupby(["atlas", "change"], sort=False):
        print(f"| {atlas} | {change} | {Rate(int(rows['lasts'].sum()), len(rows))} |")
    print("\n| atlas | detector | failures, too | detector, reference |\n| --- | --- | --- | --- |")
    for (atlas, name), rows in known[known["change"] == "none"].groupby(["atlas", "detector"]):
        rates = "; ".join(rates_in(engine, rows) for engine in engines)
        print(f"| {atlas} | {name} | {Rate(int(rows['lasts'].sum()), len(rows))} | {rates} |")


def rates_in(engine: str, rows: pd.DataFrame) -> str:
    """The success rates of detector and reference in an engine."""
    drops = rows[f"drops_{engine}"].sum()
    parts = (f"{100 * rows[f'{who}_{engine}'].sum() / drops:.0f} %" for who in WHO)
    return f"{engine}: {', '.join(parts)}"


def main() -> None:
    """Try failures again, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--weights", type=Path, help="published weights of GG-CNN2")
    parser.add_argument("--vgn", type=Path, help="published weights of VGN")
    parser.add_argument("--failures", type=int, default=30)
    parser.add_argument("--drops", type=int, default=20)
    parser.add_argument("--show", action="store_true")
    given = parser.parse_args()
    known = detectors(given.weights, given.vgn)
    rows = pd.read_parquet(given.out).to_dict("records") if given.out.exists() else []
    done = {(row["atlas"], row["detector"], row["change"], row["id"]) for row in rows}
    atlases = [name for name in known if any((given.runs / name).glob("*/failures.parquet"))]
    wanted = [(atlas, atlas, change) for atlas in atlases for change in CHANGES]
    wanted += [(atlas, name, "none") for atlas in atlases for name in known if name != atlas]
    for atlas, name, change in [] if given.show else wanted:
        failures, settings = failures_of(given.runs / atlas, given.failures)
        for row in failures:
            key = {"atlas": atlas, "detector": name, "change": change, "id": row["id"]}
            if tuple(key.values()) in done:
                continue
            rows.append(key | tried(row, change, known[name], settings, given.drops))
            with atomic_output(given.out) as temporary:
                pd.DataFrame(rows).to_parquet(temporary)
    show(pd.DataFrame(rows))


if __name__ == "__main__":
    main()
