"""The physics engines, each loaded only where it is used."""

from collections.abc import Sequence

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
    """A world in an engine, for a `with` block.

    Args:
        engine: Its name.
        models: The objects.
        robot: The robot that may grasp them, if any.
        walls: Inner length and width of a box around the middle, without a floor; none if None.

    Raises:
        UserError: There is no such engine, or it is not installed.
    """
    check_engine(engine)
    if engine == "pybullet":
        from egad.sim.pybullet_world import PyBulletWorld  # noqa: PLC0415 (may not be installed)

        return PyBulletWorld(models, robot, walls)
    from egad.sim.mujoco_world import MujocoWorld  # noqa: PLC0415 (loads the other one in vain)

    return MujocoWorld(models, robot, walls)
