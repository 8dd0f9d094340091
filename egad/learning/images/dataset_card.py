"""The card of a set of images: counts, balance and settings, as Markdown."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.markdown import filled, table
from egad._util.parameters import Parameters
from egad.bench import SCENE_KINDS
from egad.learning.images.arrangement import is_good
from egad.learning.images.parameters import RenderParameters
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
    again = (
        f"{100 * found.in_vain:.0f} % of the draws for these images showed none, and "
        f"{render.images - found.images} of {render.images} images were left out after ten draws. "
    )
    return filled(
        __package__,
        "dataset_card.md",
        dataset=dataset,
        gripper=gripper,
        settings=settings,
        counts=_table(found.counts),
        opening=1000 * settings.gripper.opening,
        good="held in simulation"
        if render.simulate
        else "has a robust quality above render.quality",
        again="" if render.without_grasps else again,
        narrow=100 * (found.openings < NARROW).mean() if len(found.openings) else 0.0,
        limit=1000 * NARROW,
        figure=figure,
        table=settings_table(
            render=render, camera=settings.camera, image_noise=settings.image_noise
        ),
        rejected=list_of_rejected(rejected),
    )


def settings_table(**groups: Parameters) -> str:
    """Settings by the name of their section, as a table in Markdown: name, value, meaning."""
    rows = [
        (f"`{group}.{name}`", str(getattr(values, name)), field.description)
        for group, values in groups.items()
        for name, field in type(values).model_fields.items()
    ]
    return table(["setting", "value", "meaning"], rows)


def list_of_rejected(rejected: pd.DataFrame) -> str:
    """The rows of a table with the columns of `REJECTED` as a list in Markdown."""
    rows = zip(rejected["id"], rejected["reason"], strict=True)
    return "\n".join(f"- `{name}`: {reason}" for name, reason in rows) or "None."


def _table(counts: pd.DataFrame) -> str:
    names = [*SPLITS, "all"]
    rows = [
        (title, *(str(counts.at[name, column]) for name in names))
        for column, title in COUNTS.items()
    ]
    pairs = zip(counts.loc[names, "collision_free"], counts.loc[names, "grasps"], strict=True)
    shares = [f"{100 * free / max(grasps, 1):.0f} %" for free, grasps in pairs]
    return table(["", *names], [*rows, ("free fraction of the reachable grasps", *shares)])
