"""Grasp samplers: antipodal grasps for jaws, suction for cups, or the user's own function.

The user's own function is called as `sampler(mesh, gripper, n, rng)`: a closed `trimesh.Trimesh` in
metres, the `egad.Gripper`, how many grasps at most, and a `numpy.random.Generator`. It returns
poses, widths and qualities, as a grasp detector does:

- (k, 4, 4) poses of the hand in the frame of the mesh. The origin is midway between the contacts,
  on the surface for a cup; x is the closing axis, z the approach.
- (k,) distances of the contacts, metres; zeros for a cup.
- (k,) qualities, not negative, higher for better grasps.

It may give fewer than n grasps. They must be independent draws, because graspability is a
percentile of their quality.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import trimesh

from egad import plugins
from egad._util.arrays import Floats
from egad.errors import NoGraspError, UserError
from egad.geometry import Material
from egad.grasps.grasps import are_rigid
from egad.grasps.parameters import Robust, RobustSuction
from egad.grasps.suction import sample_suction, suction_poses
from egad.grippers import ANTIPODAL, SUCTION, Gripper, cup_of

OwnSampler = Callable[[trimesh.Trimesh, Gripper, int, np.random.Generator], Any]
WHERE = "sampler"
BUILT_IN = (ANTIPODAL, SUCTION)
DENSITY = Material().density


class Sampled(NamedTuple):
    """Grasps of a sampler: poses (n, 4, 4), widths (n,) in metres, and qualities (n,)."""

    poses: Floats
    widths: Floats
    quality: Floats


def draw_grasps(
    mesh: trimesh.Trimesh,
    com: Floats,
    gripper: Gripper,
    n: int,
    rng: np.random.Generator,
    *,
    robust: Robust | None = None,
    density: float = DENSITY,
) -> Sampled:
    """At most n grasps of a closed mesh, metres, by a cup or the user's sampler; or an error."""
    if gripper.grasps_with != SUCTION:
        return _own(gripper, mesh, n, rng)
    cup = cup_of(gripper, "the sampler `suction`")
    table = sample_suction(
        mesh,
        cup,
        n,
        seed=int(rng.integers(2**32)),
        density=density,
        center_of_mass=com,
        robust=RobustSuction() if robust is None else RobustSuction(samples=robust.samples),
    )
    return Sampled(suction_poses(table), np.zeros(n), table["quality"].to_numpy(np.float64))


def check_sampler(gripper: Gripper) -> None:
    """Raise `UserError` if the sampler of a gripper does not exist or is not for its kind."""
    name = gripper.grasps_with
    if name in BUILT_IN and name != gripper.kind.sampler:
        other = "jaws" if name == ANTIPODAL else "cups"
        raise UserError(f"the sampler `{name}` is for {other}; the gripper has {gripper.kind.noun}")
    if name not in BUILT_IN:
        plugins.find(name, WHERE, "function")


def own_samplers(grippers: Iterable[Gripper]) -> list[str]:
    """Fingerprints of the files of the user's own samplers, which are not run, or `UserError`."""
    names = [gripper.grasps_with for gripper in grippers]
    return [plugins.source_hash(name, WHERE) for name in names if name not in BUILT_IN]


def _own(gripper: Gripper, mesh: trimesh.Trimesh, n: int, rng: np.random.Generator) -> Sampled:
    """The grasps of the user's own sampler."""
    name = gripper.grasps_with
    function: OwnSampler = plugins.find(name, WHERE, "function")
    given = plugins.call(f"the sampler {name}", lambda: function(mesh.copy(), gripper, n, rng))
    found = _checked(gripper, given, n)
    if not len(found.quality):
        raise NoGraspError(f"the sampler {name} found no grasp")
    return found


def _checked(gripper: Gripper, given: Any, n: int) -> Sampled:  # noqa: ANN401 (whatever it gives)
    """An answer of the user's sampler as grasps, or `UserError`."""
    name = gripper.grasps_with
    wanted = f"the sampler {name} must return poses (k, 4, 4), widths (k,) and qualities (k,)"
    try:
        poses, widths, quality = (np.asarray(part, dtype=np.float64) for part in given)
    except (TypeError, ValueError) as error:
        raise UserError(f"{wanted}, but returned {type(given).__name__}: {error}") from error
    shapes = f"{poses.shape}, {widths.shape} and {quality.shape}"
    count = len(quality) if quality.ndim else 0
    if (poses.shape, widths.shape, quality.shape) != ((count, 4, 4), (count,), (count,)):
        raise UserError(f"{wanted}, but returned arrays of the shapes {shapes}")
    if count > n:
        raise UserError(
            f"the sampler {name} was asked for at most {n} grasps, but returned {count}"
        )
    wrong = {
        "a pose that is not finite": ~np.isfinite(poses).all(axis=(1, 2)),
        "a pose that is not a rotation and a translation": ~are_rigid(poses),
        "a width that is negative or not finite": ~(np.isfinite(widths) & (widths >= 0)),
        f"a width above the opening of {gripper.opening:g} m": widths > gripper.opening,
        "a quality that is negative or not finite": ~(np.isfinite(quality) & (quality >= 0)),
    }
    for what, where in wrong.items():
        if where.any():
            raise UserError(f"the sampler {name} returned {what}: grasp {int(where.argmax())}")
    return Sampled(poses, widths, quality)
