"""The tables of a training."""

import pyarrow as pa

from egad.tables.columns import FLOAT, INT, column

HISTORY = pa.schema(
    [
        column("epoch", INT, "number of the epoch, from 0"),
        column("images", INT, "number of training examples so far"),
        column("loss", FLOAT, "mean over the epoch of the summed squared errors of the maps"),
        column("quality_loss", FLOAT, "share of the quality map in the loss"),
        column("cosine_loss", FLOAT, "share of the cos 2a map in the loss"),
        column("sine_loss", FLOAT, "share of the sin 2a map in the loss"),
        column("width_loss", FLOAT, "share of the width map in the loss"),
        column("validation_loss", FLOAT, "loss on the validation set after the epoch"),
        column(
            "validation_score",
            FLOAT,
            "fraction of the validation images whose best grasp agrees with a positive one",
        ),
    ]
)

SCORE = pa.schema(
    [
        column(
            "n_correct", INT, "number of test images whose best grasp agrees with a positive one"
        ),
        column("n_images", INT, "number of test images with a positive grasp"),
        column("objects", INT, "number of objects in these images"),
        column(
            "ci_low", FLOAT, "lower end of the 95 % confidence interval of the fraction that agrees"
        ),
        column("ci_high", FLOAT, "upper end of this interval"),
        column("loss", FLOAT, "mean loss over all test images"),
    ]
)

SCENE_HISTORY = pa.schema(
    [
        column("epoch", INT, "number of the epoch, from 0"),
        column("scenes", INT, "number of training examples so far"),
        column("loss", FLOAT, "mean loss over the epoch"),
        column("quality_loss", FLOAT, "share of the quality: weighted binary cross-entropy"),
        column("rotation_loss", FLOAT, "share of the rotation at positive grasps"),
        column("width_loss", FLOAT, "share of the width at positive grasps"),
        column("validation_loss", FLOAT, "loss on the validation set after the epoch"),
        column(
            "validation_average_precision",
            FLOAT,
            "average precision of the quality at the labelled grasps of the validation set",
        ),
    ]
)


def _estimate(name: str, meaning: str, unit: str = "") -> list[pa.Field]:
    """A column, and two for its interval."""
    return [
        column(name, FLOAT, meaning, unit),
        column(f"{name}_ci_low", FLOAT, "lower end of its 95 % confidence interval", unit),
        column(f"{name}_ci_high", FLOAT, "upper end of this interval", unit),
    ]


SCENE_SCORE = pa.schema(
    [
        column("n_scenes", INT, "number of test scenes"),
        column("n_grasps", INT, "number of labelled grasps in these scenes"),
        column("n_positive", INT, "number of these grasps that succeeded"),
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
        column("loss", FLOAT, "mean loss over all grasps"),
    ]
)
