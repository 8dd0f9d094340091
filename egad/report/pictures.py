"""Small shaded pictures of meshes and of voxels, without a window or a graphics card."""

import io
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from egad._util.arrays import RgbImage, Singles
from egad._util.parameters import check_count
from egad.geometry import TriangleScene, check_mesh

SUBSAMPLES = 2
SKY_RAYS = 8
BLUR = 80
FILL = 0.95
CREASE = float(np.cos(np.radians(40)))
OVERLAP = 1.8  # side of the square that a voxel covers, in voxels: wide enough to leave no gaps
MARGIN = 2  # empty voxels around a solid
AMBIENT = 0.25
HIDDEN = -0.3  # voxels whose normals point further away from the viewer are not painted
DARK = np.array([30, 34, 44], dtype=np.float32)
LIGHT = np.array([253, 251, 246], dtype=np.float32)


def _unit(vectors: NDArray[np.floating]) -> Singles:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    scaled: Singles = (vectors / np.maximum(lengths, 1e-12)).astype(np.float32)
    return scaled


def _camera(towards_viewer: tuple[float, float, float]) -> Singles:
    """Rows: right, up and towards the viewer."""
    back = _unit(np.array(towards_viewer, dtype=np.float32))
    right = _unit(np.cross(np.array([0, 0, 1], dtype=np.float32), back))
    return np.stack([right, np.cross(back, right), back])


CAMERA = _camera((0.55, -0.72, 0.5))
KEY_LIGHT = _unit(np.array([-0.55, 0.62, 0.56], dtype=np.float32))


class _Hits(NamedTuple):
    """What the rays hit, in camera coordinates."""

    rays: NDArray[np.int64]
    points: Singles
    normals: Singles


def render(mesh: trimesh.Trimesh, size: int = 96) -> RgbImage:
    """Draw a mesh on a transparent background, seen from the front and above.

    Rays are orthographic, two by two per pixel. A key light from the upper left, an open sky
    (ambient occlusion) and darkened silhouettes make the shape readable on any background. Faces
    may be wound either way.

    Args:
        mesh: The object, in any unit; it is scaled to fill the picture.
        size: Pixels along each side.

    Returns:
        Red, green, blue and alpha (not premultiplied), (size, size, 4).

    Raises:
        RejectedError: The mesh has no faces, or coordinates that are not finite.
        UserError: The argument is not a mesh, or there are no pixels.
    """
    check_mesh(mesh)
    check_count("size", size)
    vertices = _to_view(np.asarray(mesh.vertices, dtype=np.float64))
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int32)
    scene = TriangleScene(vertices, faces)
    side = size * SUBSAMPLES
    hits = _cast(scene, vertices, faces, side)
    return _average(hits.rays, _shade(scene, hits, side), size)


def png_bytes(picture: RgbImage) -> bytes:
    """A small PNG of a picture, (height, width, 4), with a palette of up to 256 colors."""
    step = np.array([8, 8, 8, 51], dtype=np.float64)
    coarse = np.minimum(np.round(picture / step) * step, 255).astype(np.uint8)
    coarse[coarse[..., 3] == 0] = 0
    codes = np.ascontiguousarray(coarse).view("<u4").ravel()
    found, index = np.unique(codes, return_inverse=True)
    colors = found.view(np.uint8).reshape(-1, 4)
    if len(colors) > 256:
        return _encode(Image.fromarray(coarse), optimize=True)
    image = Image.fromarray(index.reshape(picture.shape[:2]).astype(np.uint8), mode="P")
    image.putpalette(colors[:, :3].tobytes())
    return _encode(image, optimize=True, transparency=colors[:, 3].tobytes())


def voxel_png(picture: RgbImage) -> bytes:
    """A PNG file of grey and alpha, as returned by `voxel_picture`."""
    return _encode(Image.fromarray(picture, "LA"))


def _encode(image: Image.Image, **options: Any) -> bytes:  # noqa: ANN401 (as Pillow)
    buffer = io.BytesIO()
    image.save(buffer, "png", **options)
    return buffer.getvalue()


def _to_view(vertices: NDArray[np.float64]) -> Singles:
    """Camera coordinates, centered, with the larger of width and height from -FILL to FILL."""
    seen = vertices @ CAMERA.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    reach = max((high - low)[:2].max() / 2, np.finfo(np.float64).tiny)
    centered: Singles = ((seen - (low + high) / 2) * (FILL / reach)).astype(np.float32)
    return centered


