"""bundle: the evaluation set for simulators, scaled to a gripper."""

from pathlib import Path

from egad.exchange import evaluation_objects, write_bundle
from egad.sim import SimulationBundle
from egad_workflow.job import run_job


def run(
    settings: SimulationBundle, evaluation: Path, meshes: Path, out: Path, jobs: int = 1
) -> None:
    """Prepare the evaluation set for simulators: convex parts, URDF, MJCF, poses at rest."""
    write_bundle(settings, evaluation_objects(evaluation, meshes), "m", out, jobs)


if __name__ == "__main__":
    run_job(run)
