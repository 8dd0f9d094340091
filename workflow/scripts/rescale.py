"""rescale: the objects of a dataset, scaled to a gripper."""

from pathlib import Path

from egad.exchange import RescaleMeshes, rescale_files
from egad_workflow.job import run_job


def run(settings: RescaleMeshes, meshes: Path, out: Path, jobs: int = 1) -> None:
    """Scale the meshes of a dataset, in metres, to a gripper."""
    rescale_files(settings, sorted(meshes.glob("*.obj")), "m", out, jobs=jobs)


if __name__ == "__main__":
    run_job(run)
