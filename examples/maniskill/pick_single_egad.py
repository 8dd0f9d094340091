"""PickSingleEGAD-v1: a ManiSkill 3 task that picks up one object of EGAD, as PickSingleYCB does.

`import pick_single_egad` registers it; then `gymnasium.make("PickSingleEGAD-v1", objects=FOLDER)`.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import sapien
import torch
import trimesh
from egad_objects import EgadObject, read_objects
from mani_skill.agents.robots import Panda, PandaWristCam
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.sensors.camera import CameraConfig
from mani_skill.utils.building import actors
from mani_skill.utils.registration import register_env
from mani_skill.utils.sapien_utils import look_at
from mani_skill.utils.scene_builder.table import TableSceneBuilder
from mani_skill.utils.structs import Actor, Pose
from mani_skill.utils.structs.types import GPUMemoryConfig, SceneConfig, SimConfig

GOAL_RADIUS = 0.025  # metres
GOAL_HEIGHT = 0.1, 0.3  # metres above the object at rest
AREA = 0.1  # metres: half the side of the square that objects and goals lie in
STATIC = 0.2  # rad/s: a robot whose joints are slower stands still
# Metres at which PhysX begins to compute contacts. With ManiSkill's default, 2 cm, PhysX reports
# that thin convex parts and open fingers overlap although they are apart.
CONTACT_OFFSET = 0.002
READY = [0, 0, 0, -np.pi * 2 / 3, 0, np.pi * 2 / 3, np.pi / 4, 0.04, 0.04]
BASE = sapien.Pose([-0.615, 0, 0])


@register_env("PickSingleEGAD-v1", max_episode_steps=200)
class PickSingleEGADEnv(BaseEnv):
    """Pick up an object of EGAD and hold it at a goal.

    Start: the object lies on the table in one of its stable poses, drawn by probability, turned
    about the vertical by any angle, at most 10 cm from the middle along x and y.

    Goal: a point as far from the middle as the object can be, 10 to 30 cm above it.

    Success: the center of mass is within 2.5 cm of the goal and the robot stands still.

    Options of `reset`: `label`, the object; `pose`, the number of the stable pose in `poses.json`.
    Without a label, an object is drawn whenever the scene is built: at each reset if there is a
    single environment, else once, as in PickSingleYCB.
    """

    SUPPORTED_ROBOTS = ("panda", "panda_wristcam")
    SUPPORTED_REWARD_MODES = ("normalized_dense", "dense", "sparse", "none")
    agent: Panda | PandaWristCam

    def __init__(
        self,
        *args: object,
        objects: str | Path,
        labels: Sequence[str] | None = None,
        robot_uids: str = "panda",
        robot_init_qpos_noise: float = 0.02,
        num_envs: int = 1,
        **kwargs: object,
    ) -> None:
        """Read the objects and build the first scene.

        Args:
            *args: Of `BaseEnv`, as `**kwargs`.
            objects: Folder that `prepare.py` wrote.
            labels: The objects that are drawn; default: all.
            robot_uids: `panda` or `panda_wristcam`.
            robot_init_qpos_noise: Standard deviation of the initial joint angles, radians.
            num_envs: Environments that are simulated together.
            **kwargs: `reconfiguration_freq` is 1 by default for a single environment, else 0.
        """
        self.robot_init_qpos_noise = robot_init_qpos_noise
        self.all_objects = read_objects(objects)
        self.labels = list(labels or self.all_objects)
        self.objects: list[EgadObject] = []  # the one of each environment
        kwargs.setdefault("reconfiguration_freq", 1 if num_envs == 1 else 0)
        super().__init__(*args, robot_uids=robot_uids, num_envs=num_envs, **kwargs)

    def reset(
        self, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        options = dict(options or {})
        if "label" in options and {options["label"]} != {each.folder.name for each in self.objects}:
            options["reconfigure"] = True
        return super().reset(seed=seed, options=options)

    @property
    def _default_sim_config(self) -> SimConfig:
        memory = GPUMemoryConfig(max_rigid_contact_count=2**20, max_rigid_patch_count=2**19)
        contacts = SceneConfig(contact_offset=CONTACT_OFFSET)
        return SimConfig(gpu_memory_config=memory, scene_config=contacts)

    @property
    def _default_sensor_configs(self) -> list[CameraConfig]:
        pose = look_at(eye=[0.3, 0, 0.6], target=[-0.1, 0, 0.1])
        return [CameraConfig("base_camera", pose, 128, 128, np.pi / 2, 0.01, 100)]

    @property
    def _default_human_render_camera_configs(self) -> CameraConfig:
        pose = look_at([0.4, 0.45, 0.35], [-0.05, 0, 0.1])
        return CameraConfig("render_camera", pose, 512, 512, 1, 0.01, 100)

    def _load_agent(self, options: dict[str, Any]) -> None:
        super()._load_agent(options, BASE)

    def _load_scene(self, options: dict[str, Any]) -> None:
        self.table_scene = TableSceneBuilder(self, self.robot_init_qpos_noise)
        self.table_scene.build()
        drawn = self._batched_episode_rng.choice(self.labels)
        labels = [str(options.get("label", label)) for label in drawn]
        self.objects = [self.all_objects[label] for label in labels]
        built = [self._build(number, made) for number, made in enumerate(self.objects)]
        self.obj = Actor.merge(built, name="egad_object")
        self.add_to_state_dict_registry(self.obj)
        self.com = self._tensor([made.com for made in self.objects])
        self.goal_site = actors.build_sphere(
            self.scene,
            radius=GOAL_RADIUS,
            color=[0, 1, 0, 1],
            name="goal_site",
            body_type="kinematic",
            add_collision=False,
            initial_pose=sapien.Pose(),
        )
        self._hidden_objects.append(self.goal_site)

    def _build(self, number: int, made: EgadObject) -> Actor:
        builder = made.builder(self.scene)
        builder.set_scene_idxs([number])
        builder.initial_pose = sapien.Pose(made.poses[0])
        actor = builder.build(name=f"{made.folder.name}-{number}")
        self.remove_from_state_dict_registry(actor)
        return actor

    def _initialize_episode(self, env_idx: torch.Tensor, options: dict[str, Any]) -> None:
        self.table_scene.initialize(env_idx)
        poses, goals, joints = [], [], []
        for index in env_idx.tolist():
            made, rng = self.objects[index], self._batched_episode_rng[index]
            number = options.get("pose", rng.choice(len(made.poses), p=made.probabilities))
            pose = _moved(made.poses[number], rng)
            height = pose[2, :3] @ made.com + pose[2, 3]
            poses.append(sapien.Pose(pose))
            goals.append([*rng.uniform(-AREA, AREA, 2), height + rng.uniform(*GOAL_HEIGHT)])
            joints.append([*rng.normal(READY[:7], self.robot_init_qpos_noise), *READY[7:]])
        self.obj.set_pose(Pose.create(poses, self.device))
        self.goal_site.set_pose(Pose.create_from_pq(self._tensor(goals)))
        self.agent.reset(self._tensor(joints))
        self.agent.robot.set_pose(BASE)

    def _tensor(self, values: list[Any]) -> torch.Tensor:
        return torch.tensor(np.array(values), dtype=torch.float32, device=self.device)

    @property
    def object_center(self) -> torch.Tensor:
        """(n, 3) centers of mass in the world, metres."""
        matrix = self.obj.pose.to_transformation_matrix()
        return (matrix[:, :3, :3] @ self.com[:, :, None])[:, :, 0] + matrix[:, :3, 3]

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Where the object is, and whether the robot holds it still at the goal."""
        center_to_goal = self.goal_site.pose.p - self.object_center
        is_at_goal = torch.linalg.norm(center_to_goal, dim=1) <= GOAL_RADIUS
        is_robot_static = self.agent.is_static(STATIC)
        return {
            "center_to_goal": center_to_goal,
            "is_grasped": self.agent.is_grasping(self.obj),
            "is_at_goal": is_at_goal,
            "is_robot_static": is_robot_static,
            "success": is_at_goal & is_robot_static,
        }

    def _get_obs_extra(self, info: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
        tcp, center = self.agent.tcp.pose, self.object_center
        seen = {"tcp_pose": tcp.raw_pose, "goal_pos": self.goal_site.pose.p}
        seen["is_grasped"] = info["is_grasped"]
        if "state" in self.obs_mode:
            seen |= {"obj_pose": self.obj.pose.raw_pose, "obj_center": center}
            seen |= {"tcp_to_center": center - tcp.p, "center_to_goal": info["center_to_goal"]}
        return seen

    def compute_dense_reward(
        self, obs: object, action: torch.Tensor, info: dict[str, torch.Tensor]
    ) -> torch.Tensor:
        """Up to 1 for nearness to the object, 1 for the grasp, 1 for nearness to the goal; or 4."""
        del obs, action
        reach = torch.linalg.norm(self.object_center - self.agent.tcp.pose.p, dim=1)
        carry = torch.linalg.norm(info["center_to_goal"], dim=1)
        held = info["is_grasped"].float()
        reward = (1 - torch.tanh(5 * reach)) + held * (2 - torch.tanh(5 * carry))
        return torch.where(info["success"], 4.0, reward)

    def compute_normalized_dense_reward(
        self, obs: object, action: torch.Tensor, info: dict[str, torch.Tensor]
    ) -> torch.Tensor:
        """The dense reward over its largest value."""
        return self.compute_dense_reward(obs, action, info) / 4


def _moved(pose: np.ndarray, rng: np.random.RandomState) -> np.ndarray:
    """A stable pose, turned about the vertical and moved on the table at random."""
    angle = rng.uniform(0, 2 * np.pi)
    moved = trimesh.transformations.rotation_matrix(angle, [0, 0, 1]) @ pose
    moved[:2, 3] = rng.uniform(-AREA, AREA, 2)
    return moved
