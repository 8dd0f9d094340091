"""The card of a set of labelled scenes: counts, labels, splits, cameras and noise, as Markdown."""

from typing import NamedTuple

import pandas as pd

from egad._util.markdown import table
from egad.learning.images import SPLITS
from egad.learning.scenes.parameters import DEPTHS, SceneParameters
from egad.learning.scenes.planning import Splits
from egad.tables.outcomes import Outcome

SCENE_COLUMNS = ["scene", "kind", "split", "objects", "noise"]
GRASP_COLUMNS = ["scene", "success", "outcome"]
KINDS = ("packed", "pile")
PICTURE = "scene.png"


class SceneSet(NamedTuple):
    """The contents of a set of scenes (`SCENE_COLUMNS`, `GRASP_COLUMNS`, `REJECTED`)."""

    scenes: pd.DataFrame
    grasps: pd.DataFrame
    planned: int
    splits: Splits
    rejected: pd.DataFrame


def card(settings: SceneParameters, title: str, found: SceneSet) -> str:
    """The card of a set of scenes."""
    scenes = settings.scenes
    missing = found.planned - len(found.scenes)
    blocks = [
        f"# {title}",
        "Objects packed upright side by side or dropped into a pile, at rest on a table, in sizes "
        f"{_range(scenes.protocol.scale)} times those that fit the gripper, packed ones "
        f"{_range(scenes.protocol.packed_scale or scenes.protocol.scale)}; seed {settings.seed}, "
        f"engine {scenes.engine}, protocol {scenes.protocol}.",
        f"![One of the scenes: green grasps held, red did not]({PICTURE})",
        _counts(found),
        f"{missing} of {found.planned} planned scenes are left out: the simulation went wrong, or "
        "none of their objects can be simulated."
        if missing
        else "",
        "## Labels",
        f"Each scene has {scenes.grasps} grasps, at random points of the surface that the cameras "
        "see, if they see any. The fully open hand approaches against the normal, until its "
        f"fingertips are {_range(DEPTHS)} of the finger length below the surface. "
        f"{scenes.yaws} turns about the approach are simulated, evenly over half a turn. A grasp "
        "succeeds if one of them holds an object after the retreat; the middle of the widest run "
        "of successes is kept, or else the first turn. A contact during the approach of more than "
        f"{scenes.protocol.stopping_force:g} N is a failure.",
        _outcomes(found.grasps),
        "## Splits",
        _splits(settings, found.splits),
        "## Cameras and noise",
        _cameras(settings, found.scenes),
        "## Objects in no scene",
        "\n".join(
            f"- `{name}`: {reason}"
            for name, reason in zip(found.rejected["id"], found.rejected["reason"], strict=True)
        )
        or "None was rejected.",
    ]
    return "\n\n".join(block.rstrip() for block in blocks if block) + "\n"


def _counts(found: SceneSet) -> str:
    """A table with a column for each split and one for all."""
    names = [*SPLITS, "all"]
    scenes = found.scenes.set_index("scene")
    grasps = found.grasps.join(scenes[["kind", "split"]], on="scene")
    held = grasps.groupby("scene")["success"].sum().reindex(scenes.index, fill_value=0)
    columns = []
    for name in names:
        mine = scenes if name == "all" else scenes[scenes["split"] == name]
        tried = grasps if name == "all" else grasps[grasps["split"] == name]
        kinds = [tried[tried["kind"] == kind] for kind in KINDS]
        columns.append(
            [
                int(mine["objects"].explode().nunique()),
                len(mine),
                *(int((mine["kind"] == kind).sum()) for kind in KINDS),
                _mean(mine["objects"].map(len)),
                int((held[mine.index] == 0).sum()),
                len(tried),
                _share(tried["success"]),
                *(_share(each["success"]) for each in kinds),
            ]
        )
    titles = [
        "objects",
        "scenes",
        *(f"of them {kind}" for kind in KINDS),
        "objects per scene",
        "scenes without a positive grasp",
        "grasps",
        "positive",
        *(f"positive, {kind}" for kind in KINDS),
    ]
    return table(
        ["", *names], [(title, *row) for title, *row in zip(titles, *columns, strict=True)]
    )


def _outcomes(grasps: pd.DataFrame) -> str:
    counts = grasps["outcome"].value_counts()
    rows = [
        (outcome.value, int(counts[outcome.value]), f"{100 * counts[outcome] / len(grasps):.1f} %")
        for outcome in Outcome
        if outcome.value in counts
    ]
    return table(["outcome of the kept turn", "grasps", ""], rows)


def _splits(settings: SceneParameters, splits: Splits) -> str:
    scenes = settings.scenes
    how = (
        f"By family: the {len(splits.split_of)} objects have {splits.families} founders at the end "
        "of their lines of first parents, and no family is in two splits."
        if splits.families
        else f"By object, each of {len(splits.split_of)} in one split; their ancestors are not "
        "known."
    )
    if splits.held_out:
        what = "the evaluation set with its" if scenes.hold_out else "those held out, with their"
        how += f" {splits.held_out} objects are in no scene: {what} parents and children."
    return (
        f"{how} The largest families are for training, until it has "
        f"{_percent(1 - scenes.validation - scenes.test)} of the objects."
        if splits.families
        else how
    )


def _cameras(settings: SceneParameters, scenes: pd.DataFrame) -> str:
    cameras = settings.scenes.cameras
    width, height = cameras.image
    counts = scenes["noise"].value_counts()
    noise = ", ".join(f"{name} in {counts.get(name, 0)}" for name in settings.scenes.noise)
    return (
        f"{cameras.views} views of {width} x {height} pixels, focal length {cameras.focal:.4g} "
        f"pixels; each {_range(cameras.distance)} m from a point {_height(cameras.aim)} the "
        f"middle of the table, {_range(cameras.tilt)} degrees off the vertical. Depth is in steps "
        f"of 0.1 mm. Noise, by scenes: {noise}."
    )


def _range(values: tuple[float, float]) -> str:
    low, high = values
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _height(metres: float) -> str:
    """A height relative to the table, with its preposition."""
    return f"{100 * abs(metres):g} cm {'below' if metres < 0 else 'above'}" if metres else "on"


def _percent(share: float) -> str:
    return f"{100 * share:g} %"


def _share(flags: "pd.Series[bool]") -> str:
    return f"{100 * flags.mean():.1f} %" if len(flags) else "-"


def _mean(numbers: "pd.Series[int]") -> str:
    return f"{numbers.mean():.1f}" if len(numbers) else "-"
