"""The physics engines, each loaded only where it is used."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version

from egad._util.arithmetic import arithmetic
from egad.sim.model import Model
from egad.sim.parameters import EngineName, check_engine
from egad.sim.robot import Robot
from egad.sim.world import World


def open_world(
    engine: EngineName,
    models: Sequence[Model],
    robot: Robot | None = None,
    walls: float | None = None,
) -> World:
    """A world in an engine, in a `with` block; walls of this inner length and width, metres."""
    check_engine(engine)
    if engine == "pybullet":
        with _no_stderr():
            import pybullet  # noqa: F401, PLC0415 (it says when it was built)

        from egad.sim.pybullet_world import PyBulletWorld  # noqa: PLC0415 (may not be installed)

        return PyBulletWorld(models, robot, walls)
    if engine == "drake":
        from egad.sim.drake_world import DrakeWorld  # noqa: PLC0415 (may not be installed)

        return DrakeWorld(models, robot, walls)
    from egad.sim.mujoco_world import MujocoWorld  # noqa: PLC0415 (loads the other one in vain)

    return MujocoWorld(models, robot, walls)


def platform_of(engine: EngineName) -> str:
    """Version of an engine, and what else decides the last bits of a simulation here."""
    return f"{engine} {version(engine)}, {arithmetic()}"


@contextmanager
def _no_stderr() -> Iterator[None]:
    """Discard what compiled code writes to stderr."""
    kept = os.dup(2)
    try:
        with open(os.devnull, "wb") as nothing:  # noqa: PTH123 (a device)
            os.dup2(nothing.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
