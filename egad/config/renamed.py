"""Settings of older versions, and what they are now: the table in CHANGELOG.md, for messages."""

from collections.abc import Sequence

STUDY = "in the configuration of experiments/training_study"
RENAMED = {
    "policies": "detectors",
    "targets.policies": "targets.detectors",
    "axes": "measures",
    "part": "keep_solid",
    "diversity": STUDY,
    "training_study": STUDY,
    "training_sets": STUDY,
    "evolution.regrade": "evolution.estimator: sequential, which does more",
    "difficulty": "graspability",
    "measures.difficulty": "measures.graspability",
    "space.difficulty_range": "space.graspability_range",
    "targets.difficulty": "targets.graspability",
    "graspability.grasps": "evolution.grasps, for evolution.estimator: paper; else "
    "graspability.candidates and evolution.max_candidates",
    "postprocess.grasps": "postprocess.max_candidates",
    "graspability.metric: plain": "graspability.metric: nominal",
    "trials.between": "trials.reset: continue, redrop",
    "trials.engine: auto": "trials.engine: mujoco or pybullet",
    "clutter.views": "clutter.protocol.cameras.views",
    "clutter.scale": "clutter.protocol.scale",
    "limits.box_part": "limits.box_fraction",
    "limits.cube_part": "limits.cube_fraction",
    "image_noise.shadows": "image_noise.holes, on steep surfaces too",
    "render.part": "render.subset",
    "acronym.held": "acronym.min_robust_success_rate",
    "space.neighbours": "space.neighbors",
    "envelope.centre": "envelope.center",
    "hole.centre": "hole.center",
    "training.patience": "nothing (the learning rate falls to 0, and the last weights are the "
    "result)",
    "print_export.shell": "print_export.perimeters, print_export.line_width, "
    "print_export.solid_layers",
}


def new_name(path: Sequence[str | int], value: object = None) -> str:
    """What a setting of an older version is called now; empty if none was called so.

    Args:
        path: Where the setting stands.
        value: Its value, of which only the old name may be known.
    """
    name = ".".join(map(str, path))
    return RENAMED.get(name) or RENAMED.get(f"{name}: {value}", "")
