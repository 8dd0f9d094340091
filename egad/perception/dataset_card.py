"""The card of a set of images: counts, balance, splits, camera and noise, as Markdown."""

import numpy as np
import pandas as pd

from egad.perception.parameters import Camera, ImageNoise, Render, RenderParameters
from egad.perception.splits import SPLITS

COUNTS = {
    "objects": "objects",
    "images": "images",
    "poses": "stable poses",
    "without_reachable": "images without a reachable grasp",
    "without_free": "images without a free grasp",
    "grasps": "reachable grasps",
    "collision_free": "free grasps",
}


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """What each split and the whole have of `COUNTS`: a row each, also of splits without images.

    Args:
        rows: Columns `id`, `split`, `pose` and `collision_free` of `tables.images.IMAGES`.
    """
    flags = [np.asarray(each, dtype=bool) for each in rows["collision_free"]]
    counted = rows[["id", "split", "pose"]].assign(
        grasps=[len(each) for each in flags], collision_free=[int(each.sum()) for each in flags]
    )
    parts = {name: counted[counted["split"] == name] for name in SPLITS}
    return pd.DataFrame({name: _counts(part) for name, part in {**parts, "all": counted}.items()}).T


def _counts(rows: pd.DataFrame) -> dict[str, int]:
    return {
        "objects": rows["id"].nunique(),
        "images": len(rows),
        "poses": len(rows.drop_duplicates(["id", "pose"])),
        "without_reachable": int((rows["grasps"] == 0).sum()),
        "without_free": int((rows["collision_free"] == 0).sum()),
        "grasps": int(rows["grasps"].sum()),
        "collision_free": int(rows["collision_free"].sum()),
    }


def card(
    settings: RenderParameters,
    dataset: str,
    gripper: str,
    counts: pd.DataFrame,
    rejected: pd.DataFrame,
) -> str:
    """The card.

    Args:
        settings: What the images were rendered with.
        dataset: Name of the dataset.
        gripper: Name of the gripper.
        counts: As `summary` gives them.
        rejected: Columns of `tables.objects.REJECTED`.
    """
    render = settings.render
    blocks = [
        f"# Depth images of {dataset} for {gripper}",
        f"Each object at rest on a table, in its stable poses as often as it comes to rest in "
        f"them, turned by chance; seed {settings.seed}. Splits are by object"
        + (", and the evaluation set is for testing." if render.hold_out else "."),
        _table(counts),
        f"A grasp is reachable if its approach can be within {render.tilt:g} degrees of the "
        f"vertical, and free if the hand, opening {1000 * settings.gripper.opening:g} mm at most, "
        "touches neither object nor table. Images without a free grasp are kept: there is nothing "
        "to grasp in them.",
        _objects(render),
        "## Camera",
        *_camera(settings.camera),
        "## Noise",
        _noise(settings.image_noise),
        "## Objects without images",
        _rejected(rejected),
    ]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _table(counts: pd.DataFrame) -> str:
    names = [*SPLITS, "all"]
    lines = [f"| | {' | '.join(names)} |", "| --- |" + " --- |" * len(names)]
    for column, title in COUNTS.items():
        lines.append(f"| {title} | {' | '.join(str(counts.at[name, column]) for name in names)} |")
    pairs = zip(counts.loc[names, "collision_free"], counts.loc[names, "grasps"], strict=True)
    shares = " | ".join(f"{100 * free / max(grasps, 1):.0f} %" for free, grasps in pairs)
    return "\n".join([*lines, f"| free, of the reachable | {shares} |"])


def _objects(render: Render) -> str:
    low, high = (100 * rank for rank in render.complexity)
    if (low, high, render.subset) == (0, 100, 1):
        return ""
    drawn = f"{100 * render.subset:g} %, drawn by chance, of the objects" * (render.subset < 1)
    ranks = f"from {low:g} to {high:g} % of the ranks in complexity"
    return f"Only {drawn or 'objects'} {ranks}."


def _camera(camera: Camera) -> list[str]:
    width, height = camera.image
    around = ", cut out around the object's center of mass" if camera.centered else ""
    return [
        f"{width} x {height} pixels{around}; focal length {_range(camera.focal)} pixels; "
        f"{_range(camera.distance)} m from the middle of the table, {_range(camera.tilt)} degrees "
        f"off the vertical, rolled by {_range(camera.roll)} degrees; the object lies up to "
        f"{camera.shift:g} m off the middle along x and y. Depth is in steps of 0.1 mm."
    ]


def _range(values: tuple[float, float]) -> str:
    low, high = values
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _noise(noise: ImageNoise) -> str:
    kinds = [
        f"disparity {noise.disparity:g} pixels" * (noise.disparity > 0),
        "holes beside edges and on steep surfaces" * noise.holes,
        f"{100 * noise.missing:g} % of the pixels lost in spots" * (noise.missing > 0),
    ]
    return ", ".join(filter(None, kinds)).capitalize() + "." if any(kinds) else "None."


def _rejected(rejected: pd.DataFrame) -> str:
    if len(rejected) == 0:
        return "None."
    rows = zip(rejected["id"], rejected["reason"], strict=True)
    return "\n".join(f"- `{name}`: {reason}" for name, reason in rows)
