from egad.config import Settings
from egad.sim import TrialProtocol
from egad.workflow.config_tables import changed_parameters, entry_tables, parameter_tables


def test_only_changed_values_show_their_default():
    settings = Settings(trials=TrialProtocol(attempts=3))
    shown = {
        (table.name, item.name): item
        for table in parameter_tables(settings)
        for item in table.parameters
    }
    assert shown["trials", "attempts"].value == "3"
    assert shown["trials", "attempts"].default == str(TrialProtocol().attempts)
    assert [item.name for item in shown.values() if item.default] == ["attempts"]


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


def test_values_keep_all_their_digits():
    tables = {table.name: table for table in parameter_tables(Settings())}
    values = {item.name: item.value for item in tables["space"].parameters}
    assert values["graspability_range"] == "0.0005, 0.004"
    assert tables["schedule"].summary.startswith("How evolution is divided into jobs")


def test_errors_of_a_cell_have_their_name_or_their_values():
    def shown(errors):
        tables = parameter_tables(Settings(trials={"errors": errors}))
        (table,) = (each for each in tables if each.name == "trials")
        return next(each for each in table.parameters if each.name == "errors").value

    assert (shown("none"), shown("typical")) == ("none", "typical")
    assert "positioning=0.002" in shown({"positioning": 0.002})


def test_grippers_stand_side_by_side():
    tables = {table.name: table for table in entry_tables(Settings())}
    assert set(tables) == {"datasets", "grippers", "cameras", "detectors"}
    names = [column.name for column in tables["grippers"].columns]
    row = dict(zip(names, tables["grippers"].rows["panda"], strict=True))
    assert (row["opening"], row["palm"]) == ("0.08", "0.2, 0.063, 0.06")
    assert tables["datasets"].rows["egad"] == ["evolved", *[""] * 6]
