"""Grasps of a mesh, labelled."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import ArrayLike

from egad._util.arrays import Floats
from egad._util.parameters import check_count
from egad._util.progress import phase_if_slow
from egad.errors import RejectedError
from egad.friction import FRICTION
from egad.geometry import RayCaster, center_of_mass, check_solid, check_units
from egad.geometry.mass import center_or_given
from egad.grasps.antipodal import SamplingStatistics
from egad.grasps.grasps import Grasps
from egad.grasps.labels import LABELS, label_parameters, rate_grasps, sample_for_labels
from egad.grasps.parameters import APPROACH_ANGLES, APPROACH_WAY, CONE, LabelParameters
from egad.grasps.samplers import check_sampler, draw_grasps
from egad.grippers import ANTIPODAL, Gripper, as_gripper, hand_body
from egad.random import generator


class LabelledGrasps(NamedTuple):
    """Labelled grasps of an object."""

    table: pd.DataFrame  # columns of `tables.grasping.GRASPS` but `id` and `label`; may be empty
    statistics: SamplingStatistics  # how many candidates there were, and why some were rejected
    reason: str = ""  # why there is no grasp; empty if there is one


class Labeller:
    """Samples and rates grasps of objects, as the gripper requires."""

    def __init__(self, settings: LabelParameters) -> None:
        """Read the hand, or raise `UserError` if a file or its sampler cannot be used."""
        self.settings = settings
        self._body = hand_body(settings.gripper)
        check_sampler(settings.gripper)

    def __call__(
        self, mesh: trimesh.Trimesh, com: Floats, rng: np.random.Generator
    ) -> LabelledGrasps:
        """The labelled grasps of an object about a center of mass (3,), metres; `RejectedError`."""
        check_solid(mesh)
        settings, caster = self.settings, RayCaster(mesh)
        gripper, wanted = settings.gripper, settings.grasp_label
        if gripper.grasps_with == ANTIPODAL:
            pairs, statistics = sample_for_labels(caster, settings, rng)
            if not len(pairs):
                return LabelledGrasps(pd.DataFrame(), statistics, f"no grasp ({statistics})")
            return LabelledGrasps(
                rate_grasps(caster, com, pairs, settings, rng, self._body), statistics
            )
        drawn = draw_grasps(
            mesh, com, gripper, wanted.grasps, rng, robust=settings.robust, density=settings.density
        )
        table = LABELS[gripper.kind.name](caster, drawn, self._body, APPROACH_WAY)
        return LabelledGrasps(table, SamplingStatistics(candidates=wanted.grasps))


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

    Jaws get antipodal grasps. A suction cup gets grasps at points uniform over the surface. A
    gripper with a `sampler` gets whatever it returns.

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
        RejectedError: The mesh is open, there is no grasp, or no cup seals; the text says why
            candidates were rejected. Or your own sampler fails.
        UserError: There is no gripper of this name, or a number is not allowed.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.

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
    """The `GRASPS` of a scaled object, as in a dataset (id and seed decide), or `RejectedError`."""
    rng = generator(parameters.seed, "grasps", object_id)
    return _table(Labeller(parameters)(mesh, center_of_mass(mesh), rng))


def _table(found: LabelledGrasps) -> pd.DataFrame:
    if found.reason:
        raise RejectedError(found.reason)
    return found.table
