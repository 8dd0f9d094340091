"""Depth images of objects at rest on a table, with the grasps that can be reached from above."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad.bench import SceneKind
from egad.detectors import DepthCamera, View, add_sensor_noise
from egad.detectors.observation import overlaid
from egad.geometry import RayCaster, StablePose, mass_properties, resting_poses
from egad.grippers import HandBody
from egad.learning.images.arrangement import (
    PlacedObject,
    Simulate,
    TableGrasps,
    is_good,
    near_level,
    place,
    sample_factor,
    table_grasps,
)
from egad.learning.images.parameters import RenderParameters
from egad.learning.images.rectangles import ImageGrasps, project_grasps
from egad.learning.images.splits import Share
from egad.learning.images.viewpoints import sample_object_poses, sample_scene
from egad.random import generator

DRAWS = 10  # of pose and size, until there is a good grasp

Arrangement = tuple[PlacedObject, ...]
Draw = Callable[[np.random.Generator, int], Arrangement]
"""Puts objects on a table; the number of the draw is 0 for the first. Empty if that failed."""


class ImagedObject(NamedTuple):
    """An object in an image: factor / the mesh scaled; matrix to the table; pose, or -1."""

    id: str
    factor: float
    pose: int
    matrix: Floats


@dataclass(frozen=True)
class RenderedImage:
    """A depth image of objects on a table, with the grasps that can be reached from above."""

    image: int
    scene: SceneKind
    id: str
    label: str
    split: str
    draws: int
    objects: tuple[ImagedObject, ...]
    view: View
    grasps: ImageGrasps

    @property
    def depth(self) -> NDArray[np.float32]:
        """Metres along the optical axis, (height, width); NaN where it is missing."""
        return self.view.depth

    @property
    def mask(self) -> NDArray[np.uint8]:
        """(height, width) k for pixels that see the k-th object, from 1; else 0."""
        return self.view.mask


class Labelled(NamedTuple):
    """Objects on a table, their grasps, and how many times they were drawn."""

    objects: Arrangement
    grasps: TableGrasps
    draws: int


def pictures(
    mesh: trimesh.Trimesh,
    share: Share,
    body: HandBody,
    settings: RenderParameters,
    simulate: Simulate | None = None,
) -> Iterator[RenderedImage]:
    """All images of an object (closed, m) that lies alone; RejectedError if it has no pose."""
    seed, name = settings.seed, share.id
    with np.errstate(invalid="ignore", divide="ignore"):  # flat objects rest in no pose
        com = mass_properties(mesh, 1.0).com
    poses = resting_poses(mesh, com)
    numbers = sample_object_poses(poses, share.images, generator(seed, "render poses", name))
    image, alone = share.first, _LyingAlone(name, mesh, com, poses, settings)
    for pose, count in zip(*np.unique(numbers, return_counts=True), strict=True):
        same = settings.render.widths is None  # views of one pose and size share their grasps
        for view in range(1 if same else count):
            key = (name, int(pose), view)
            draw = partial(alone.draw, int(pose), draw_width(settings, *key))
            labelled = first_good(draw, body, settings, key, simulate)
            if labelled is not None:
                views = count if same else 1
                shown = share._replace(first=image + (0 if same else view), images=views)
                yield from views_of(labelled, shown, settings, key)
        image += int(count)


def first_good(
    draw: Draw,
    body: HandBody,
    settings: RenderParameters,
    key: Sequence[str | int],
    simulate: Simulate | None = None,
) -> Labelled | None:
    """The first of ten draws with a good grasp, or the first if none is needed; None without."""
    for number in range(DRAWS):
        rng = generator(settings.seed, "render grasps", *key, number)
        objects = draw(rng, number)
        if not objects:
            continue
        grasps = table_grasps(objects, body, settings, rng, simulate)
        good = is_good(grasps.free, grasps.qualities, grasps.success, settings.render.quality)
        if settings.render.without_grasps or good.any():
            return Labelled(objects, grasps, number + 1)
    return None


def views_of(
    labelled: Labelled, share: Share, settings: RenderParameters, key: Sequence[str | int]
) -> Iterator[RenderedImage]:
    """Images of objects on a table, each from a camera of its own, by `key` as in `first_good`."""
    eyes = [DepthCamera(each.mesh) for each in labelled.objects]
    first = labelled.objects[0]
    center = first.matrix[:3, :3] @ first.com + first.matrix[:3, 3]
    for view in range(share.images):
        rng = generator(settings.seed, "render", *key, view)
        scene = sample_scene(center, settings.camera, rng)
        matrices = [scene.matrix @ each.matrix for each in labelled.objects]
        each_alone = [
            eye.render(matrix, scene.intrinsics, scene.camera)
            for eye, matrix in zip(eyes, matrices, strict=True)
        ]
        ideal = overlaid(each_alone)
        yield RenderedImage(
            image=share.first + view,
            scene=share.scene,
            id=share.id,
            label=share.label,
            split=share.split,
            draws=labelled.draws,
            objects=tuple(
                ImagedObject(each.id, each.factor, each.pose, matrix)
                for each, matrix in zip(labelled.objects, matrices, strict=True)
            ),
            view=add_sensor_noise(ideal, settings.image_noise, rng),
            grasps=project_grasps(scene, labelled.grasps, settings.gripper),
        )


def draw_width(settings: RenderParameters, name: str, *key: str | int) -> float | None:
    """The width of a grasp that determines the size of an object, metres; None if none does."""
    if settings.render.widths is None:
        return None
    return float(generator(settings.seed, "width", name, *key).uniform(*settings.render.widths))


@dataclass(frozen=True)
class _LyingAlone:
    """An object alone on a table, in its stable poses."""

    name: str
    mesh: trimesh.Trimesh
    com: Floats
    poses: Sequence[StablePose]
    settings: RenderParameters

    @cached_property
    def caster(self) -> RayCaster:
        """Ray caster of the mesh; only random sizes need it."""
        return RayCaster(self.mesh)

    def draw(
        self, first: int, width: float | None, rng: np.random.Generator, number: int
    ) -> Arrangement:
        """The object in the first pose, or after the first draw in any, in its random size."""
        probabilities = np.array([each.probability for each in self.poses])
        shares = probabilities / probabilities.sum()
        pose = int(rng.choice(len(self.poses), p=shares)) if number else first
        resting, factor = self.poses[pose].matrix.copy(), 1.0
        if width is not None:
            level = near_level(resting[2, :3], self.settings.render.tilt)
            factor = sample_factor(self.caster, width, self.settings.sampling, rng, level)
        if factor == 0:
            return ()
        resting[:3, 3] *= factor
        return (place(self.name, self.mesh, self.com, factor, resting, pose),)
