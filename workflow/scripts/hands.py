"""hands: the same evaluation objects, tried with each gripper, and a report card."""

from functools import partial
from pathlib import Path

from egad.bench.hands import ComparedHands, HandParameters, HandTrials, compare_at
from egad.io import read_mesh
from egad.objects import NamedMesh
from egad.report.hands import write_card
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad_workflow.job import run_job


def run(
    settings: ComparedHands,
    names: list[str],
    evaluation: Path,
    meshes: Path,
    card: Path,
    attempts: Path,
    jobs: int = 1,
) -> None:
    """Let some of the grippers try the evaluation set, and write their report card."""
    table = parquet.read(evaluation, EVAL49)
    files = [meshes / f"{label}.obj" for label in table["object_label"]]
    targets = [
        NamedMesh(label, name, partial(read_mesh, file, "m"))
        for label, name, file in zip(table["label"], table["id"], files, strict=True)
    ]
    chosen = HandParameters(
        seed=settings.seed, hands=HandTrials(), planning_time=settings.planning_time
    )
    hands = {name: settings.grippers[name] for name in names}
    compared = compare_at(hands, targets, None, chosen, "paper", jobs)
    compared.save(attempts)
    write_card(compared, card, targets, jobs=jobs)


if __name__ == "__main__":
    run_job(run)
