"""The experiment on training sets: what Snakemake would do."""

import pytest

TARGET = "results/training_study/report.html"
SHARDS = 2
ASKED = {
    "shards": SHARDS,
    "training_study": {
        "sets": ["simple", "complex", "given"],
        "seeds": 2,
        "tests": ["egad"],
        "references": ["random"],
    },
    "training_sets": {"given": {"weights": "given.pt"}},
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
    assert (planned["render_set"], planned["set_card"]) == (2 * 2, 2)
    assert planned["train_network"] == 2 * 2
    detectors = 2 * 2 + 1 + 1
    assert planned["simulated_trial"] == detectors * SHARDS
    assert planned["join_trials"] == detectors
    assert planned["training_study"] == 1
    assert "report" not in planned
    assert "render" not in planned
    lines = [line for line in said.splitlines() if "egad render" in line]
    for name, part in (("simple", "[0.0,0.333]"), ("complex", "[0.667,1.0]")):
        own = [line for line in lines if f"images/{name}/" in line]
        assert len(own) == 2
        assert all(f'"complexity":{part}' in line for line in own)
    for seed in (0, 1):
        (line,) = [each for each in said.splitlines() if f"networks/simple/{seed} " in each]
        assert f'"seed":{seed},' in line
        assert "results/training_study/images/simple" in line


def test_another_seed_adds_its_own_jobs_alone(clean, configs):
    before = clean.planned(TARGET, configs=configs)
    more = clean.overlay("more.yaml", {"training_study": {"seeds": 3}})
    after = clean.planned(TARGET, configs=[*configs, more])
    added = {rule: after[rule] - before[rule] for rule in after if after[rule] != before[rule]}
    assert added == {"train_network": 2, "simulated_trial": 2 * SHARDS, "join_trials": 2}


def test_networks_are_tried_one_by_one_and_without_the_others(clean, configs):
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
