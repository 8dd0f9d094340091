"""What a search tries: surfaces of objects from their voxels, and their models."""

import warnings

import trimesh

from egad.bench.failures.parameters import FailureParameters
from egad.evolution import packed_surface
from egad.geometry import PartsWarning, rescale
from egad.geometry.repair import repair_for_files
from egad.sim import Model, build

ON_ROUGH = ("screen", "choose")  # purposes of attempts on few convex parts
ROUGH = 0.002  # metres: deviation of convex parts while it is uncertain whether they matter


def surface_of(voxels: bytes, settings: FailureParameters) -> trimesh.Trimesh:
    """The closed surface of an object before it is scaled, metres; RejectedError if none."""
    return repair_for_files(packed_surface(voxels, settings.breeding.shape)).mesh


def scaled_surface(voxels: bytes, settings: FailureParameters) -> trimesh.Trimesh:
    """The surface of an object as the search tries it, metres; see `surface_of`."""
    return scaled_to(surface_of(voxels, settings), settings)


def scaled_to(mesh: trimesh.Trimesh, settings: FailureParameters) -> trimesh.Trimesh:
    """A mesh scaled to the gripper."""
    rule, opening = settings.rescale, settings.gripper.opening
    return rescale(mesh, rule.rule, opening, rule.side_fraction)[0]


def model_of_attempts(
    mesh: trimesh.Trimesh, purpose: str, settings: FailureParameters, name: str = "the mesh"
) -> Model:
    """A scaled object as simulated for a purpose: few convex parts until it may be a failure."""
    bundle = settings.bundle
    if purpose not in ON_ROUGH:
        return build(mesh, settings.material.density, bundle, name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PartsWarning)
        rough = bundle.model_copy(update={"deviation": ROUGH})
        return build(mesh, settings.material.density, rough, name)
