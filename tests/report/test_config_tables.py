import yaml

from egad_workflow.check import check
from egad_workflow.config_tables import changed_parameters, settings_text
from egad_workflow.settings import Settings


def test_changed_keys_and_entries_are_named_in_full():
    settings = Settings.model_validate(
        {
            "seed": 3,
            "select_eval": {"gripper": "yumi"},
            "datasets": {"parts": {"source": "meshes", "folder": "parts", "units": "mm"}},
        }
    )
    shown = {item.name: (item.value, item.default) for item in changed_parameters(settings)}
    assert shown == {
        "seed": ("3", "0"),
        "select_eval.gripper": ("yumi", "nothing"),
        "datasets.parts": ("source: meshes, folder: parts, units: mm", ""),
    }
    assert changed_parameters(Settings()) == []


def test_the_text_is_the_whole_configuration():
    settings = Settings(trials={"errors": {"positioning": 0.002}}, seed=3)
    values = yaml.safe_load(settings_text(settings))
    assert check(values) == settings
    assert values["space"]["graspability_range"] == [0.0005, 0.004]
    assert values["grippers"]["panda"]["opening"] == 0.08
