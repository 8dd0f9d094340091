"""Can networks learn failures if they see nothing else? `curriculum_alone.py FOLDER NETWORKS`.

FOLDER is a complete one of `curriculum.py`, and NETWORKS has the networks that were trained further
there. Each is trained further on scenes of failures alone; some failures are for validation and
test. The result, the network before and the one after the training of the study are tried at the
failures that are trained on, and the first one also at held-out failures. This was not planned. An
interrupted call resumes.
"""

import argparse
from pathlib import Path

from curriculum import (
    HELD_OUT,
    LEARNT,
    atlases_of,
    further_objects,
    further_scenes,
    ids_in,
    networks_after,
    networks_before,
    starmap,
    tested_objects,
    train,
    try_failures,
)
from curriculum_tables import ALONE, BEFORE, NETWORKS, RETRIED, show
from failures import unlike

from egad._util.workers import workers

SCENES = 1000  # of one object each
SHARE = 0.1  # of the scenes, for validation, and as many for the test


def main(folder: Path, networks: Path, jobs: int) -> None:
    """Make what is missing, then print the tables."""
    learnt, held_out = atlases_of(folder, LEARNT), atlases_of(folder, HELD_OUT)
    chosen = further_objects(learnt)
    failures, scenes = chosen["failures"], folder / "scenes" / ALONE
    further_scenes(scenes, failures, learnt[0].searched_with(), SCENES, SHARE)
    before, alone = networks_before(networks), networks_after(folder, ALONE)
    known = failures[failures["id"].isin(ids_in(scenes, "train"))]
    trained_on = dict.fromkeys(known["id"].iloc[unlike(known["voxels"])], False)
    tested = tested_objects(held_out, chosen)
    with workers(jobs) as mapper:
        trainings = zip(alone, [[scenes]] * NETWORKS, before, range(NETWORKS), strict=True)
        starmap(mapper, train, trainings)
        tried = {BEFORE: before, "failures": networks_after(folder, "failures"), ALONE: alone}
        retries = [
            (folder / RETRIED / f"{kind}-{number}", weights, trained_on, learnt)
            for kind, each in tried.items()
            for number, weights in enumerate(each)
        ]
        retries += [
            (folder / f"held-out/{ALONE}-{number}", weights, tested, held_out)
            for number, weights in enumerate(alone)
        ]
        starmap(mapper, try_failures, retries)
    show(folder)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("networks", type=Path, help="folder of the networks")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    main(**vars(parser.parse_args()))
