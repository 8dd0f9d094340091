"""The process that CoACD runs in: a mesh on its standard input, vertices of parts on its output."""

import io
import os
import sys

import coacd
import numpy as np


def main() -> None:
    """Read `vertices` and `faces`, write `part0`, `part1`, ...: all as one npz archive."""
    threshold, max_parts = float(sys.argv[1]), int(sys.argv[2])
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what the library prints must not get among the results
    with np.load(io.BytesIO(sys.stdin.buffer.read())) as sent:
        mesh = coacd.Mesh(sent["vertices"], sent["faces"])
    coacd.set_log_level("error")
    parts = coacd.run_coacd(
        mesh, threshold=threshold, max_convex_hull=max_parts, preprocess_mode="off", seed=0
    )
    buffer = io.BytesIO()
    np.savez(buffer, **{f"part{number}": vertices for number, (vertices, _) in enumerate(parts)})
    with out:
        out.write(buffer.getvalue())


if __name__ == "__main__":
    main()
