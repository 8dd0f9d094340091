"""The card of a set of labelled scenes: counts, labels, splits and settings, as Markdown."""

from typing import NamedTuple

import pandas as pd

from egad._util.markdown import filled, table
from egad.learning.images import SPLITS, list_of_rejected, settings_table
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
    noise, missing = found.scenes["noise"].value_counts(), found.planned - len(found.scenes)
    left_out = (
        f"{missing} of {found.planned} planned scenes are left out: the simulation went wrong, or "
        "none of their objects can be simulated.\n\n"
    )
    return filled(
        __package__,
        "card.md",
        title=title,
        settings=settings,
        found=found,
        picture=PICTURE,
        counts=_counts(found),
        left_out=left_out if missing else "",
        depths=DEPTHS,
        outcomes=_outcomes(found.grasps),
        splits=_splits(settings, found.splits),
        table=settings_table(scenes=settings.scenes),
        noise=", ".join(f"{name} in {noise.get(name, 0)}" for name in settings.scenes.noise),
        rejected=list_of_rejected(found.rejected),
    )


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
        f"{100 * (1 - scenes.validation - scenes.test):g} % of the objects."
        if splits.families
        else how
    )


def _share(flags: "pd.Series[bool]") -> str:
    return f"{100 * flags.mean():.1f} %" if len(flags) else "-"


def _mean(numbers: "pd.Series[int]") -> str:
    return f"{numbers.mean():.1f}" if len(numbers) else "-"
