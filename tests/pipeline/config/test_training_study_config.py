"""The networks that a configuration asks for."""

import pytest

from egad.errors import UserError
from egad.perception.parameters import RenderParameters
from egad.pipeline.code_version import used_names
from egad.pipeline.config import Settings
from egad.pipeline.config.check import check
from egad.pipeline.config.stage_settings import TrainingStudyReport, select
from egad.pipeline.config.training_study import (
    Network,
    image_sets,
    networks_of,
    settings_for,
    settings_of_tests,
    with_networks,
)
from egad.pipeline.stages.clutter import ClearedTables
from egad.pipeline.stages.simulate import SimulatedTrials
from egad.pipeline.stages.train import TrainNetwork

ASKED = {
    "training_study": {
        "sets": ["complex", "longer", "given"],
        "seeds": 2,
        "tests": ["egad"],
        "noise": ["none", "stereo"],
        "clutter": ["pile"],
        "rounds": 3,
    },
    "training_sets": {
        "complex": {
            "dataset": "egad",
            "render": {"complexity": [0.5, 1.0], "subset": 0.4, "hold_out": False},
            "image_noise": {"holes": True},
        },
        "longer": {"images": ["complex"], "seeds": 1, "training": {"images": 99}},
        "given": {"weights": "given.pt"},
    },
}


@pytest.fixture(scope="module")
def asked():
    return check(ASKED)


def test_nothing_is_asked_for_by_default():
    assert networks_of(Settings()) == []
    assert with_networks(Settings()) == Settings()


def test_a_set_has_a_network_a_seed_or_as_many_as_it_says_and_given_weights_one(asked):
    names = [network.name for network in networks_of(asked)]
    assert names == ["complex-0", "complex-1", "longer-0", "given-0"]


def test_networks_are_detectors_like_any_other(asked):
    tried = with_networks(asked)
    names = {network.name for network in networks_of(asked)}
    assert set(tried.detectors) == {*asked.detectors, *names}
    detector = select(tried, SimulatedTrials, detector="complex-1").detector
    assert detector.detector == "ggcnn"
    assert detector.weights == "results/training_study/networks/complex/1/weights.safetensors"
    assert tried.detectors["given-0"].weights == "given.pt"


def test_the_tests_of_all_networks_have_the_same_seed(asked):
    """And so the same drops: they follow from the seed, the object and the attempt."""
    tried = settings_of_tests(with_networks(asked))
    for kind in (SimulatedTrials, ClearedTables):
        parts = [
            select(tried, kind, detector=network.name).model_dump(exclude={"detector"})
            for network in networks_of(asked)
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
    assert images.render.images == asked.render.images
    assert images.image_noise == asked.image_noise.model_copy(update={"holes": True})
    assert images.seed == asked.seed
    one, other = (select(whole, TrainNetwork) for whole in (first, second))
    assert (one.seed, other.seed) == (0, 1)
    assert one.training == other.training == asked.training


def test_sets_may_share_images_and_be_trained_in_another_way(asked):
    sets = asked.training_sets
    assert image_sets("complex", sets) == image_sets("longer", sets) == ["complex"]
    assert image_sets("given", sets) == []
    plan = select(settings_for(asked, Network("longer", 0)), TrainNetwork).training
    assert plan == asked.training.model_copy(update={"images": 99})


def test_settings_of_a_set_survive_their_way_to_the_stage(asked):
    """The workflow hands them over as JSON; what a set does not name stays unnamed."""
    report = select(asked, TrainingStudyReport)
    assert TrainingStudyReport.model_validate_json(report.model_dump_json(), strict=True) == report
    assert set(report.training_sets["complex"].render) == {"complexity", "subset", "hold_out"}


def test_the_report_reads_the_sets_that_are_compared_and_their_images():
    alone = {**ASKED["training_study"], "sets": ["longer"]}
    settings = check({**ASKED, "training_study": alone})
    assert set(select(settings, TrainingStudyReport).training_sets) == {"longer", "complex"}


def test_a_page_is_no_reason_to_train_again():
    """The workflow trains again for the code of these modules."""
    for module in ("egad.learning.training", "egad.learning.weights"):
        assert not [name for name, _ in used_names(module) if name.startswith("egad.report")]


def test_a_detector_with_the_name_of_a_network_is_refused():
    taken = check(
        {
            **ASKED,
            "detectors": {"complex-1": {"detector": "random"}},
            "targets": {"detectors": ["complex-1"]},
        }
    )
    with pytest.raises(UserError, match=r"detectors.complex-1: .* training set complex"):
        with_networks(taken)


def study(**keys):
    return {"training_study": {"sets": ["a"], **keys}}


def of_set(**keys):
    return {**study(), "training_sets": {"a": keys}}


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (study(sets=["lost"]), "training_study.sets: 'lost' is not defined; known: "),
        ({"training_study": {"tests": ["lost"]}}, "training_study.tests: 'lost' is not defined"),
        (
            {"training_study": {"references": ["lost"]}},
            "training_study.references: 'lost' is not defined",
        ),
        (
            {**of_set(dataset="egad"), **study(comparisons=[["a", "b"]])},
            "training_study.comparisons: 'b' is not defined; known: a",
        ),
        (
            {**of_set(dataset="egad"), **study(image_curve=["a", "b"])},
            "training_study.image_curve: 'b' is not defined; known: a",
        ),
        (
            {**of_set(weights="w.pt"), **study(object_curve=["a"])},
            "training_study.object_curve: 'a' is not defined; known: ",
        ),
        (
            {**of_set(dataset="egad", training={"positive": "simulated"})},
            "training_sets.a.training.positive: simulated needs images with render.simulate",
        ),
        (
            {"training_study": {"noise": ["gamma"]}},
            'training_study.noise.0: "gamma" is not allowed; allowed: none or stereo',
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
            "training_sets.a.render.subsett: unknown key; did you mean "
            "training_sets.a.render.subset?",
        ),
        (
            of_set(dataset="egad", training={"batch": 0}),
            "training_sets.a.training.batch: 0 is not allowed; allowed: a whole number, at least 1",
        ),
        (
            of_set(dataset="egad", image_noise={"holes": "yes"}),
            'training_sets.a.image_noise.holes: "yes" is not allowed; allowed: true or false',
        ),
        (
            of_set(dataset="egad", render=3),
            "training_sets.a.render: 3 is not allowed; allowed: a section with the keys images,",
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
        ({"training_study": {"seeds": 0}}, "training_study.seeds: 0 is not allowed"),
        (
            {"datasets": {"training_study": {"source": "evolved"}}, "targets": {"datasets": []}},
            "datasets.training_study: the name is reserved for the folder of the study",
        ),
    ],
)
def test_a_mistake_is_said_in_a_line(config, said):
    with pytest.raises(UserError) as error:
        check(config)
    (line,) = str(error.value).splitlines()
    assert said in line


def test_sets_that_are_not_compared_may_be_of_a_dataset_that_is_gone():
    own = {"datasets": {"own": {"source": "meshes", "folder": ".", "units": "m"}}}
    assert check({**own, "targets": {"datasets": ["own"]}}).training_study.sets == []
