"""The experiment on training sets: what Snakemake would do."""

import pytest

TARGET = "results/training_study/report.html"
SHARDS = 2
ASKED = {
    "shards": SHARDS,
    "training_study": {
        "sets": ["simple", "complex", "mixed", "given"],
        "seeds": 2,
        "tests": ["egad"],
        "noise": ["none", "stereo"],
        "clutter": ["packed", "pile"],
        "references": ["random"],
    },
    "training_sets": {
        "simple": {"render": {"images": 1001}},
        "mixed": {"images": ["complex", "simple"], "seeds": 1, "training": {"batch": 4}},
        "given": {"weights": "given.pt"},
    },
    "render": {"images": 501},
}


@pytest.fixture
def configs(clean):
    """The experiment laid over the small configuration; the given weights are there."""
    (clean.folder / "given.pt").write_bytes(b"weights")
    return ["config/test.yaml", clean.overlay("asked.yaml", ASKED)]


def test_every_set_and_network_has_its_jobs_with_its_settings(clean, configs):
    said = clean.make("--dry-run", "--printshellcmds", TARGET, configs=configs)
    planned = clean.jobs(said)
    assert (planned["render_set"], planned["set_card"]) == (3 + 2, 2)
    networks = 2 * 2 + 1
    assert planned["train_network"] == networks
    detectors = networks + 1 + 1
    assert (planned["study_trial"], planned["study_clutter"]) == (2 * detectors, detectors)
    assert planned["training_study"] == 1
    assert not {"report", "render", "simulated_trial", "clutter"} & set(planned)
    lines = said.splitlines()
    rendered = [line for line in lines if "egad render" in line]
    for name, part, count in (("simple", "[0.0,0.333]", 3), ("complex", "[0.667,1.0]", 2)):
        own = [line for line in rendered if f"images/{name}/" in line]
        assert len(own) == count
        assert all(f'"complexity":{part}' in line for line in own)
        assert all(f"--shards {count}" in line for line in own)
    for seed in (0, 1):
        (line,) = [each for each in lines if f"networks/simple/{seed} " in each]
        assert f'"seed":{seed},' in line
        assert "results/training_study/images/simple " in line
    (line,) = [each for each in lines if "networks/mixed/0 " in each]
    assert "images/complex results/training_study/images/simple" in line
    assert '"batch":4' in line


def test_tests_differ_in_their_noise(clean, configs):
    said = clean.make("--dry-run", "--printshellcmds", TARGET, configs=configs).splitlines()
    for noise, pixels in (("none", "0.0"), ("stereo", "0.1")):
        (line,) = [
            each
            for each in said
            if f"trials/egad/{noise}/mixed-0.parquet" in each and "egad simulate" in each
        ]
        assert f'"depth_noise":{pixels}' in line
    (line,) = [
        each for each in said if "clutter/egad/random.parquet" in each and "egad clutter" in each
    ]
    assert '"scenes":["packed","pile"]' in line
    assert '"noise":["none","stereo"]' in line


def test_another_seed_adds_its_own_jobs_alone(clean, configs):
    before = clean.planned(TARGET, configs=configs)
    more = clean.overlay("more.yaml", {"training_study": {"seeds": 3}})
    after = clean.planned(TARGET, configs=[*configs, more])
    added = {rule: after[rule] - before[rule] for rule in after if after[rule] != before[rule]}
    assert added == {"train_network": 2, "study_trial": 2 * 2, "study_clutter": 2}


def test_networks_are_detectors_like_any_other(clean, configs):
    trials = "results/egad/trials/egad_75mm"
    one = clean.planned(f"{trials}/complex-1.parquet", configs=configs)
    assert (one["train_network"], one["render_set"], one["simulated_trial"]) == (1, 2, SHARDS)
    given = clean.planned(f"{trials}/given-0.parquet", configs=configs)
    assert "train_network" not in given
    assert given["simulated_trial"] == SHARDS


def test_nothing_of_it_is_made_unless_it_is_named(clean, configs):
    assert not {"render_set", "train_network", "training_study"} & set(
        clean.planned(configs=configs)
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"training_sets": {"given": {"weights": "lost.pt"}}},
            "The detector given-0 cannot be used: detectors: no such file: lost.pt",
        ),
        ({"training_study": {"sets": []}}, "training_study.sets names no training set"),
        ({"training_study": {"tests": []}}, "training_study.tests names no dataset"),
    ],
    ids=str,
)
def test_a_mistake_stops_the_run_with_a_sentence(clean, configs, change, said):
    wrong = clean.overlay("wrong.yaml", change)
    status, found = clean.snakemake("--dry-run", TARGET, configs=[*configs, wrong])
    assert status != 0
    assert said in found
    assert "Traceback (most" not in found
