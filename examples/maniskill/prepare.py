"""Write the 49 evaluation objects, scaled to the Panda, with labelled grasps.

python examples/maniskill/prepare.py build/maniskill
"""

import argparse
from pathlib import Path

import pandas as pd
import trimesh

import egad

GRASPS = "grasps.parquet"


def sample(folder: Path, grasps: int) -> pd.DataFrame:
    """Grasps of all objects in a folder: columns as in `results/D/grasps/G.parquet`, without `id`.

    Args:
        folder: Has `LABEL/visual.obj` for each object.
        grasps: Most grasps of an object.
    """
    tables = []
    for file in sorted(folder.glob("*/visual.obj")):
        mesh = trimesh.load_mesh(file)
        found = egad.sample_grasps(mesh, "panda", n=grasps, seed=0).to_frame()
        tables.append(found.assign(label=file.parent.name))
    return pd.concat(tables, ignore_index=True)


def main() -> None:
    """Read the arguments and write the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="new folder")
    parser.add_argument("--grasps", type=int, default=500, help="most grasps of an object")
    arguments = parser.parse_args()
    objects = egad.load("evaluation-set")
    egad.export(objects, format="simulation", gripper="panda", out=arguments.out)
    sample(arguments.out, arguments.grasps).to_parquet(arguments.out / GRASPS)


if __name__ == "__main__":
    main()
