"""What predicts that a grasp holds: `simulated_labels.py results/D GRIPPER` in this folder.

Prints the outcomes of the simulated grasps of all objects; the area under the ROC curve of each
rating of a grasp against its simulated success, with a 95 % interval for other objects; the same
for thirds of the objects by graspability; and rank correlations over objects of the share of their
grasps that hold (`antipodal_success_rate`) with other measures of them.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from egad.bench.stats import area, trend
from egad.sim import antipodal_success_rates
from egad.tables import parquet
from egad.tables.grasping import SIMULATED_GRASPS
from egad.tables.objects import OBJECTS

RATINGS = ("quality", "robust_quality", "robust_success_rate")
THIRDS = 3


def main(results: Path, gripper: str) -> None:
    """Print the tables."""
    table = parquet.read(results / "grasps" / f"{gripper}.parquet", SIMULATED_GRASPS)
    objects = parquet.read(results / "objects.parquet", OBJECTS)
    known = table[table["simulated_success"].notna()]
    print(f"{len(known)} grasps of {known['id'].nunique()} objects\n")
    print(f"{known['simulated_outcome'].value_counts(normalize=True).to_markdown()}\n")
    print("| rating | all grasps | grasps of one object |\n| --- | --- | --- |")
    success = known["simulated_success"].to_numpy(dtype=bool)
    names = known["id"].to_numpy(dtype=str)
    for rating in RATINGS:
        found = area(known[rating].to_numpy(), success, names)
        low, high = found.interval
        print(f"| {rating} | {found.value:.3f} ({low:.3f} to {high:.3f}) | {found.within:.3f} |")
    print("\n| rating | hardest third | middle | easiest third |\n| --- | --- | --- | --- |")
    for rating in RATINGS:
        print(f"| {rating} | {' | '.join(by_thirds(known, objects, rating))} |")
    summary = antipodal_success_rates(known)
    print("\n| measure | rank correlation with antipodal_success_rate |\n| --- | --- |")
    for name, rho in correlations(summary, table, objects):
        print(f"| {name} | {rho} |")


def by_thirds(known: pd.DataFrame, objects: pd.DataFrame, rating: str) -> Iterator[str]:
    """The area under the ROC curve of a rating in each third of the objects, the hardest first."""
    rank = objects.set_index("id")["graspability"].rank(pct=True).reindex(known["id"]).to_numpy()
    third = np.minimum((rank * THIRDS).astype(np.int64), THIRDS - 1)
    for number in range(THIRDS):
        own = known[third == number]
        success = own["simulated_success"].to_numpy(dtype=bool)
        found = area(own[rating].to_numpy(), success, own["id"].to_numpy(dtype=str))
        yield f"{found.value:.3f}"


def correlations(
    summary: pd.DataFrame, table: pd.DataFrame, objects: pd.DataFrame
) -> Iterator[tuple[str, str]]:
    """Names of measures of objects, and their rank correlations with the antipodal success rate."""
    per_object = table.groupby("id").agg(
        **{
            "graspability, 75th percentile of quality": ("quality", lambda x: x.quantile(0.75)),
            "75th percentile of robust quality": ("robust_quality", lambda x: x.quantile(0.75)),
            "mean robust success rate": ("robust_success_rate", "mean"),
            "share of collision-free grasps": ("collision_free", "mean"),
        }
    )
    columns = objects.set_index("id")[["graspability", "complexity"]].join(per_object)
    ordered = columns.reindex(summary["id"])
    for name in ordered:
        values = ordered[name].to_numpy(dtype=np.float64)
        found = trend(values, summary["antipodal_success_rate"].to_numpy())
        yield name, f"{found.rho:.2f} ({found.ci_low:.2f} to {found.ci_high:.2f})"


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
