"""Symmetry by folding space: points that are images of each other become one point (ours)."""

import numpy as np
from numpy.typing import NDArray

from egad.settings import Symmetry

Points = NDArray[np.float32]
Voxels = NDArray[np.bool_]
AXES = "xyz"


def folded(points: Points, symmetry: Symmetry) -> Points:
    """Where a network is asked in the place of each point.

    A mirror takes the absolute value of a coordinate. A turn multiplies the angle about its axis
    by the fold: points a fold of a turn apart meet, neighbours stay neighbours, and shapes may
    still be twisted. With a mirror along the axis, all mirrors that the turn makes of it are
    obeyed.

    Args:
        points: (3, n) coordinates within [-1, 1].
        symmetry: Mirrors and turn.

    Returns:
        (3, n) float32. Points that are mirror images become equal to the last bit.
    """
    found = points.astype(np.float64).round(6)  # so that -a and a are the same number apart
    for axis in symmetry.mirror:
        found[AXES.index(axis)] = np.abs(found[AXES.index(axis)])
    if symmetry.fold > 1:
        first, second = across(symmetry.axis)
        radius = np.hypot(found[first], found[second])
        angle = symmetry.fold * np.arctan2(found[second], found[first])
        found[first], found[second] = radius * np.cos(angle), radius * np.sin(angle)
        for place in (first, second):
            if AXES[place] in symmetry.mirror:
                kept = first if place == first and symmetry.fold % 2 else second
                found[kept] = np.abs(found[kept])
    return found.astype(np.float32)


def across(axis: str) -> tuple[int, int]:
    """The two coordinates across an axis, in the order of a turn about it."""
    place = AXES.index(axis)
    return (place + 1) % 3, (place + 2) % 3


def is_whole(voxels: Voxels, symmetry: Symmetry) -> bool:
    """Whether a body is its own image, and not one of several that are images of each other.

    Of symmetric bodies it is enough that each image covers half of the body: voxels that a turn
    does not carry onto voxels may differ.
    """
    images = [np.flip(voxels, AXES.index(axis)) for axis in symmetry.mirror]
    if symmetry.fold > 1:
        images.append(turned(voxels, symmetry))
    return all(2 * np.count_nonzero(voxels & image) >= voxels.sum() for image in images)


def turned(voxels: Voxels, symmetry: Symmetry) -> Voxels:
    """A body turned about the middle by one fold, by the nearest voxels; all that stay inside."""
    middle = (np.array(voxels.shape) - 1) / 2
    places = np.indices(voxels.shape).reshape(3, -1) - middle[:, None]
    first, second = across(symmetry.axis)
    cosine, sine = np.cos(2 * np.pi / symmetry.fold), np.sin(2 * np.pi / symmetry.fold)
    from_ = places.copy()
    from_[first] = cosine * places[first] + sine * places[second]
    from_[second] = cosine * places[second] - sine * places[first]
    index = np.rint(from_ + middle[:, None]).astype(np.int64)
    inside = np.all((index >= 0) & (index < np.array(voxels.shape)[:, None]), axis=0)
    image = np.zeros(voxels.size, dtype=bool)
    image[inside] = voxels[tuple(index[:, inside])]
    return image.reshape(voxels.shape)
