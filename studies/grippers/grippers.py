"""Hands from files of their makers, compared with boxes of the same name.

    python studies/grippers/grippers.py picture HAND.urdf ...
    python studies/grippers/grippers.py labels panda=HAND.urdf robotiq_2f_85=HAND.urdf ...
    python studies/grippers/grippers.py path HAND.xml
    python studies/grippers/grippers.py changes panda=HAND.urdf
    python studies/grippers/grippers.py outlines panda=HAND.urdf robotiq_2f_85=HAND.urdf ...
    python studies/grippers/grippers.py trials OUT panda=HAND.urdf robotiq_2f_85=HAND.urdf ...

`picture` draws each hand open, half open and closed into docs/grippers.png. `path` lets MuJoCo
close the hand by its own motor, and prints how far its fingertips are from the model's. `outlines`
draws the boxes over the shapes of the files into grippers.svg. `labels` compares the collision
labels of 20,000 grasps of the released evaluation set, `changes` draws one grasp for each way in
which they differ into grippers-labels.png; `panda=boxes` stands for the boxes themselves,
written to a file. `trials` compares 980 attempts with labelled grasps in both engines;
trials are kept in OUT and not run again.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from tempfile import NamedTemporaryFile

import matplotlib as mpl
import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import ConvexHull

import egad
from egad._util.arrays import RgbImage
from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.bench.trials import Trials
from egad.geometry import RayCaster
from egad.grasps import ContactPairs, hand_poses, label_parameters, sample_for_labels
from egad.grasps.approach import Approaches, best_approaches
from egad.grippers import (
    CLEARANCE,
    GRIPPERS,
    SIZES,
    BoxBody,
    Gripper,
    HandModel,
    ModelBody,
    finger_span,
    model_of,
)
from egad.random import generator
from egad.report.hand_shape import hand_shapes
from egad.sim.film import draw

COLORS = {0: (0.72, 0.74, 0.78), -1: (0.36, 0.56, 0.80), 1: (0.95, 0.62, 0.29)}
CAMERA, NEAR = (0.58, 35.0, -12.0), (0.26, 40.0, -20.0)  # metres, yaw and pitch, degrees
OBJECT = (0.45, 0.72, 0.60)
SIDES = {0: 0, 1: -1, 2: 1}  # by numbers of colors in the 3D view
CROP = (slice(85, 315), slice(40, -40))
DOWN = trimesh.transformations.rotation_matrix(np.pi, (1, 0, 0))
FOLDER = Path(__file__).parent
GRASPS = 410  # of each of the 49 objects
SETTLING, STEPS = 6.0, 100  # seconds for each position of the motor; positions
ENGINES = ("mujoco", "pybullet")
FORCE = 40.0  # newtons, of hands that egad does not know by name


def picture(model: HandModel, opening: float) -> RgbImage:
    """A hand at an opening, pointing down."""
    bodies = []
    for link, shapes in zip(model.links, model.points(opening), strict=True):
        hulls = [trimesh.convex.convex_hull(points) for points in shapes]
        bodies += [(hull.apply_transform(DOWN), COLORS[link.body]) for hull in hulls]
    closed = np.concatenate([points for link in model.points(0.0) for points in link])
    height = -(closed[:, 2].min() + closed[:, 2].max()) / 2
    return draw(bodies, np.array([0.0, 0.0, height]), CAMERA)[CROP]


def draw_hands(files: list[str]) -> None:
    """Draw hands into docs/grippers.png."""
    rows = []
    for file in files:
        model = model_of(Gripper.from_file(file))
        openings = model.openings[[-1, len(model.openings) // 2, 0]]
        rows.append(np.concatenate([picture(model, float(w)) for w in openings], axis=1))
    sheet = Image.fromarray(np.concatenate(rows))
    with atomic_output(FOLDER.parents[1] / "docs/grippers.png") as out:
        sheet.quantize(64).save(out, "png", optimize=True)


def pairs(given: list[str]) -> Iterator[tuple[str, Gripper, Gripper]]:
    """Names, boxes, and the same gripper from its file, with as much force.

    The boxes are those that egad knows by name, or else those of the sizes found in the file.
    """
    for each in given:
        name, _, path = each.partition("=")
        known = GRIPPERS.get(name)
        file = (
            as_file(known)
            if path == "boxes" and known
            else Gripper.from_file(path, force=known.force if known else FORCE)
        )
        sizes = file.model_dump(include=SIZES | {"force"})
        yield name, known or Gripper.model_validate(sizes), file


def as_file(gripper: Gripper) -> Gripper:
    """The boxes of a gripper, by way of a URDF file."""
    base, tip = finger_span(gripper)
    thick, wide, palm = gripper.finger_thickness, gripper.finger_width, gripper.palm
    size = " ".join(map(str, palm))
    sides = [
        f"""<link name="{name}"><collision><origin xyz="{way * (thick / 2 + CLEARANCE)} 0
        {(base + tip) / 2}"/><geometry><box size="{thick} {wide} {tip - base}"/></geometry>
        </collision></link><joint name="{name}" type="prismatic"><parent link="palm"/>
        <child link="{name}"/><axis xyz="{way} 0 0"/>
        <limit lower="0" upper="{gripper.opening / 2}" effort="1" velocity="1"/></joint>"""
        for name, way in (("left", -1), ("right", 1))
    ]
    text = f"""<robot name="boxes"><link name="palm"><collision>
        <origin xyz="0 0 {base - palm[2] / 2}"/><geometry><box size="{size}"/>
        </geometry></collision></link>{"".join(sides)}</robot>"""
    with NamedTemporaryFile("w", suffix=".urdf", delete=False) as file:
        file.write(text)
    return Gripper.from_file(file.name, tcp=(0, 0, 0), force=gripper.force)


def simulate_path(file: str) -> None:
    """Print how far fingertips are from where the model has them while MuJoCo closes the hand."""
    model = model_of(Gripper.from_file(file))
    engine = mujoco.MjModel.from_xml_path(file)
    engine.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    engine.opt.gravity[:] = 0
    data, seconds = mujoco.MjData(engine), round(SETTLING / engine.opt.timestep)
    turn, origin = model.palm_to_hand[:3, :3], model.palm_to_hand[:3, 3]
    farthest, openings = 0.0, []
    for target in np.linspace(*engine.actuator_ctrlrange[0], STEPS):
        data.ctrl[0] = target
        mujoco.mj_step(engine, data, seconds)
        position = float(data.joint(model.joints[0]).qpos[0])
        if not np.ptp([*model.positions[[0, -1], 0], position]) <= abs(
            np.subtract(*model.positions[[0, -1], 0])
        ):
            continue  # the pads have met in the model
        opening = model.opening_at(position)
        openings.append(opening)
        turns, places = model.poses(opening)
        palm = data.body(model.links[0].name)
        back = palm.xmat.reshape(3, 3)
        for number, link in enumerate(model.links):
            if not (link.body and link.shapes):
                continue
            body = data.body(link.name)
            tip = max(
                np.concatenate(link.shapes), key=lambda point, n=number: (turns[n] @ point)[2]
            )
            seen = back.T @ (body.xmat.reshape(3, 3) @ tip + body.xpos - palm.xpos) - origin
            ours = turns[number] @ tip + places[number]
            farthest = max(farthest, float(np.linalg.norm(turn.T @ seen - ours)))
    print(f"{1000 * max(openings):.1f} to {1000 * min(openings):.1f} mm: {1000 * farthest:.4f} mm")


def draw_outlines(given: list[str]) -> None:
    """Draw the boxes over the shapes from files, open, into grippers.svg."""
    hands = list(pairs(given))
    figure, axes = plt.subplots(2, len(hands), figsize=(3.2 * len(hands), 6.4), squeeze=False)
    for column, (name, boxes, file) in zip(axes.T, hands, strict=True):
        model = model_of(file)
        reach = float(model.reach[-1])
        for axis, across in zip(column, (0, 1), strict=True):
            for link, shapes in zip(model.links, model.points(file.opening), strict=True):
                for points in shapes:
                    seen = (points - [0, 0, reach])[:, [across, 2]] * [1000, -1000]
                    outline = seen[ConvexHull(seen).vertices]
                    axis.fill(*outline.T, color=COLORS[link.body], linewidth=0)
            for part in BoxBody(boxes).parts():
                (left, start), (right, end) = part.box[:, [across, 2]] * 1000
                axis.plot(
                    [left, right, right, left, left],
                    [-start, -start, -end, -end, -start],
                    "k",
                    lw=1,
                )
            axis.set(aspect="equal", xlabel=f"{'xy'[across]}, mm", ylabel="mm above the contacts")
        column[0].set_title(name)
    figure.tight_layout()
    mpl.rcParams.update({"svg.hashsalt": "egad", "svg.fonttype": "none"})
    with atomic_output(FOLDER / "grippers.svg") as out:
        figure.savefig(out, format="svg", metadata={"Date": None})


def compare_labels(given: list[str]) -> None:
    """Print how many labels change from boxes to files, and which box was in the way."""
    print("| gripper | grasps | free, boxes | free, file | changed | box fingers | box palm |")
    print("| --- " * 7 + "|")
    objects = egad.load("evaluation-set")
    for name, boxes, file in pairs(given):
        found = pd.concat(
            [labels_of(each, boxes, file) for each in progress(objects, name, len(objects))]
        )
        free, model = found["boxes"], found["file"]
        shares = [free, model, free != model, model & ~found["fingers"], model & ~found["palm"]]
        percents = " | ".join(f"{100 * share.mean():.1f}" for share in shares)
        print(f"| `{name}` | {len(found)} | {percents} |")


def labels_of(target: egad.EvolvedObject, boxes: Gripper, file: Gripper) -> pd.DataFrame:
    """Whether grasps of an object are free with boxes, with a file, and with part of the boxes."""
    _, _, found = approaches(target, boxes, file)
    return pd.DataFrame({key: each.free for key, each in found.items()})


def approaches(
    target: egad.EvolvedObject, boxes: Gripper, file: Gripper
) -> tuple[trimesh.Trimesh, ContactPairs, dict[str, Approaches]]:
    """A scaled object, grasps of it, and their approaches: of boxes, a file, part of the boxes."""
    narrow = min((boxes, file), key=lambda gripper: gripper.opening)
    mesh, _ = egad.rescale(target.mesh, narrow)
    caster, settings = RayCaster(mesh), label_parameters(narrow, GRASPS, 0)
    grasps, _ = sample_for_labels(caster, settings, generator(0, "grippers", target.id))
    far = boxes.model_copy(update={"palm": (1e-4, 1e-4, 1e-4)})
    thin = boxes.model_copy(update={"finger_thickness": 1e-4, "finger_width": 1e-4})
    thin = thin.model_copy(update={"fingertip": boxes.finger_width / 2})
    bodies = {
        "boxes": BoxBody(boxes),
        "file": ModelBody(file, model_of(file)),
        "fingers": BoxBody(far),
        "palm": BoxBody(thin),
    }
    found = {key: best_approaches(caster, grasps, body) for key, body in bodies.items()}
    return mesh, grasps, found


def draw_changes(given: list[str]) -> None:
    """Draw grasps whose labels differ into grippers-labels.png."""
    ((_, boxes, file),) = pairs(given)
    pictures: dict[str, list[RgbImage]] = {}
    for target in egad.load("evaluation-set"):
        mesh, grasps, found = approaches(target, boxes, file)
        free = {key: each.free for key, each in found.items()}
        causes = {
            "box fingers collide": ~free["boxes"] & free["file"] & ~free["fingers"],
            "box palm collides": ~free["boxes"] & free["file"] & ~free["palm"],
            "file collides": free["boxes"] & ~free["file"],
        }
        for cause in [name for name, those in causes.items() if those.any()]:
            number = [int(causes[cause].argmax())]
            way = found["boxes" if cause == "file collides" else "file"].directions[number]
            (pose,) = hand_poses(grasps.centers[number], grasps.axes[number], way)
            if cause not in pictures:
                pictures[cause] = [at_grasp(mesh, pose, hand) for hand in (boxes, file)]
        if len(pictures) == len(causes):
            break
    figure, axes = plt.subplots(2, len(pictures), figsize=(9.6, 5.4), squeeze=False)
    for column, cause in zip(axes.T, causes, strict=True):
        for axis, pixels in zip(column, pictures[cause], strict=True):
            axis.imshow(pixels)
            axis.axis("off")
        column[0].set_title(cause, fontsize=10)
    figure.tight_layout()
    with atomic_output(FOLDER / "grippers-labels.png") as out:
        figure.savefig(out, format="png", dpi=90, metadata={"Software": None})


def at_grasp(mesh: trimesh.Trimesh, pose: NDArray[np.float64], gripper: Gripper) -> RgbImage:
    """An object and the open hand at a grasp, in the frame of the hand."""
    hand = [(part, COLORS[SIDES[color]]) for part, color in hand_shapes(gripper, gripper.opening)]
    bodies = [(mesh.copy().apply_transform(np.linalg.inv(pose)), OBJECT), *hand]
    seen = [(body.apply_transform(DOWN), color) for body, color in bodies]
    return draw(seen, np.array([0.0, 0.0, 0.01]), NEAR)


def compare_trials(out: Path, given: list[str], jobs: int) -> None:
    """Run the trials that are missing, and print success with intervals."""
    print("| gripper | engine | boxes | file |\n| --- | --- | --- | --- |")
    objects = egad.load("evaluation-set")
    for engine in ENGINES:
        for name, *hands in pairs(given):
            cells = []
            for kind, gripper in zip(("boxes", "file"), hands, strict=True):
                path = out / f"{name}-{kind}-labels-{engine}.parquet"
                if not path.exists():
                    made = egad.run_trials(
                        "labels", objects, gripper, depth_noise=0.1, engine=engine, jobs=jobs
                    )
                    with atomic_output(path) as file_out:
                        made.table.to_parquet(file_out)
                rate = Trials(pd.read_parquet(path)).success_rate()
                low, high = 100 * np.array(rate.interval)
                cells.append(f"{100 * rate.value:.0f} ({low:.0f} to {high:.0f})")
            print(f"| `{name}` | {engine} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for command in ("picture", "path", "labels", "changes", "outlines", "trials"):
        added = commands.add_parser(command)
        if command == "trials":
            added.add_argument("out", type=Path)
            added.add_argument("--jobs", type=int, default=2)
        added.add_argument("hands", nargs="+")
    chosen = parser.parse_args()
    if chosen.command == "picture":
        draw_hands(chosen.hands)
    elif chosen.command == "path":
        for each in chosen.hands:
            simulate_path(each)
    elif chosen.command == "labels":
        compare_labels(chosen.hands)
    elif chosen.command == "changes":
        draw_changes(chosen.hands)
    elif chosen.command == "outlines":
        draw_outlines(chosen.hands)
    else:
        chosen.out.mkdir(parents=True, exist_ok=True)
        compare_trials(chosen.out, chosen.hands, chosen.jobs)
