"""Depth images of an object in its stable poses, with the grasps that can be reached."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.geometry import RayCaster, mass_properties
from egad.geometry.stable_poses import stable_poses
from egad.grippers import Body
from egad.perception.camera import DepthCamera, View, object_mask
from egad.perception.noise import add_sensor_noise
from egad.perception.parameters import RenderParameters
from egad.perception.reachability import GraspCandidates, reachable
from egad.perception.rectangles import ImageGrasps, project_grasps
from egad.perception.scenes import sample_object_poses, sample_scene
from egad.perception.splits import Share
from egad.random import generator

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Picture:
    """A depth image of an object on the table, with its grasps.

    Attributes:
        image: Its number in the dataset.
        id: Of the object.
        label: Of the object.
        split: `train`, `validation` or `test`.
        pose: Number of the stable pose.
        view: Depth in metres, not a number where it is missing; the camera and its pose.
        mask: (height, width) which pixels see the object.
        matrix: (4, 4) from the frame of the scaled mesh to the world, whose table is z = 0.
        grasps: The grasps that can be reached from above, in the image.
    """

    image: int
    id: str
    label: str
    split: str
    pose: int
    view: View
    mask: Flags
    matrix: Floats
    grasps: ImageGrasps

    @property
    def depth(self) -> NDArray[np.float32]:
        """Metres along the optical axis, (height, width); not a number where it is missing."""
        return self.view.depth


def pictures(
    mesh: trimesh.Trimesh,
    grasps: GraspCandidates,
    share: Share,
    body: Body,
    settings: RenderParameters,
) -> Iterator[Picture]:
    """All images of an object, in the order of their numbers: by pose, then by view.

    What chance decides comes from the seed, the object, the pose and the number of the view there.

    Args:
        mesh: The object as it is grasped, closed, metres.
        grasps: Its labelled grasps; there may be none.
        share: Its names and how many images it gets.
        body: The hand that is to grasp it.
        settings: Camera, noise, which grasps are reachable.

    Raises:
        RejectedError: It rests in no pose.
    """
    seed, name = settings.seed, share.id
    with np.errstate(invalid="ignore", divide="ignore"):  # flat ones rest in no pose
        com = mass_properties(mesh, 1.0).com
    poses = stable_poses(mesh, com)
    eye, caster = DepthCamera(mesh), RayCaster(mesh)
    way = settings.grasp_label.approach_way
    numbers = sample_object_poses(poses, share.images, generator(seed, "render poses", name))
    image = share.first
    for pose, count in zip(*np.unique(numbers, return_counts=True), strict=True):
        resting = poses[pose].matrix
        tilt = float(np.radians(settings.render.tilt))
        found, free = reachable(caster, grasps, resting, body, tilt=tilt, way=way)
        for view in range(count):
            rng = generator(seed, "render", name, int(pose), view)
            scene = sample_scene(resting, com, settings.camera, rng)
            ideal = eye.render(*scene)
            yield Picture(
                image=image,
                id=name,
                label=share.label,
                split=share.split,
                pose=int(pose),
                view=add_sensor_noise(ideal, settings.image_noise, rng),
                mask=object_mask(ideal),
                matrix=scene.matrix,
                grasps=project_grasps(scene, found, free, settings.gripper),
            )
            image += 1
