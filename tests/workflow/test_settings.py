import json

import pytest
from pydantic import ValidationError

from egad._util.parameters import ParameterGroup, Parameters
from egad.bench import NaiveGraspParameters
from egad.evolution import EvolutionParameters
from egad.exchange import FORMATS, RescaleMeshes, settings_class
from egad.grippers import Gripper
from egad.measures import MeasureParameters, SizeEffectParameters
from egad_workflow.settings import Settings, select


def sections():
    """All groups of settings, and the models of the entries of tables."""
    return [
        model for model in Parameters.__subclasses__() if model not in (Settings, ParameterGroup)
    ]


@pytest.mark.parametrize("model", sections(), ids=lambda model: model.__name__)
def test_every_setting_says_what_it_means(model):
    assert model.__doc__
    for name, field in model.model_fields.items():
        assert field.description, name
        if field.annotation is float and name.endswith(("length", "width", "height", "spacing")):
            assert "metres" in field.description, name


def test_defaults_are_valid_and_survive_json():
    text = Settings().model_dump_json()
    assert Settings.model_validate_json(text, strict=True) == Settings()


def test_settings_cannot_be_changed():
    with pytest.raises(ValidationError):
        Settings().seed = 1
    with pytest.raises(ValidationError):
        Settings().evolution.population = 1


@pytest.mark.parametrize(
    "wrong",
    [
        {"datasets": {"egad": {"source": "evolved", "units": "m"}}},
        {"datasets": {"egad": {"source": "primitives", "objects": 100_001}}},
        {"datasets": {"egad": {"source": "archive", "archive": "released", "objects": 5}}},
        {"space": {"graspability_range": [0.004, 0.0005]}},
        {"limits": {"aspect_ratio": [3, 2]}},
        {"limits": {"box_fraction": [0.2, 1.2]}},
        {"envelope": {"kind": "mesh"}},
        {"keep_solid": {"kind": "box", "mesh": "handle.stl"}},
        {"hole": {"kind": "box", "size": [0, 1, 1]}},
        {"hole": {"kind": "box", "center": [0, 0.6, 0]}},
        {"symmetry": {"mirror": ["w"]}},
        {"measures": {"complexity": "measures.py"}},
        {"render": {"complexity": [0.5, 0.5]}},
        {"render": {"validation": 0.5, "test": 0.5}},
        {"cameras": {"mine": {"focal": [0, 400], "distance": [0.6, 0.6], "tilt": [0, 0]}}},
    ],
)
def test_settings_that_contradict_each_other_are_refused(wrong):
    with pytest.raises(ValidationError):
        Settings.model_validate(wrong)


def test_every_section_is_read_by_some_stage():
    """A setting that no stage gets would change nothing, in silence."""
    models = [*stage_models(ParameterGroup), *map(settings_class, FORMATS)]
    ours = [model for model in models if model.__module__.startswith("egad.")]
    read = {name for model in ours for name in model.model_fields}
    of_the_workflow = {"shards", "datasets", "targets", "schedule", "keep_going"}
    tables = {"grippers", "cameras", "detectors"}
    entries = {"gripper", "map_gripper", "camera", "detector", "density", "labels", "breeding"}
    assert set(Settings.model_fields) - of_the_workflow - tables == read - entries


def test_naive_grasps_do_not_depend_on_how_many_labels_are_simulated():
    few, many = (
        select(Settings(simulated_label={"grasps": count}), NaiveGraspParameters, "panda")
        for count in (5, 50)
    )
    assert few == many


def stage_models(base):
    models = [model for child in base.__subclasses__() for model in stage_models(child)]
    return [base, *models]


@pytest.mark.parametrize(
    ("evaluations", "schedule", "epochs", "of_an_epoch"),
    [
        (2400, {}, 1, 2400),
        (200_000, {}, 20, 10_000),
        (210_000, {}, 21, 10_000),  # extends a finished run
        (200_000, {"islands": 4}, 5, 10_000),
        (800, {"islands": 2, "epochs": 2}, 2, 200),
        (801, {"islands": 2, "epochs": 2}, 2, 300),
        (10**8, {}, 200, 500_000),
    ],
)
def test_islands_and_epochs_share_the_evaluations(evaluations, schedule, epochs, of_an_epoch):
    settings = Settings(evolution={"evaluations": evaluations}, schedule=schedule)
    assert settings.epochs == epochs
    assert select(settings, EvolutionParameters).evolution.evaluations == of_an_epoch


def test_a_stage_gets_the_gripper_by_name_and_else_that_of_the_graspability():
    settings = Settings()
    assert select(settings, RescaleMeshes, "panda").gripper == settings.grippers["panda"]
    assert (
        select(settings, EvolutionParameters).gripper
        == settings.grippers[settings.graspability.gripper]
    )


def test_what_a_stage_gets_is_what_the_configuration_says():
    settings = Settings.model_validate({"evolution": {"population": 3}, "seed": 9})
    chosen = json.loads(select(settings, EvolutionParameters).model_dump_json())
    assert (chosen["evolution"]["population"], chosen["seed"]) == (3, 9)
    assert "trials" not in chosen
    assert EvolutionParameters.model_validate(chosen) == select(settings, EvolutionParameters)


def test_perturbed_copies_count_for_cups_and_for_the_robust_metric_alone():
    settings = Settings.model_validate({"robust": {"samples": 7}})
    by_metric = Settings.model_validate(
        {"robust": {"samples": 7}, "graspability": {"metric": "robust"}}
    )
    for stage in (MeasureParameters, SizeEffectParameters):
        assert select(settings, stage, "panda").robust is None
        assert select(settings, stage, "cup_30mm").robust.samples == 7
    assert select(by_metric, MeasureParameters, "panda").robust.samples == 7
    assert select(by_metric, SizeEffectParameters, "panda").robust is None


def test_friction_of_a_gripper_is_that_of_its_pads_if_none_is_given() -> None:
    frictions = [
        Gripper.model_validate({"opening": 0.08, **own}).pad.friction
        for own in ({}, {"pads": "bare"}, {"pads": "bare", "friction": 0.6})
    ]
    assert frictions == [0.8, 0.4, 0.6]
