"""A grasp detector in its own environment: needs Python, NumPy and msgpack, but not egad.

    egad benchmark narrow_side --command "python detector_program.py"

Replace `detect` by your detector, and OBSERVES by what it wants to see.
"""

import os
import struct
import sys

import msgpack
import numpy as np

OBSERVES = "cloud"  # view, views, tsdf, cloud or observation


def detect(observation, gripper, rng):
    """Grasp the highest thing across its narrower side, from above: (poses, widths, scores)."""
    points = observation["cloud"]["points"]  # (n, 3), metres; the table is at height 0
    if len(points) == 0:
        return np.empty((0, 4, 4)), np.empty(0), np.empty(0)
    highest = points[points[:, 2].argmax()]
    near = points[np.linalg.norm(points[:, :2] - highest[:2], axis=1) < gripper["opening"] / 2]
    away = near[:, :2] - near[:, :2].mean(axis=0)
    x = np.append(np.linalg.eigh(away.T @ away)[1][:, 0], 0.0)  # the closing axis
    z = np.array([0.0, 0.0, -1.0])  # the approach
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    pose[:2, 3] = near[:, :2].mean(axis=0)
    pose[2, 3] = max(highest[2] - 0.02, 0.015)
    return pose[None], np.array([gripper["opening"]]), np.array([1.0])


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


def main():
    """Say hello, and answer until egad hangs up."""
    questions, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what is printed goes to the log, not between the answers

    def send(message):
        data = msgpack.packb(message, default=encode)
        answers.write(struct.pack(">I", len(data)) + data)
        answers.flush()

    send({"protocol": 1, "observes": OBSERVES})
    while len(head := questions.read(4)) == 4:
        data = questions.read(struct.unpack(">I", head)[0])
        asked = msgpack.unpackb(data, object_hook=decode)
        rng = np.random.default_rng(asked["seed"])
        poses, widths, scores = detect(asked["observation"], asked["gripper"], rng)
        send({"poses": poses, "widths": widths, "scores": scores})


if __name__ == "__main__":
    main()
