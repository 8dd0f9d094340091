"""export: objects, grasps or images of a gripper in the format of another program."""

from pathlib import Path
from typing import Any

from egad.exchange import ObjectSet, settings_class, sources, write_format
from egad_workflow.job import run_job


def run(
    settings: dict[str, Any],
    dataset: Path,
    gripper: str,
    format_name: str,
    chosen: ObjectSet,
    out: Path,
) -> None:
    """Write a folder in a format; `chosen` are the objects, for a format of objects."""
    parsed = settings_class(format_name, chosen).model_validate(settings)
    reads = {name: dataset / file for name, file in sources(format_name, gripper, chosen).items()}
    write_format(format_name, chosen, parsed, gripper, reads, out)


if __name__ == "__main__":
    run_job(run)
