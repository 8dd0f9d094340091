"""The card of a set of images: counts, balance, splits, camera and noise, as Markdown."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.markdown import table
from egad.bench import SCENE_KINDS
from egad.detectors import ImageNoise
from egad.learning.images.arrangement import is_good
from egad.learning.images.parameters import Camera, Render, RenderParameters
from egad.learning.images.splits import SPLITS

COLUMNS = [
    *("split", "scene", "draws", "objects", "focal"),
    *("opening", "depth_center", "quality", "collision_free", "simulated_success"),
]
"""The columns that a summary is made from."""

COUNTS: dict[str, str] = {
    "objects": "objects",
    "images": "images",
    **{kind: f"of them {kind}" for kind in SCENE_KINDS},
    "without_free": "images without a free grasp",
    "without_good": "images without a good grasp",
    "grasps": "reachable grasps",
    "collision_free": "free grasps",
    "good": "good grasps",
}
NARROW = 0.05  # metres


class Summary(NamedTuple):
    """The contents of a set of images: `COUNTS` of each split and all, openings of grasps (m)."""

    counts: pd.DataFrame
    openings: NDArray[np.float64]
    images: int
    in_vain: float


def summary(rows: pd.DataFrame, quality: float) -> Summary:
    """Summarize images, by `COLUMNS` of their rows; good grasps exceed a robust quality."""
    free = [np.asarray(each, dtype=bool) for each in rows["collision_free"]]
    good = [
        is_good(flags, np.asarray(values), list(held), quality)
        for flags, values, held in zip(
            free, rows["quality"], rows["simulated_success"], strict=True
        )
    ]
    counted = rows[["split", "scene", "objects"]].assign(
        grasps=[len(each) for each in free],
        collision_free=[int(each.sum()) for each in free],
        good=[int(each.sum()) for each in good],
    )
    parts = {**{name: counted[counted["split"] == name] for name in SPLITS}, "all": counted}
    lengths = (rows["opening"] * rows["depth_center"] / rows["focal"]).tolist()
    openings = [np.asarray(each, float)[which] for each, which in zip(lengths, good, strict=True)]
    return Summary(
        pd.DataFrame({name: _counts(part) for name, part in parts.items()}).T,
        np.concatenate([np.empty(0), *openings]),
        len(rows),
        1 - len(rows) / max(int(rows["draws"].sum()), 1),
    )


def _counts(rows: pd.DataFrame) -> dict[str, int]:
    return {
        "objects": rows["objects"].explode().nunique(),
        "images": len(rows),
        **{kind: int((rows["scene"] == kind).sum()) for kind in SCENE_KINDS},
        "without_free": int((rows["collision_free"] == 0).sum()),
        "without_good": int((rows["good"] == 0).sum()),
        **{name: int(rows[name].sum()) for name in ("grasps", "collision_free", "good")},
    }


def card(
    settings: RenderParameters,
    dataset: str,
    gripper: str,
    found: Summary,
    rejected: pd.DataFrame,
    figure: str,
) -> str:
    """The card of a set; `rejected` has the columns of `REJECTED`, `figure` is a file name."""
    render = settings.render
    blocks = [
        f"# Depth images of {dataset} for {gripper}",
        f"Objects at rest on a table, turned at random; seed {settings.seed}. A single "
        "object lies in one of its stable poses, each as often as drops end in it"
        + (
            "; several are packed upright side by side or dropped into a pile, "
            f"at most {render.objects}"
            if render.packed + render.pile
            else ""
        )
        + ". Splits are by object"
        + (", and the evaluation set is reserved for testing." if render.hold_out else "."),
        _table(found.counts),
        f"A grasp is reachable if its approach can be within {render.tilt:g} degrees of the "
        f"vertical; at most {render.grasps} are sampled per object. It is free if the hand, which "
        f"opens at most {1000 * settings.gripper.opening:g} mm, touches nothing else, and good "
        "if it also "
        + (
            "held in simulation."
            if render.simulate
            else f"has a robust quality above {render.quality:g}."
        ),
        _sizes(render, found, figure),
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
    rows = [
        (title, *(str(counts.at[name, column]) for name in names))
        for column, title in COUNTS.items()
    ]
    pairs = zip(counts.loc[names, "collision_free"], counts.loc[names, "grasps"], strict=True)
    shares = [f"{100 * free / max(grasps, 1):.0f} %" for free, grasps in pairs]
    return table(["", *names], [*rows, ("free fraction of the reachable grasps", *shares)]).rstrip()


def _sizes(render: Render, found: Summary, figure: str) -> str:
    low, high = (1000 * width for width in render.widths or (0, 0))
    sizes = (
        f"Sizes are drawn such that the width of one grasp of an object is uniform from {low:g} to "
        f"{high:g} mm."
        if render.widths
        else "Objects have the size that fits the gripper."
    )
    narrow = f"{100 * np.mean(found.openings < NARROW):.0f} %" if len(found.openings) else "None"
    kept = (
        "Images without a good grasp are kept."
        if render.without_grasps
        else f"Poses and sizes without a good grasp are drawn again, at most 10 times: "
        f"{100 * found.in_vain:.0f} % of the draws for these images showed none, and "
        f"{render.images - found.images} of {render.images} images were left out after ten."
    )
    return (
        f"{sizes} {kept} {narrow} of the good grasps have an opening below {1000 * NARROW:g} mm."
        f"\n\n![Openings of the good grasps]({figure})"
    )


def _objects(render: Render) -> str:
    low, high = (100 * rank for rank in render.complexity)
    if (low, high, render.subset) == (0, 100, 1):
        return ""
    drawn = f"a random {100 * render.subset:g} % of the objects" * (render.subset < 1)
    ranks = f"whose rank in complexity is from {low:g} to {high:g} %"
    return f"Only {drawn or 'objects'} {ranks}."


def _camera(camera: Camera) -> list[str]:
    width, height = camera.image
    around = ", cropped around the first object's center of mass" if camera.centered else ""
    return [
        f"{width} x {height} pixels{around}; focal length {_range(camera.focal)} pixels; "
        f"{_range(camera.distance)} m from the middle of the table, {_range(camera.tilt)} degrees "
        f"off the vertical, rolled by {_range(camera.roll)} degrees; the objects are up to "
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