def _cast(scene: TriangleScene, vertices: Singles, faces: NDArray[np.int32], side: int) -> _Hits:
    """First hit of every ray of a grid of `side` x `side`, top row first."""
    centers = ((np.arange(side, dtype=np.float32) + 0.5) / side) * 2 - 1
    x, y = np.meshgrid(centers, -centers)
    front = vertices[:, 2].max() + 1
    origins = np.stack([x.ravel(), y.ravel(), np.full(side * side, front)], axis=1)
    towards = np.tile(np.array([0, 0, -1], dtype=np.float32), (side * side, 1))
    found = scene.intersections(origins, towards)
    rays = np.flatnonzero(found.faces >= 0)
    corners = _corner_normals(vertices, faces)[found.faces[rays]]
    u, v = found.coordinates[rays].T
    weights = np.stack([1 - u - v, u, v], axis=1)
    smooth = _unit(np.einsum("ij,ijk->ik", weights, corners))
    flat = _unit(found.normals[rays])
    flat *= np.where(flat[:, 2:] < 0, np.float32(-1), np.float32(1))
    smooth *= np.sign(np.einsum("ij,ij->i", smooth, flat))[:, None]
    points = origins[rays]
    points[:, 2] -= found.distances[rays]
    return _Hits(rays, points + flat * np.float32(2e-3), smooth)


def _corner_normals(vertices: Singles, faces: NDArray[np.int32]) -> Singles:
    """Normals at the corners of faces, (n, 3, 3): smooth by angles, but flat at creases."""
    edges = vertices[np.roll(faces, -1, axis=1)] - vertices[faces]
    flat = _unit(np.cross(edges[:, 0], edges[:, 1]))
    along = _unit(edges)
    cosines = np.einsum("ijk,ijk->ij", along, -np.roll(along, 1, axis=1))
    weighted = flat[:, None] * np.arccos(np.clip(cosines, -1, 1))[..., None]
    at = faces.ravel()
    sums = [np.bincount(at, weighted[..., axis].ravel(), len(vertices)) for axis in range(3)]
    smooth = _unit(np.stack(sums, axis=1))[faces]
    creased = np.einsum("ijk,ik->ij", smooth, flat) < CREASE
    return np.where(creased[..., None], flat[:, None], smooth).astype(np.float32)


def _shade(scene: TriangleScene, hits: _Hits, side: int) -> Singles:
    """Brightness of each hit, 0 to 1."""
    openness = _blur_within(_sky_visibility(scene, hits, side), hits.rays, side)
    lambert = np.clip(hits.normals @ KEY_LIGHT, 0, 1)
    sky = 0.5 + 0.5 * hits.normals @ CAMERA[:, 2]
    bright = openness * (0.20 + 0.22 * sky) + 0.66 * lambert * (0.4 + 0.6 * openness)
    silhouette = np.clip(hits.normals[:, 2] / 0.45, 0, 1)
    toned: Singles = np.clip(bright * (0.45 + 0.55 * silhouette), 0, 1) ** np.float32(0.9)
    return toned


def _sky_visibility(scene: TriangleScene, hits: _Hits, side: int) -> Singles:
    """Cosine-weighted fraction of the sky that each hit sees, with one set of directions."""
    row, column = np.divmod(hits.rays, side)
    subsample = (row % SUBSAMPLES) * SUBSAMPLES + column % SUBSAMPLES
    seen = weight = np.zeros(len(hits.rays), dtype=np.float32)
    for directions in _sky().reshape(-1, SUBSAMPLES**2, 3):
        ray = directions[subsample]
        cosine = np.einsum("ij,ij->i", ray, hits.normals)
        ray = ray - np.minimum(2 * cosine, 0)[:, None] * hits.normals
        blocked = scene.occluded(hits.points, ray)
        cosine = np.abs(cosine)
        seen, weight = seen + cosine * ~blocked, weight + cosine
    return (seen / np.maximum(weight, 1e-6)).astype(np.float32)


def _blur_within(values: Singles, rays: NDArray[np.int64], side: int) -> Singles:
    """Blur values within the silhouette: few rays leave edges where one of them is blocked."""
    weighted = np.zeros((2, side * side), dtype=np.float32)
    weighted[0, rays], weighted[1, rays] = values, 1
    planes = weighted.reshape(2, side, side)
    blurred, weight = (ndimage.gaussian_filter(plane, side / BLUR) for plane in planes)
    return (blurred / np.maximum(weight, 1e-6)).ravel()[rays].astype(np.float32)


