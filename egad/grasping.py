"""Grasps of a mesh, labelled."""

import pandas as pd
import trimesh
from numpy.typing import ArrayLike

from egad._util.parameters import check_count
from egad._util.progress import phase_if_slow
from egad.errors import RejectedError
from egad.geometry import check_units
from egad.grasps import (
    APPROACH_ANGLES,
    CONE,
    FRICTION,
    Grasps,
    LabelParameters,
    label_parameters,
)
from egad.grippers import Gripper, as_gripper
from egad.measures import center_of_mass
from egad.meshes import center_or_given
from egad.random import generator
from egad.samplers import LabelledGrasps, Labeller


@phase_if_slow("sampling grasps")
def sample_grasps(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    n: int = 500,
    *,
    seed: int = 0,
    friction: float = FRICTION,
    cone: float = CONE,
    approach_angles: int = APPROACH_ANGLES,
    center_of_mass: ArrayLike | None = None,
) -> Grasps:
    """Sample grasps of a mesh, with their quality and collisions of the hand.

    Jaws get antipodal grasps, a suction cup points that are uniform over the surface, and a gripper
    with a `sampler` what this gives.

    Args:
        mesh: A closed mesh in metres, as it is grasped: see `rescale`.
        gripper: The gripper, or its name.
        n: The largest number of grasps. Fewer antipodal ones are returned if no more are found that
            are at least 2.5 mm apart.
        seed: The same mesh and seed give the same grasps.
        friction: Coulomb friction coefficient that the quality of jaws is computed with.
        cone: Tangent of the widest angle between the closing axis and the normals of a sampled
            grasp. Grasps outside the friction cone slip: their quality is 0.
        approach_angles: Directions around the closing axis from which the hand is tested for
            collisions, evenly spaced.
        center_of_mass: (3,) metres; by default that of a solid of uniform density.

    Returns:
        At least one grasp, in the frame of the mesh.

    Raises:
        RejectedError: The mesh is open, or there is no grasp, or no cup seals; the text says what
            became of the candidates. Or a sampler of your own fails.
        UserError: There is no gripper of this name, or a number is not allowed.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit than the metre.

    Source: jaws: Mahler et al., Dex-Net 2.0, RSS 2017 (sampling); Ferrari and Canny, ICRA 1992
    (quality). Cups: Mahler et al., Dex-Net 3.0, ICRA 2018.
    """
    check_units(mesh)
    hand = as_gripper(gripper)
    parameters = label_parameters(
        hand,
        check_count("n", n),
        seed,
        friction=friction,
        cone=cone,
        approach_angles=approach_angles,
    )
    com = center_or_given(mesh, center_of_mass)
    rng = generator(parameters.seed, "sample_grasps")
    return Grasps(_table(Labeller(parameters)(mesh, com, rng)))


def dataset_grasps(
    mesh: trimesh.Trimesh, object_id: str, parameters: LabelParameters
) -> pd.DataFrame:
    """The labelled grasps of a scaled object, the same as in a dataset of the pipeline.

    Args:
        mesh: A closed mesh in metres.
        object_id: Id of the object; with the seed it decides the grasps.
        parameters: The gripper, the seed, how many grasps, and how to rate them.

    Returns:
        Columns of `tables.grasping.GRASPS` without `id` and `label`.

    Raises:
        RejectedError: The mesh is open, or there is no grasp.
    """
    rng = generator(parameters.seed, "grasps", object_id)
    return _table(Labeller(parameters)(mesh, center_of_mass(mesh), rng))


def _table(found: LabelledGrasps) -> pd.DataFrame:
    if found.reason:
        raise RejectedError(found.reason)
    return found.table
