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
