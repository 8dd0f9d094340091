"""Random frames of hands."""

import numpy as np


def hand_frames():
    """Centers, axes and approaches at right angles to them; some axes are vertical."""
    rng = np.random.default_rng(4)
    axes = rng.normal(size=(50, 3))
    axes[:2] = [[0, 0, 1], [0, 0, -1]]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    approaches = np.cross(axes, rng.normal(size=(50, 3)))
    approaches /= np.linalg.norm(approaches, axis=1, keepdims=True)
    return rng.normal(size=(50, 3)), axes, approaches
