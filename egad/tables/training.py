"""The tables of a training, and of the experiment on training sets."""

import pyarrow as pa

from egad.tables.columns import BOOL, FLOAT, INT, STRING, column
from egad.tables.evaluation import RESULTS

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
        column("taken", BOOL, "whether the weights are those after this epoch"),
    ]
)

SCORE = pa.schema(
    [
        column("right", INT, "test images whose best grasp agrees with a positive one"),
        column("count", INT, "test images with a positive grasp"),
        column("objects", INT, "objects in these"),
        column("low", FLOAT, "lower end of the interval of right / count, 95 %"),
        column("high", FLOAT, "upper end"),
        column("loss", FLOAT, "mean over all test images"),
    ]
)

COMPARED = pa.schema(
    [
        column("test", STRING, "dataset whose evaluation set was tried"),
        column("training_set", STRING, "what the network learnt from; empty for other detectors"),
        column("seed", INT, "number of the training; 0 where nothing was trained"),
        *RESULTS,
    ]
)
