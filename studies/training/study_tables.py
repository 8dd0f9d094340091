"""The tables of the study: the attempts of all networks and of the detectors they meet."""

import pyarrow as pa

from egad.tables.clutter import CLUTTER
from egad.tables.columns import integer, text
from egad.tables.evaluation import RESULTS

_TESTED = [
    text("test", "dataset whose evaluation set was used"),
    text("training_set", "training set of the network; empty for other detectors"),
    integer("seed", "number of the training; 0 for detectors that were not trained"),
]

COMPARED = pa.schema([*_TESTED, text("noise", "of the depth images: none or stereo"), *RESULTS])

CLEARED = pa.schema(
    [
        *_TESTED,
        text("detector", "name of the grasp detector"),
        *(field for field in CLUTTER if field.name != "seed"),
    ]
)