def _sky() -> Singles:
    """Directions spread evenly over the half of the sphere that faces the viewer."""
    place = np.arange(SKY_RAYS) + 0.5
    height = 1 - place / SKY_RAYS
    radius, turn = np.sqrt(1 - height**2), place * np.pi * (3 - np.sqrt(5))
    around = [radius * np.cos(turn), radius * np.sin(turn), height]
    return np.stack(around, axis=1).astype(np.float32)


def _average(rays: NDArray[np.int64], bright: Singles, size: int) -> RgbImage:
    """Colors of the subsamples, averaged over each pixel."""
    side = size * SUBSAMPLES
    samples = np.zeros((side * side, 4), dtype=np.float32)
    samples[rays, :3] = DARK + (LIGHT - DARK) * bright[:, None]
    samples[rays, 3] = 1
    total = samples.reshape(size, SUBSAMPLES, size, SUBSAMPLES, 4).sum(axis=(1, 3))
    covered = total[..., 3:]
    color = total[..., :3] / np.maximum(covered, 1)
    alpha = covered * (255 / SUBSAMPLES**2)
    return np.round(np.concatenate([color, alpha], axis=2)).astype(np.uint8)


def voxel_picture(voxels: NDArray[np.bool_], size: int) -> RgbImage:
    """Grey and alpha, (size, size, 2), of voxels, (r, r, r), in view and light of `render`."""
    solid = np.pad(voxels, MARGIN)
    surface = np.argwhere(solid & ~_interior(solid))
    seen = (surface - surface.mean(axis=0)) @ CAMERA.T.astype(np.float64)
    low, high = seen[:, :2].min(axis=0) - OVERLAP / 2, seen[:, :2].max(axis=0) + OVERLAP / 2
    side = SUBSAMPLES * size
    scale = FILL * side / (high - low).max()
    normals = _normals(solid, surface)
    order = np.argsort(seen[:, 2])
    order = order[normals[order, 2] > HIDDEN]
    corners = (seen[order, :2] - (low + high) / 2 - OVERLAP / 2) * scale + side / 2
    steps = np.arange(int(np.ceil(OVERLAP * scale)))
    across, upwards = (np.clip(np.rint(corners[:, i, None]) + steps, 0, side - 1) for i in (0, 1))
    pixels = (side - 1 - upwards[:, :, None]) * side + across[:, None, :]
    canvas = np.zeros(side * side, np.float32)
    lit = np.clip(normals[order] @ KEY_LIGHT, 0, 1)
    paint = AMBIENT + (1 - AMBIENT) * lit
    canvas[pixels.astype(np.intp).ravel()] = np.repeat(paint, len(steps) ** 2)
    return _average_voxels(canvas.reshape(side, side), size)


def _interior(solid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Voxels whose six neighbors are solid; the margin is empty."""
    inside = np.ones_like(solid)
    for axis in range(3):
        inside &= np.roll(solid, 1, axis) & np.roll(solid, -1, axis)
    return inside


def _normals(solid: NDArray[np.bool_], surface: NDArray[np.int64]) -> NDArray[np.float32]:
    """Outward normals at voxels of the surface in camera coordinates, (n, 3)."""
    density = solid.astype(np.float32)
    for axis in range(3):
        density = 2 * density + np.roll(density, 1, axis) + np.roll(density, -1, axis)
    at = np.ravel_multi_index(tuple(surface.T), solid.shape)
    flat, strides = density.ravel(), np.cumprod([1, *solid.shape[:0:-1]])[::-1]
    normals = np.stack([flat[at - step] - flat[at + step] for step in strides], axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-6)
    return np.asarray(normals @ CAMERA.T)


def _average_voxels(canvas: NDArray[np.float32], size: int) -> RgbImage:
    """One pixel for each block of subsamples; only painted ones count for its grey value."""
    split = canvas.reshape(size, SUBSAMPLES, size, SUBSAMPLES).swapaxes(1, 2)
    blocks = split.reshape(size, size, SUBSAMPLES**2)
    painted = np.count_nonzero(blocks, axis=2)
    grey = blocks.sum(axis=2) / np.maximum(painted, 1)
    alpha = painted / SUBSAMPLES**2
    pixels: RgbImage = np.rint(255 * np.stack([grey, alpha], axis=2)).astype(np.uint8)
    return pixels
