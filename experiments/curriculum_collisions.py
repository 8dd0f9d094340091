"""Does a check for collisions remove failures? `curriculum_collisions.py FOLDER SCENES`.

FOLDER is that of `curriculum.py --held-out 3000` for the networks `tuned-evolved`, and SCENES are
the scenes that they know. `vgn-evolved` is the first of these networks with `avoid_collisions`. It
is searched as that network was, and the table has both. This was not planned. An interrupted call
resumes.
"""

import argparse
from pathlib import Path

from curriculum import HELD_OUT, LEARNT, objects_in, search, starmap
from curriculum_tables import ATLAS, SEARCHED_AGAIN, yields

from egad._util.markdown import table as markdown
from egad._util.workers import workers
from egad.detectors import DetectorConfig

NETWORK = 0  # that of the detector
CHECKED = DetectorConfig(detector="vgn-evolved")


def main(folder: Path, scenes: Path, jobs: int) -> None:
    """Make what is missing, then print the table."""
    plans = {
        LEARNT: objects_in(scenes, "train"),
        HELD_OUT._replace(attempts=SEARCHED_AGAIN): objects_in(scenes, "validation", "test"),
    }
    searches = [
        (folder, plan, NETWORK, CHECKED, f"checked-{plan.name}", objects)
        for plan, objects in plans.items()
    ]
    with workers(jobs) as mapper:
        checked = starmap(mapper, search, searches)
    unchecked = [folder / f"searches/{plan.name}-{NETWORK}/{ATLAS}" for plan in plans]
    rows = [
        (name, *yields(atlases)[1:5])
        for name, atlases in (("no check", unchecked), ("avoid_collisions", checked))
    ]
    titles = ["failures, by search", "different", "grasps", "failures per 1000 grasps"]
    print(markdown(["", *titles], rows))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    main(**vars(parser.parse_args()))
