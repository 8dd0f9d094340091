"""Solids as voxels: filled, opened, one body, packed, named."""

import hashlib

import numpy as np
from scipy import ndimage

from egad._util.arrays import Flags
from egad.errors import UserError

Solid = Flags


def fill_orthographic(voxels: Solid) -> Solid:
    """Fill voxels that are hidden along all three axes from both sides."""
    hidden = np.ones_like(voxels)
    for axis in range(voxels.ndim):
        before = np.logical_or.accumulate(voxels, axis=axis)
        behind = np.flip(np.logical_or.accumulate(np.flip(voxels, axis), axis=axis), axis)
        hidden &= before & behind
    return voxels | hidden


def largest_body(voxels: Solid) -> Solid:
    """Keep the body with the most voxels (joined by faces; the first one on ties)."""
    labels, count = ndimage.label(voxels)
    if count == 0:
        return np.zeros_like(voxels)
    sizes = np.bincount(labels.ravel())
    return np.asarray(labels == 1 + int(np.argmax(sizes[1:])))


def pack(voxels: Solid) -> bytes:
    """One bit per voxel, C order."""
    return np.packbits(voxels.ravel()).tobytes()


def unpack(data: bytes, resolution: int) -> Solid:
    """The inverse of `pack`; `UserError` if the size does not match the resolution."""
    count = resolution**3
    bits = np.frombuffer(data, dtype=np.uint8)
    if len(bits) != (count + 7) // 8:
        raise UserError(
            f"{len(bits)} bytes of voxels do not fit {resolution}^3 voxels: "
            "they come from another shape.resolution"
        )
    return np.unpackbits(bits, count=count).astype(bool).reshape((resolution,) * 3)


def identity(voxels: Solid) -> str:
    """The id of a solid: equal for equal voxels, different for all others."""
    return hashlib.sha256(pack(voxels) + bytes(voxels.shape)).hexdigest()[:12]
