"""The networks that a configuration asks for."""

import pytest

from egad.errors import UserError
from egad.perception.parameters import RenderParameters
from egad.pipeline.code_version import imported
from egad.pipeline.config import Settings
from egad.pipeline.config.check import check
from egad.pipeline.config.stage_settings import TrainingStudyReport, select
from egad.pipeline.config.training_study import Network, networks_of, settings_for, with_networks
from egad.pipeline.stages.simulate import SimulatedTrials
from egad.pipeline.stages.train import TrainNetwork

ASKED = {
    "training_study": {"sets": ["complex", "given"], "seeds": 2, "tests": ["egad"]},
    "training_sets": {
        "complex": {
            "dataset": "egad",
            "complexity": [0.5, 1.0],
            "subset": 0.4,
            "hold_out": False,
        },
        "given": {"weights": "given.pt"},
    },
}


@pytest.fixture(scope="module")
def asked():
    return check(ASKED)


def test_nothing_is_asked_for_by_default():
    assert networks_of(Settings()) == []
    assert with_networks(Settings()) == Settings()


def test_a_set_has_a_network_a_seed_and_given_weights_one(asked):
    names = [network.name for network in networks_of(asked)]
    assert names == ["complex-0", "complex-1", "given-0"]


def test_networks_are_detectors_like_any_other(asked):
    tried = with_networks(asked)
    assert set(tried.detectors) == {*asked.detectors, "complex-0", "complex-1", "given-0"}
    detector = select(tried, SimulatedTrials, detector="complex-1").detector
    assert detector.detector == "ggcnn"
    assert detector.weights == "results/training_study/networks/complex/1/weights.safetensors"
    assert tried.detectors["given-0"].weights == "given.pt"


def test_the_trials_of_all_networks_have_the_same_seed(asked):
    """And so the same drops: they follow from the seed, the object and the attempt."""
    tried = with_networks(asked)
    parts = [
        select(tried, SimulatedTrials, detector=network.name).model_dump(exclude={"detector"})
        for network in networks_of(asked)
    ]
    assert all(part == parts[0] for part in parts)


def test_a_set_decides_what_is_rendered_and_a_seed_the_training_alone(asked):
    first, second = (settings_for(asked, Network("complex", seed)) for seed in (0, 1))
    images = select(first, RenderParameters, "egad_75mm")
    chosen = images.render
    assert (chosen.complexity, chosen.subset, chosen.hold_out) == ((0.5, 1.0), 0.4, False)
    assert images.render.images == asked.render.images
    assert images.seed == asked.seed
    one, other = (select(whole, TrainNetwork) for whole in (first, second))
    assert (one.seed, other.seed) == (0, 1)
    assert one.training == other.training == asked.training


def test_the_report_reads_the_sets_that_are_compared(asked):
    assert set(select(asked, TrainingStudyReport).training_sets) == {"complex", "given"}


def test_a_page_is_no_reason_to_train_again():
    """The workflow trains again for the code of these modules."""
    for module in ("egad.learning.training", "egad.learning.weights"):
        assert not [name for name in imported(module) if name.startswith("egad.report")]


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


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (
            {"training_study": {"sets": ["lost"]}},
            "training_study.sets: 'lost' is not defined; known: ",
        ),
        ({"training_study": {"tests": ["lost"]}}, "training_study.tests: 'lost' is not defined"),
        (
            {"training_study": {"references": ["lost"]}},
            "training_study.references: 'lost' is not defined",
        ),
        (
            {"training_study": {"sets": ["a"]}, "training_sets": {"a": {"dataset": "lost"}}},
            "training_sets.a.dataset: 'lost' is not defined; known: egad",
        ),
        (
            {"training_sets": {"a": {"dataset": "egad", "complexity": [0.5, 0.5]}}},
            "training_sets.a: complexity must go from low to high, got 0.5 to 0.5",
        ),
        ({"training_sets": {"a": {}}}, "training_sets.a: a training set needs either `dataset`"),
        (
            {"training_sets": {"a": {"dataset": "egad", "weights": "w"}}},
            "training_sets.a: a training set needs either `dataset` or `weights`",
        ),
        (
            {"training_sets": {"a": {"weights": "w", "complexity": [0, 0.5]}}},
            "training_sets.a: a training set with `weights` takes no `complexity`, `subset`",
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
