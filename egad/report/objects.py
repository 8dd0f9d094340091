"""The section Objects: a user's own meshes one by one, with what came of each."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd

from egad.bench.stats import by_object
from egad.grippers import Gripper
from egad.measures import cell_name
from egad.report.axes import AxisPair
from egad.report.page import DASH, data_uri
from egad.report.viewer import GraspScene, viewer_data

TIMES = "\N{MULTIPLICATION SIGN}"


class ObjectsView(NamedTuple):
    """The objects of a dataset."""

    pictures: dict[str, str]  # addresses of their pictures by label; empty for those without one
    names: dict[str, str]  # names in the evaluation set by label, of those that are in it
    values: dict[str, dict[str, str]]  # texts by label and title of their column
    viewer: dict[str, Any] | None  # data of the 3D viewer; None if there are no grasps


class GripperTables(NamedTuple):
    """Tables of objects: `SCALES`, `MANIFEST` by gripper, `TRIALS` also by detector."""

    scales: Mapping[str, pd.DataFrame]
    manifests: Mapping[str, pd.DataFrame]
    trials: Mapping[tuple[str, str], pd.DataFrame]


def objects_view(
    objects: pd.DataFrame,
    pictures: Mapping[str, bytes],
    axes: AxisPair,
    evalset: pd.DataFrame | None,
    tables: GripperTables,
    scenes: Sequence[GraspScene],
    gripper: Gripper,
) -> ObjectsView:
    """What the section shows of `tables.objects.OBJECTS`; not all have a PNG, by label."""
    labels: dict[str, str] = {}
    if evalset is not None:
        labels |= zip(evalset["label"], evalset["object_label"], strict=True)
    parts = [_measures(objects, axes)]
    if any(name != label for name, label in labels.items()):
        parts.append(pd.DataFrame({"in the set": labels.keys()}, list(labels.values())))
    parts += [_of_gripper(name, tables, labels) for name in tables.scales]
    texts = pd.concat(parts, axis=1).fillna(DASH)
    shown = objects["label"].tolist()
    values = zip(shown, texts.reindex(shown, fill_value=DASH).to_dict("records"), strict=True)
    return ObjectsView(
        {label: data_uri(pictures.get(label, b"")) for label in shown},
        {label: name for name, label in labels.items()},
        {label: {str(key): text for key, text in row.items()} for label, row in values},
        viewer_data(scenes, gripper) if scenes else None,
    )


def _measures(objects: pd.DataFrame, axes: AxisPair) -> pd.DataFrame:
    """Sides, measures and cell of each object."""
    columns = {
        "size, mm": [
            f" {TIMES} ".join(f"{1000 * side:.0f}" for side in sides)
            for sides in objects[["extents_x", "extents_y", "extents_z"]].to_numpy()
        ]
    }
    for axis, name in zip(axes, ("complexity", "graspability"), strict=True):
        title = ", ".join(filter(None, (axis.value, axis.printed_unit)))
        columns[title] = [f"{axis.factor * value:.2f}" for value in objects[name]]
    cells = zip(objects["complexity_cell"], objects["difficulty_cell"], strict=True)
    return pd.DataFrame(columns, objects["label"]).assign(cell=[cell_name(*each) for each in cells])


def _of_gripper(gripper: str, tables: GripperTables, labels: Mapping[str, str]) -> pd.DataFrame:
    """Scale, print and successes of each object."""
    scales = tables.scales[gripper].set_index("label")["factor"]
    prints = tables.manifests[gripper].set_index("label").rename(index=labels)
    plates = [f"plate {plate:.0f}" if plate == plate else "" for plate in prints["plate"]]
    notes = ["; ".join(filter(None, each)) for each in zip(plates, prints["note"], strict=True)]
    columns = {
        "scale": scales.map("{:.3g}".format),
        "to print": pd.Series(notes, prints.index, dtype=object),
    }
    trials = {
        detector: table for (name, detector), table in tables.trials.items() if name == gripper
    }
    for detector, table in trials.items():
        rates = by_object(table).rename(index=labels).astype(str)
        title = "successes" if len(trials) == 1 else f"successes of {detector}"
        columns[title] = rates["successes"] + " of " + rates["attempts"]
    return pd.DataFrame(columns).add_suffix(f", {gripper}" if len(tables.scales) > 1 else "")
