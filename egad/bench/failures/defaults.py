"""The settings of a search for failures, without a configuration."""

from egad._util.parameters import from_arguments
from egad.bench.failures.parameters import FailureParameters, FailureSearch
from egad.bench.parameters import ContactRule
from egad.evalset import PrintCheck
from egad.evolution import Shape, evolution_parameters
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper


def failure_parameters(
    gripper: Gripper,
    search: FailureSearch,
    *,
    contact: ContactRule | None = None,
    seed: int = 0,
    rule: str = "paper",
    shape: Shape | None = None,
) -> FailureParameters:
    """The settings of a search, with defaults for everything that is not given.

    Args:
        gripper: The gripper that objects are scaled to and grasped with.
        search: The search.
        contact: What a contact on the way down means; by default the attempt fails.
        seed: Seed of everything random.
        rule: How objects are scaled, see `egad.rescale`.
        shape: How voxels become meshes.

    Raises:
        UserError: There is no such rule.
    """
    return FailureParameters(
        seed=seed,
        gripper=gripper,
        rescale=from_arguments(Rescale, rule=rule),
        failures=search,
        trials=contact or ContactRule(),
        material=Material(),
        bundle=Bundle(),
        print_check=PrintCheck(),
        labels=label_parameters(gripper, GraspLabel().grasps, seed),
        breeding=evolution_parameters(seed).model_copy(update={"shape": shape or Shape()}),
    )
