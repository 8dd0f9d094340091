"""Write the 49 evaluation objects, scaled to the Panda, with labelled grasps.

python examples/maniskill/prepare.py build/maniskill
"""

import argparse
from pathlib import Path

import pandas as pd
import trimesh
from egad_objects import SURFACE

import egad

GRASPS = "grasps.parquet"


def sample(folder: Path, grasps: int) -> pd.DataFrame:
    """At most so many grasps of each object: columns of `results/D/grasps/G.parquet` but `id`."""
    tables = []
    for file in sorted(folder.glob(f"*/{SURFACE}")):
        found = egad.sample_grasps(trimesh.load_mesh(file), "panda", n=grasps, seed=0)
        tables.append(found.to_frame().assign(label=file.parent.name))
    return pd.concat(tables, ignore_index=True)


def main() -> None:
    """Read the arguments and write the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path, help="new folder")
    parser.add_argument("--grasps", type=int, default=500, help="most grasps of an object")
    arguments = parser.parse_args()
    egad.export(egad.load("evaluation-set"), format="urdf", gripper="panda", out=arguments.out)
    sample(arguments.out, arguments.grasps).to_parquet(arguments.out / GRASPS)


if __name__ == "__main__":
    main()
