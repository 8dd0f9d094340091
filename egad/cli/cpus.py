"""How many CPUs this process may use."""

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path


def available_cpus(root: Path = Path("/")) -> int:
    """CPUs that this process may use: `PYTHON_CPU_COUNT`, else its affinity and control groups."""
    with suppress(KeyError, ValueError):
        return max(int(os.environ["PYTHON_CPU_COUNT"]), 1)
    return max(min([len(os.sched_getaffinity(0)), *map(math.ceil, _quotas(root))]), 1)


def _quotas(root: Path) -> Iterator[float]:
    """CPUs that each control group of this process grants, from its own up to the outermost."""
    groups: dict[str, str] = {}
    for line in _lines(root / "proc/self/cgroup"):  # 4:cpu,cpuacct:/docker/1f2e or 0::/user.slice
        _, controllers, group = line.split(":", 2)
        groups |= dict.fromkeys(controllers.split(","), group)
    for line in _lines(root / "proc/self/mountinfo"):
        mount, _, system = line.partition(" - ")
        kind, _, options = system.split(" ", 2)
        controller = {"cgroup2": "", "cgroup": "cpu"}.get(kind)
        if controller not in groups or controller not in ("", *options.split(",")):
            continue
        top, place = mount.split(" ")[3:5]
        inside = groups[controller].removeprefix(top.rstrip("/")).strip("/")
        folder = root / place.strip("/") / inside
        yield from _quotas_of([folder, *list(folder.parents)[: len(Path(inside).parts)]])


def _quotas_of(folders: list[Path]) -> Iterator[float]:
    for folder in folders:
        numbers = [
            word
            for name in ("cpu.max", "cpu.cfs_quota_us", "cpu.cfs_period_us")
            for line in _lines(folder / name)
            for word in line.split()
        ]
        if len(numbers) == 2 and numbers[0] not in ("max", "-1"):
            yield int(numbers[0]) / int(numbers[1])


def _lines(file: Path) -> list[str]:
    """The lines of a file; none where it is absent or may not be read."""
    try:
        return file.read_text(errors="replace").splitlines()
    except OSError:
        return []
