"""The experiment on training sets: what Snakemake would do."""

import re
import shutil
from ast import literal_eval
from collections import Counter
from pathlib import Path

import pytest

from egad_workflow.config_files import read_values

TARGET = "results/training_study/report.html"
STUDY = "studies/training"
SNAKEFILE = f"{STUDY}/Snakefile"
ROOT = Path(__file__).parents[2]
SHARDS = 2
ASKED = {
    "egad": {
        **read_values(ROOT / "config/test.yaml"),
        "shards": SHARDS,
        "render": {"images": 501},
    },
    "sets": ["simple", "complex", "mixed", "given"],
    "seeds": 2,
    "tests": ["egad"],
    "noise": ["none", "stereo"],
    "clutter": ["packed", "pile"],
    "references": ["random"],
    "training_sets": {
        "simple": {"dataset": "egad", "render": {"complexity": [0.0, 0.333], "images": 1001}},
        "complex": {"dataset": "egad", "render": {"complexity": [0.667, 1.0]}},
        "mixed": {"images": ["complex", "simple"], "seeds": 1, "training": {"batch": 4}},
        "given": {"weights": "given.pt"},
    },
}


@pytest.fixture
def clean(clean):
    """A checkout with the study."""
    return with_study(clean)


@pytest.fixture
def configs(clean):
    """A small study; the given weights are there."""
    return configs_in(clean)


@pytest.fixture(scope="module")
def told(kept):
    """The jobs of the study."""
    made = with_study(kept("study"))
    return made.told(TARGET, snakefile=SNAKEFILE, configs=configs_in(made))


def with_study(made):
    shutil.copytree(ROOT / STUDY, made.folder / STUDY, ignore=shutil.ignore_patterns("__py*"))
    return made


def configs_in(made):
    (made.folder / "given.pt").write_bytes(b"weights")
    return [made.overlay("asked.yaml", ASKED)]


def of_rule(told, rule, part=""):
    return [job for job in told if job.rule == rule and part in job.output]


def settings_of(job):
    return literal_eval(job.params["settings"])


def test_every_set_and_network_has_its_jobs_with_its_settings(told):
    planned = Counter(job.rule for job in told)
    assert (planned["render_set"], planned["set_card"]) == (3 + 2, 2)
    networks = 2 * 2 + 1
    assert planned["train_network"] == networks
    detectors = networks + 1 + 1
    assert (planned["study_trial"], planned["study_clutter"]) == (2 * detectors, detectors)
    assert planned["training_study"] == 1
    assert not {"report", "render", "simulated_trial", "clutter"} & set(planned)
    for name, part, count in (("simple", [0.0, 0.333], 3), ("complex", [0.667, 1.0], 2)):
        own = of_rule(told, "render_set", f"images/{name}/")
        assert sorted(job.params["shard"] for job in own) == [
            f"{shard} {count}" for shard in range(count)
        ]
        assert all(settings_of(job)["render"]["complexity"] == part for job in own)
    images = "results/training_study/images"
    for seed in (0, 1):
        (job,) = of_rule(told, "train_network", f"networks/simple/{seed}/")
        assert settings_of(job)["seed"] == seed
        assert job.params["images"] == f"{images}/simple"
    (job,) = of_rule(told, "train_network", "networks/mixed/0/")
    assert job.params["images"] == f"{images}/complex {images}/simple"
    assert settings_of(job)["training"]["batch"] == 4


def test_tests_differ_in_their_noise(told):
    for noise, pixels in (("none", 0.0), ("stereo", 0.1)):
        (job,) = of_rule(told, "study_trial", f"trials/egad/{noise}/mixed-0.parquet")
        assert settings_of(job)["trials"]["depth_noise"] == pixels
    (job,) = of_rule(told, "study_clutter", "clutter/egad/random.parquet")
    assert settings_of(job)["clutter"]["scenes"] == ["packed", "pile"]
    assert settings_of(job)["clutter"]["noise"] == ["none", "stereo"]


def test_another_seed_adds_its_own_jobs_alone(clean, configs):
    before = clean.planned("--snakefile", SNAKEFILE, configs=configs)
    more = clean.overlay("more.yaml", {"seeds": 3})
    after = clean.planned("--snakefile", SNAKEFILE, configs=[*configs, more])
    added = {rule: after[rule] - before[rule] for rule in after if after[rule] != before[rule]}
    assert added == {"train_network": 2, "study_trial": 2 * 2, "study_clutter": 2}


def test_networks_are_detectors_like_any_other(clean, configs):
    trials = "results/egad/trials/egad_75mm"
    one = clean.planned("--snakefile", SNAKEFILE, f"{trials}/complex-1.parquet", configs=configs)
    assert (one["train_network"], one["render_set"], one["simulated_trial"]) == (1, 2, SHARDS)
    given = clean.planned("--snakefile", SNAKEFILE, f"{trials}/given-0.parquet", configs=configs)
    assert "train_network" not in given
    assert given["simulated_trial"] == SHARDS


@pytest.mark.parametrize(
    "path",
    [f"{STUDY}/study.html.j2", f"{STUDY}/study_charts.py", "egad/report/templates/page.css"],
)
def test_the_page_alone_is_made_again_for_what_draws_it(clean, configs, told, path):
    if path.startswith("egad/"):
        clean.take_library()
    text = (clean.folder / path).read_text()
    changed = re.sub(r"<h1>|^body|\b9\b", "0", text, count=1, flags=re.MULTILINE)
    assert changed != text
    (clean.folder / path).write_text(changed)
    again = clean.told(TARGET, snakefile=SNAKEFILE, configs=configs)
    codes = [{job.output: job.params.get("code") for job in jobs} for jobs in (told, again)]
    assert [name for name in codes[0] if codes[0][name] != codes[1][name]] == [
        of_rule(told, "training_study")[0].output
    ]


def test_a_configuration_must_be_named(clean):
    status, found = clean.snakemake("--dry-run", "--snakefile", SNAKEFILE, configs=())
    assert status != 0
    assert "A configuration is needed" in found


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"training_sets": {"given": {"weights": "lost.pt"}}},
            "The detector given-0 cannot be used: detectors: no such file: lost.pt",
        ),
        ({"sets": []}, "sets: List should have at least 1 item"),
        ({"tests": []}, "tests: List should have at least 1 item"),
        ({"egad": {"trials": {"attemps": 3}}}, "egad.trials.attemps: unknown key; did you mean"),
    ],
    ids=str,
)
def test_a_mistake_stops_the_run_with_a_sentence(clean, configs, change, said):
    wrong = clean.overlay("wrong.yaml", change)
    status, found = clean.snakemake(
        "--dry-run", "--snakefile", SNAKEFILE, configs=[*configs, wrong]
    )
    assert status != 0
    assert said in found
    assert "Traceback (most" not in found
