"""The table of a training."""

import pyarrow as pa

from egad.tables.columns import FLOAT, INT, column

HISTORY = pa.schema(
    [
        column("epoch", INT, "number of the epoch, from 0"),
        column("images", INT, "images learnt from so far"),
        column("loss", FLOAT, "mean over the epoch of the summed squared errors of the maps"),
        column("quality_loss", FLOAT, "part of it by the map of quality"),
        column("cosine_loss", FLOAT, "part of it by the map of cos 2a"),
        column("sine_loss", FLOAT, "part of it by the map of sin 2a"),
        column("width_loss", FLOAT, "part of it by the map of width"),
        column("validation_loss", FLOAT, "the loss on the validation set after the epoch"),
        column(
            "validation_score",
            FLOAT,
            "part of the validation images whose best grasp agrees with a positive one",
        ),
    ]
)
