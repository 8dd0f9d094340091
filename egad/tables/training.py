"""The tables of a training."""

import pyarrow as pa

from egad.tables.columns import integer, real, schema

HISTORY = schema(
    integer("epoch", "number of the epoch, from 0"),
    integer("images", "number of training examples so far"),
    real("loss", "mean over the epoch of the summed squared errors of the maps"),
    real("quality_loss", "share of the quality map in the loss"),
    real("cosine_loss", "share of the cos 2a map in the loss"),
    real("sine_loss", "share of the sin 2a map in the loss"),
    real("width_loss", "share of the width map in the loss"),
    real("validation_loss", "loss on the validation set after the epoch"),
    real(
        "validation_score",
        "fraction of the validation images whose best grasp agrees with a positive one",
    ),
)

SCORE = schema(
    integer("n_correct", "number of test images whose best grasp agrees with a positive one"),
    integer("n_images", "number of test images with a positive grasp"),
    integer("objects", "number of objects in these images"),
    real("ci_low", "lower end of the 95 % confidence interval of the fraction that agrees"),
    real("ci_high", "upper end of this interval"),
    real("loss", "mean loss over all test images"),
)

SCENE_HISTORY = schema(
    integer("epoch", "number of the epoch, from 0"),
    integer("scenes", "number of training examples so far"),
    real("loss", "mean loss over the epoch"),
    real("quality_loss", "share of the quality: weighted binary cross-entropy"),
    real("rotation_loss", "share of the rotation at positive grasps"),
    real("width_loss", "share of the width at positive grasps"),
    real("validation_loss", "loss on the validation set after the epoch"),
    real(
        "validation_average_precision",
        "average precision of the quality at the labelled grasps of the validation set",
    ),
)


def _estimate(name: str, meaning: str, unit: str = "") -> list[pa.Field]:
    """A column, and two for its interval."""
    return [
        real(name, meaning, unit),
        real(f"{name}_ci_low", "lower end of its 95 % confidence interval", unit),
        real(f"{name}_ci_high", "upper end of this interval", unit),
    ]


SCENE_SCORE = schema(
    integer("n_scenes", "number of test scenes"),
    integer("n_grasps", "number of labelled grasps in these scenes"),
    integer("n_positive", "number of these grasps that succeeded"),
    *_estimate("average_precision", "average precision of the quality at the labelled grasps"),
    *_estimate(
        "balanced_accuracy",
        "mean of the fractions of positive and negative grasps classified correctly at a "
        "quality of 0.5",
    ),
    *_estimate(
        "angle_error", "mean error of the rotation at positive grasps, up to symmetry", "degree"
    ),
    *_estimate("width_error", "mean error of the width at positive grasps", "m"),
    real("loss", "mean loss over all grasps"),
)
