"""The networks that a configuration of the study asks for, and mistakes in it."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from study import (
    Network,
    PageSettings,
    page_settings,
    read_study,
    settings_for,
    settings_of_tests,
    study_of,
)

from egad.bench import ClearedTables, SimulatedTrials
from egad.errors import UserError
from egad.learning import TrainNetwork
from egad.learning.images import RenderParameters
from egad_workflow.check import check
from egad_workflow.code_version import imported_modules
from egad_workflow.settings import select

STUDY = Path(__file__).parent
ASKED = {
    "sets": ["complex", "longer", "given"],
    "seeds": 2,
    "tests": ["egad"],
    "noise": ["none", "stereo"],
    "clutter": ["pile"],
    "rounds": 3,
    "training_sets": {
        "complex": {
            "dataset": "egad",
            "render": {"complexity": [0.5, 1.0], "subset": 0.4, "hold_out": False},
            "image_noise": {"holes": True},
        },
        "longer": {"images": ["complex"], "seeds": 1, "training": {"examples": 99}},
        "given": {"weights": "given.pt"},
    },
}


@pytest.fixture(scope="module")
def asked():
    return study_of(ASKED)


def test_the_file_describes_a_study():
    found = read_study(STUDY / "study.yaml")
    names = [network.name for network in found.plan.networks]
    assert len(names) == len(set(names)) > len(found.plan.sets)
    assert names == list(found.settings.detectors)[-len(names) :]


def test_the_workflow_gets_the_settings_as_they_were_written(asked):
    """Only what was given is checked for unknown names, so defaults must stay unsaid."""
    assert check(asked.workflow_config) == asked.settings
    assert set(asked.workflow_config) == {"detectors"}
    own = {"source": "meshes", "folder": ".", "units": "m"}
    given = {"datasets": {"own": own}, "targets": {"datasets": ["own"]}}
    sets = {"a": {"dataset": "own"}}
    found = study_of(plan(tests=["own"], training_sets=sets, egad=given))
    assert check(found.workflow_config) == found.settings
    assert {name: found.workflow_config[name] for name in given} == given


def test_settings_of_the_workflow_can_be_written(tmp_path, asked):
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump(ASKED))
    said = subprocess.run(
        [sys.executable, STUDY / "study.py", path], check=True, capture_output=True, text=True
    ).stdout
    assert check(yaml.safe_load(said)) == asked.settings


def test_a_set_has_a_network_a_seed_or_as_many_as_it_says_and_given_weights_one(asked):
    names = [network.name for network in asked.plan.networks]
    assert names == ["complex-0", "complex-1", "longer-0", "given-0"]


def test_networks_are_detectors_like_any_other(asked):
    tried = asked.settings
    names = {network.name for network in asked.plan.networks}
    assert set(tried.detectors) == {*check({}).detectors, *names}
    detector = select(tried, SimulatedTrials, detector="complex-1").detector
    assert detector.detector == "ggcnn"
    assert detector.weights == "results/training_study/networks/complex/1/weights.safetensors"
    assert tried.detectors["given-0"].weights == "given.pt"


def test_the_tests_of_all_networks_have_the_same_seed(asked):
    """And so the same drops: they follow from the seed, the object and the attempt."""
    tried = settings_of_tests(asked)
    for kind in (SimulatedTrials, ClearedTables):
        parts = [
            select(tried, kind, detector=network.name).model_dump(exclude={"detector"})
            for network in asked.plan.networks
        ]
        assert all(part == parts[0] for part in parts)


def test_tests_differ_in_the_noise_alone_and_clutter_has_all_of_it(asked):
    without, noisy = (settings_of_tests(asked, noise) for noise in ("none", "stereo"))
    assert (without.trials.depth_noise, noisy.trials.depth_noise) == (0.0, 0.1)
    assert noisy.trials.model_copy(update={"depth_noise": 0.0}) == without.trials
    tables = select(noisy, ClearedTables, "panda", "random").clutter
    assert (tables.scenes, tables.noise, tables.rounds) == (("pile",), ("none", "stereo"), 3)
    assert (
        ClearedTables.model_validate_json(
            select(noisy, ClearedTables, "panda", "random").model_dump_json(), strict=True
        ).clutter
        == tables
    )


def test_a_set_decides_what_is_rendered_and_a_seed_the_training_alone(asked):
    first, second = (settings_for(asked, Network("complex", seed)) for seed in (0, 1))
    images = select(first, RenderParameters, "egad_75mm")
    chosen = images.render
    assert (chosen.complexity, chosen.subset, chosen.hold_out) == ((0.5, 1.0), 0.4, False)
    assert images.render.images == asked.settings.render.images
    assert images.image_noise == asked.settings.image_noise.model_copy(update={"holes": True})
    assert images.seed == asked.settings.seed
    one, other = (select(whole, TrainNetwork) for whole in (first, second))
    assert (one.seed, other.seed) == (0, 1)
    assert one.training == other.training == asked.settings.training


def test_sets_may_share_images_and_be_trained_in_another_way(asked):
    plan = asked.plan
    assert plan.image_sets("complex") == plan.image_sets("longer") == ["complex"]
    assert plan.image_sets("given") == []
    training = select(settings_for(asked, Network("longer", 0)), TrainNetwork).training
    assert training == asked.settings.training.model_copy(update={"examples": 99})


def test_settings_of_a_set_survive_their_way_to_the_stage(asked):
    """The workflow hands them over as JSON; what a set does not name stays unnamed."""
    page = page_settings(asked)
    assert PageSettings.model_validate_json(page.model_dump_json(), strict=True) == page
    assert set(page.plan.training_sets["complex"].render) == {"complexity", "subset", "hold_out"}


def test_the_page_reads_the_sets_that_are_compared_and_their_images():
    settings = page_settings(study_of({**ASKED, "sets": ["longer"]}))
    assert set(settings.plan.training_sets) == {"longer", "complex"}


def test_a_page_is_no_reason_to_train_again():
    """The workflow trains again for the code of these modules."""
    for module in ("egad.learning.training", "egad.detectors.weights"):
        assert not [name for name in imported_modules(module) if name.startswith("egad.report")]


def test_a_detector_with_the_name_of_a_network_is_refused():
    taken = {"complex-1": {"detector": "random"}}
    own = {"detectors": taken, "targets": {"detectors": ["complex-1"]}}
    with pytest.raises(UserError, match=r"detectors.complex-1: .* training set complex"):
        study_of({**ASKED, "egad": own})


def plan(**keys):
    """A study of a set of the evolved objects, and of others that it may name."""
    sets = {"a": {"dataset": "egad"}, "simple": {"dataset": "egad"}}
    return {"sets": ["a"], "tests": ["egad"], "training_sets": sets, **keys}


def of_set(**keys):
    sets = {"a": keys, "simple": {"dataset": "egad"}}
    return plan(training_sets=sets)


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (plan(sets=["lost"]), "sets: 'lost' is not defined; known: "),
        (plan(tests=["lost"]), "tests: 'lost' is not defined"),
        (
            plan(references=["lost"]),
            "references: 'lost' is not defined",
        ),
        (
            plan(comparisons=[["a", "b"]]),
            "comparisons: 'b' is not defined; known: a",
        ),
        (
            plan(image_curve=["a", "b"]),
            "image_curve: 'b' is not defined; known: a",
        ),
        (
            {**of_set(weights="w.pt"), "object_curve": ["a"]},
            "object_curve: 'a' is not defined; known: ",
        ),
        (
            {**of_set(dataset="egad", training={"positive": "simulated"})},
            "training_sets.a.training.positive: simulated needs images with render.simulate",
        ),
        (
            plan(noise=["gamma"]),
            "noise.0: Input should be 'none' or 'stereo'",
        ),
        (of_set(dataset="lost"), "training_sets.a.dataset: 'lost' is not defined; known: egad"),
        (of_set(images=["lost"]), "training_sets.a.images: 'lost' is not defined"),
        (of_set(images=["a"]), "training_sets.a.images: 'a' is not defined; known: "),
        (
            of_set(dataset="egad", render={"complexity": [0.5, 0.5]}),
            "training_sets.a.render: complexity must go from low to high, got 0.5 to 0.5",
        ),
        (
            of_set(dataset="egad", render={"validation": 0.95}),
            "training_sets.a.render: validation and test together must be less than 1",
        ),
        (
            of_set(dataset="egad", render={"camera": "lost"}),
            "training_sets.a.render.camera: 'lost' is not defined; known: d435",
        ),
        (
            of_set(dataset="egad", render={"subsett": 0.5}),
            "training_sets.a.render.subsett: Extra inputs are not permitted",
        ),
        (
            of_set(dataset="egad", training={"batch": 0}),
            "training_sets.a.training.batch: Input should be greater than or equal to 1",
        ),
        (
            of_set(dataset="egad", image_noise={"holes": "yes"}),
            "training_sets.a.image_noise.holes: Input should be a valid boolean",
        ),
        (
            of_set(dataset="egad", render=3),
            "training_sets.a.render: Input should be an object",
        ),
        (of_set(), "training_sets.a: a training set needs one of `dataset`, `images` and"),
        (of_set(dataset="egad", weights="w"), "training_sets.a: a training set needs one of"),
        (
            of_set(weights="w", training={"batch": 4}),
            "training_sets.a: a training set with `weights` takes no `training`",
        ),
        (
            of_set(images=["simple"], render={"subset": 0.5}),
            "training_sets.a: a training set with `images` takes no `render`",
        ),
        (plan(seeds=0), "seeds: Input should be greater than or equal to 1"),
        (plan(seedss=3), "seedss: Extra inputs are not permitted"),
        (
            plan(references=["random", "a"], egad={"detectors": {"a": {"detector": "random"}}}),
            "'a' is a training set, too",
        ),
        (
            plan(
                tests=["training_study"],
                training_sets={"a": {"dataset": "training_study"}},
                egad={
                    "datasets": {"training_study": {"source": "evolved"}},
                    "targets": {"datasets": []},
                },
            ),
            "egad.datasets.training_study: that is the folder of the study",
        ),
    ],
)
def test_a_mistake_is_said_in_a_line(config, said):
    with pytest.raises(UserError) as error:
        study_of(config)
    (line,) = str(error.value).splitlines()
    assert said in line


def test_mistakes_of_the_study_and_of_the_workflow_are_said_at_once():
    with pytest.raises(UserError) as error:
        study_of({**plan(), "seeds": 0, "rounds": "3", "egad": {"sed": 1, "shards": 0}})
    lines = str(error.value).splitlines()
    places = {line.partition(":")[0] for line in lines}
    assert places == {"egad.sed", "egad.shards", "seeds", "rounds"}


def test_sets_that_are_not_compared_may_be_of_a_dataset_that_is_gone():
    sets = {**plan()["training_sets"], "old": {"dataset": "lost"}}
    assert study_of(plan(training_sets=sets)).plan.sets == ["a"]
