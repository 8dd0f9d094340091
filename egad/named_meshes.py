"""Meshes by name: those of a dataset, or a user's own, and each as it is grasped and simulated."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import trimesh

from egad.errors import UserError
from egad.geometry import SIDE_FRACTION, Bundle, Material, check_units, rescale, wind_outwards
from egad.grippers import Gripper
from egad.objects import Dataset
from egad.sim import Model, build


class NamedMesh(NamedTuple):
    """A mesh that is made when it is needed.

    Attributes:
        label: Its name.
        id: Name of its shape, which seeds everything random about it.
        mesh: Gives the mesh, metres.
    """

    label: str
    id: str
    mesh: Callable[[], trimesh.Trimesh]


def named_meshes(objects: Dataset | Mapping[str, trimesh.Trimesh]) -> list[NamedMesh]:
    """The objects of a dataset, or meshes by name.

    Raises:
        UserError: There are none, or the argument is something else.
    """
    if not isinstance(objects, Dataset | Mapping):
        raise UserError(_not_objects(type(objects).__name__))
    if not len(objects):
        raise UserError("there are no objects; give a dataset or meshes by name")
    if isinstance(objects, Dataset):
        return [NamedMesh(each.label, each.id, partial(getattr, each, "mesh")) for each in objects]
    for name in objects:
        if not isinstance(name, str):
            raise UserError(_not_objects(f"the name {name!r}"))
    if isinstance(objects, dict):  # a process that gets a mesh need not get all of them
        return [NamedMesh(name, name, partial(_itself, mesh)) for name, mesh in objects.items()]
    return [NamedMesh(name, name, partial(objects.__getitem__, name)) for name in objects]


def _not_objects(given: str) -> str:
    return (
        "objects must be a dataset, as `egad.load` and `dataset.select` return, or a dictionary of "
        f"meshes by name, such as {{'mug': mesh}}; got {given}"
    )


def scaled_solid(target: NamedMesh, gripper: Gripper, rule: str) -> trimesh.Trimesh:
    """The mesh of an object as it is grasped: a closed surface wound outwards, scaled, metres.

    Args:
        target: The object.
        gripper: What it is scaled to.
        rule: See `egad.rescale`.

    Raises:
        RejectedError: The mesh does not bound a solid, or is flat.
        UserError: It is not a mesh, or its file is missing.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
    """
    mesh = target.mesh()
    check_units(mesh, f"the mesh {target.label!r}")
    solid = wind_outwards(mesh)
    return rescale(solid, rule, gripper.opening, SIDE_FRACTION)[0]


def simulated(target: NamedMesh, gripper: Gripper, rule: str) -> tuple[trimesh.Trimesh, Model]:
    """The mesh of an object as it is grasped, and its default model for simulations.

    Args:
        target: The object.
        gripper: What it is scaled to.
        rule: See `egad.rescale`.

    Raises:
        RejectedError: The mesh does not bound a solid, is flat, or has no convex parts.
        UserError: It is not a mesh, or its file is missing.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
        PartsWarning: The object needs more convex parts than are allowed.
    """
    mesh = scaled_solid(target, gripper, rule)
    return mesh, build(mesh, Material().density, Bundle(), target.label)


def _itself(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    return mesh
