"""The study of scenes: what Snakemake would do."""

import shutil
from ast import literal_eval
from collections import Counter
from pathlib import Path

import pytest

from egad_workflow.config_files import read_values

STUDY = "studies/scenes"
ROOT = Path(__file__).parents[2]
ASKED = {
    "egad": {
        **read_values(ROOT / "config/test.yaml"),
        "shards": 2,
        "scenes": {"scenes": 3},
        "detectors": {
            "vgn": {"weights": "vgn.pth"},
            "vgn-low": {"detector": "vgn", "weights": "vgn.pth"},
        },
    },
    "sets": {
        "evolved": {"dataset": "egad"},
        "primitives": {"dataset": "egad", "scenes": 1},
        "tuned-evolved": {"dataset": "egad", "start": "vgn.pth"},
        "tuned-primitives": {"dataset": "egad", "networks": 1},
    },
    "networks": 2,
    "threshold": 0.5,
    "references": ["vgn", "vgn-low", "random"],
    "tests": ["egad"],
    "cameras": {"six": {"rounds": 2}, "side": {"rounds": 1, "cameras": {"views": 1}}},
}


@pytest.fixture(scope="module")
def told(kept):
    """The jobs of a small study."""
    return planned(kept("study"), ASKED)


def planned(clean, asked):
    shutil.copytree(ROOT / STUDY, clean.folder / STUDY, ignore=shutil.ignore_patterns("__py*"))
    (clean.folder / "vgn.pth").write_bytes(b"weights")
    config = clean.overlay("asked.yaml", asked)
    target = "results/scene_study/tables.md"
    return clean.told(target, snakefile=f"{STUDY}/Snakefile", configs=[config])


def test_weights_that_a_network_begins_with_must_be_there(clean):
    sets = ASKED["sets"] | {"tuned-evolved": {"dataset": "egad", "start": "absent.pth"}}
    with pytest.raises(AssertionError, match="absent"):
        planned(clean, ASKED | {"sets": sets})


def test_every_network_is_trained_and_every_detector_tested_in_every_condition(told):
    counts = Counter(job.rule for job in told)
    assert (counts["train_on_scenes"], counts["scene_clutter"]) == (7, 10 * 2)
    assert (counts["scene_card"], counts["scene_study"]) == (1, 1)
    assert "clutter" not in counts
    trained = {job.output.split()[0]: job for job in told if job.rule == "train_on_scenes"}
    assert len(trained) == 7
    settings = [literal_eval(job.params["settings"]) for job in trained.values()]
    found = {(each["seed"], each["training"]["scenes"]) for each in settings}
    seeds = {seed for seed, _ in found}
    assert found == {(seed, scenes) for seed in seeds for scenes in (None, 1)}
    assert len(seeds) == 2


def test_conditions_have_their_cameras_and_rounds(told):
    for name, rounds, views in (("six", 2, 6), ("side", 1, 1)):
        jobs = [job for job in told if job.rule == "scene_clutter" and f"/{name}/" in job.output]
        assert len(jobs) == 10
        for job in jobs:
            clutter = literal_eval(job.params["settings"])["clutter"]
            assert clutter["rounds"] == rounds
            assert clutter["protocol"]["cameras"]["views"] == views
