"""The profiles, and the workflow through a scheduler: the one of profiles/local-test."""

import runpy
from pathlib import Path

import pytest
import yaml
from rule_texts import OWN

ROOT = Path(__file__).parents[2]
RULES = ROOT / "workflow/rules"
RESOURCES = runpy.run_path(str(RULES / "resources.smk"))
LOCAL_TEST = ["--profile", "profiles/local-test", "--latency-wait", 2]


def submitted(checkout):
    """What was asked for all jobs: rule, threads, megabytes, minutes."""
    table = checkout.folder / ".snakemake/local-test/submitted.tsv"
    return [tuple(line.split()[1:5]) for line in table.read_text().splitlines()]


@pytest.mark.parametrize("profile", ["local-test", "slurm"])
def test_every_option_of_a_profile_is_known(clean, profile):
    assert "evolve" in clean.make("--profile", f"profiles/{profile}", "--list-rules")


def test_only_profiles_say_how_often_a_job_is_tried_again():
    assert not [path for path in RULES.glob("*.smk") if "retries:" in path.read_text()]
    for profile in ("local-test", "slurm"):
        options = yaml.safe_load((ROOT / f"profiles/{profile}/config.yaml").read_text())
        assert options["retries"] == 2


def test_every_rule_asks_for_its_own_needs():
    assert len(OWN) > 30
    for rule in OWN.values():
        assert "**needs(mb=" in rule
        assert "    threads: " in rule


def test_needs_grow_with_threads_and_attempts():
    needs = RESOURCES["needs"](mb=1000, mb_per_thread=600, minutes=60)
    assert needs["mem_mb"](None, threads=1, attempt=1) == 2300
    assert needs["mem_mb"](None, threads=8, attempt=3) == 3 * (1000 + 8 * 600 + 700)
    assert needs["runtime"](None, attempt=2) == 120


def test_memory_holds_back_no_job_of_a_machine_of_ones_own(clean):
    """Each of two jobs that ask for more than there is waits until the other has started."""
    both = "touch {wildcards.guest}; until [ -e one ] && [ -e two ]; do sleep 0.1; done"
    command = f"{both}; touch {{output}}"
    clean.feed("--cores", 2, needs=(10**9, 1), command=command, guests=("one", "two"))


def test_what_a_killed_run_left_is_made_anew_without_being_asked(clean):
    """The power is cut once the file is there, with half of what belongs into it."""
    half = "echo half > {output}; kill -9 -- -$(ps -o pgid= $$); sleep 60"
    with pytest.raises(AssertionError):
        clean.feed("--cores", 1, needs=(1, 1), command=half)
    assert (clean.folder / "one.fed").read_text() == "half\n"
    clean.feed("--cores", 1, "--nolock", needs=(1, 1), command="echo all > {output}")
    assert (clean.folder / "one.fed").read_text() == "all\n"


def test_a_scheduler_makes_the_same_bytes(copy, finished):
    """Two jobs of the finished run again, one of them local."""
    tally = "results/egad/grasps/egad_75mm.sampling.parquet"
    for path in (tally, "results/egad/parts/sampling-egad_75mm-0.parquet"):
        (copy.folder / path).unlink()
    copy.make(*LOCAL_TEST, tally)
    assert copy.bytes() == finished.bytes()
    assert [rule for rule, *_ in submitted(copy)] == ["grasp_label"]


def test_a_job_that_fails_is_submitted_again_with_more(clean):
    enough = "[ {resources.mem_mb} -ge 2800 ] && touch {output}"
    clean.feed(*LOCAL_TEST, needs=(600, 2, 100), command=enough)
    assert submitted(clean) == [("hungry", "1", "1400", "2"), ("hungry", "1", "2800", "4")]
