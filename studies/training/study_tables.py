"""The tables of the study: the attempts of all networks and of the detectors they meet."""

import pyarrow as pa

from egad.tables.clutter import CLUTTER
from egad.tables.columns import INT, STRING, column
from egad.tables.evaluation import RESULTS

_TESTED = [
    column("test", STRING, "dataset whose evaluation set was used"),
    column("training_set", STRING, "training set of the network; empty for other detectors"),
    column("seed", INT, "number of the training; 0 for detectors that were not trained"),
]

COMPARED = pa.schema(
    [*_TESTED, column("noise", STRING, "of the depth images: none or stereo"), *RESULTS]
)

CLEARED = pa.schema(
    [
        *_TESTED,
        column("detector", STRING, "name of the grasp detector"),
        *(field for field in CLUTTER if field.name != "seed"),
    ]
)
