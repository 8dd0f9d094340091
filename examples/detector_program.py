"""A grasp detector in its own environment: needs Python, NumPy and msgpack, but not egad.

    egad benchmark my_detector --command "python detector_program.py"

Replace `detect` by your detector, and OBSERVES by what it wants to see.
"""

import os
import struct
import sys
import traceback

import msgpack
import numpy as np

OBSERVES = "cloud"  # view, views, tsdf, cloud, object_clouds or observation


def detect(observation, gripper, rng):
    """Grasp from above, at random points, where the fingers fit: (poses, widths, scores)."""
    points, normals = observation["cloud"]["points"], observation["cloud"]["normals"]
    high = points[points[:, 2] > 0.01]  # metres; the table is at height 0
    angles = rng.uniform(0, np.pi, 300 if len(high) else 0)
    tried = [try_grasp(high[rng.integers(len(high))], a, points, normals, gripper) for a in angles]
    poses, widths, scores = zip(*filter(None, tried)) if any(tried) else ((), (), ())
    return np.array(poses).reshape(-1, 4, 4), np.array(widths), np.array(scores)


def try_grasp(point, angle, points, normals, gripper):
    """Pose, width and score of a grasp around a point; None if the hand does not fit there."""
    closing = np.array([np.cos(angle), np.sin(angle), 0.0])
    across = np.array([-np.sin(angle), np.cos(angle), 0.0])
    tip = max(point[2] - 0.02, 0.003)  # height of the fingertips
    beside = np.abs((points - point) @ across) < 0.6 * gripper["finger_width"]
    strip = np.flatnonzero(beside & (points[:, 2] > tip))
    strip = strip[np.argsort((points[strip] - point) @ closing)]
    along = (points[strip] - point) @ closing
    # What the fingers close around ends where there is space for them.
    gaps = np.flatnonzero(np.diff(along) > 1.5 * gripper["finger_thickness"])
    number = np.searchsorted(gaps, np.searchsorted(along, 0.0))
    first = gaps[number - 1] + 1 if number > 0 else 0
    last = gaps[number] if number < len(gaps) else len(along) - 1
    width = along[last] - along[first] + 0.01
    reach = points[strip, 2].max() - tip
    if width > gripper["opening"] or reach > gripper["finger_length"]:
        return None
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([closing, -across, [0, 0, -1]])  # the last one: the approach
    pose[:3, 3] = point + (along[first] + along[last]) / 2 * closing
    pose[2, 3] = tip + min(gripper["finger_width"], gripper["finger_length"]) / 2
    return pose, width, (normals[strip[last]] - normals[strip[first]]) @ closing


def encode(value):
    """An array for msgpack, as the package msgpack-numpy has it."""
    data = np.ascontiguousarray(value)
    kind, shape = data.dtype.str, list(data.shape)
    return {b"nd": True, b"type": kind, b"kind": b"", b"shape": shape, b"data": data.tobytes()}


def decode(table):
    """The array of such a table."""
    if b"nd" not in table:
        return table
    return np.frombuffer(table[b"data"], table[b"type"]).reshape(table[b"shape"])


def main(detect=detect, observes=OBSERVES):
    """Say hello, and answer until egad hangs up."""
    questions, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what is printed goes to the log, not between the answers

    def send(message):
        data = msgpack.packb(message, default=encode)
        answers.write(struct.pack(">I", len(data)) + data)
        answers.flush()

    send({"protocol": 1, "observes": observes})
    while len(head := questions.read(4)) == 4:
        data = questions.read(struct.unpack(">I", head)[0])
        asked = msgpack.unpackb(data, object_hook=decode)
        rng = np.random.default_rng(asked["seed"])
        try:
            poses, widths, scores = detect(asked["observation"], asked["gripper"], rng)
            send({"poses": poses, "widths": widths, "scores": scores})
        except Exception:
            send({"error": traceback.format_exc()})


if __name__ == "__main__":
    main()
