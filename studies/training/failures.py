"""Pictures of typical failures: `python failures.py STUDY NOISE SET`.

STUDY is the folder `results/training_study`. For each outcome of more than 1 % of the failed grasps
of the networks of SET in a test, the picture shows the first such attempt at the object with most
of them: the depth image without noise, with the grasp as a line between the fingertips, and frames
of the attempt from when the hand comes to when it leaves. Writes
training_failures.png.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

sys.path.append(str(Path(__file__).parents[1]))
from pictures import chosen, save_sheet, typical  # type: ignore[import-not-found]
from study import read_study

from egad._util.arrays import RgbImage
from egad.bench import SimulatedTrials, TrialProtocol, repeat_attempt
from egad.detectors import DepthCamera, Grasp, Intrinsics, camera_above
from egad.exchange import bundle_models
from egad.sim import Model, Pose
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad_workflow.settings import select

FOLDER = Path(__file__).parent
FRAMES = 5
SHARE = 0.01  # of all failures, for an outcome to be shown
CROP = 270, 300  # pixels of the depth image that are shown
HIGHEST = 0.05  # metres; objects less high are not white


def main(results: Path, noise: str, name: str) -> None:
    """Draw the picture."""
    study = read_study(Path(__file__).with_name("study.yaml"))
    hand = study.gripper
    trials = select(study.settings, SimulatedTrials, hand)
    rows: list[tuple[str, list[RgbImage]]] = []
    networks = [each.name for each in study.plan.networks if each.training_set == name]
    for test in study.plan.tests:
        folder = results / "trials" / test / noise
        tables = [parquet.read(folder / f"{network}.parquet", TRIALS) for network in networks]
        shown = typical(pd.concat(tables), "label", SHARE)
        for attempt in parquet.records(shown):
            title = f"{test}, {attempt['label']}: {attempt['outcome'].replace('_', ' ')}"
            rows.append((title, pictures(trials, attempt, results.parent / test / "bundle" / hand)))
    save_sheet(rows, FOLDER / "training_failures.png", colors=256)


def pictures(trials: SimulatedTrials, attempt: dict[str, Any], bundle: Path) -> list[RgbImage]:
    """The depth image of an attempt and frames of its film."""
    models = bundle_models(bundle)
    again, frames = repeat_attempt(trials, attempt, models)
    found: list[RgbImage] = chosen(frames, FRAMES)
    if again.rest and again.grasp:
        found.insert(
            0, depth_picture(models[attempt["id"]], again.rest, again.grasp, trials.trials)
        )
    return found


def depth_picture(model: Model, rest: Pose, grasp: Grasp, trials: TrialProtocol) -> RgbImage:
    """The middle of the depth image, higher parts brighter, with the line of the grasp."""
    camera = Intrinsics.spanning(*trials.image, trials.field_of_view)
    pose = camera_above(trials.camera_height)
    depth = DepthCamera(model.mesh).render(rest.matrix, camera, pose).depth
    height = np.clip((trials.camera_height - depth) / max(HIGHEST, float(np.ptp(depth))), 0, 1)
    picture = Image.fromarray((60 + 195 * height).astype(np.uint8)).convert("RGB")
    pen = ImageDraw.Draw(picture)
    reach = grasp.width / 2 * np.array([np.cos(grasp.angle), np.sin(grasp.angle), 0])
    ends = np.add(grasp.center, np.stack([-reach, reach]))
    (u, v), (u2, v2) = camera.pixels((ends - pose[:3, 3]) @ pose[:3, :3])
    pen.line([(u, v), (u2, v2)], "red", 3)
    left, top = (camera.width - CROP[0]) // 2, (camera.height - CROP[1]) // 2
    return np.asarray(picture.crop((left, top, left + CROP[0], top + CROP[1])))


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
