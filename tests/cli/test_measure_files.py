import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.cli.measure import incomparable, measure_files, warn_of_measures
from egad.evolution import PostprocessSolids
from egad.evolution.growth import surface
from egad.io import write_obj
from egad.measures import MeasureMeshes, solid_row
from egad.tables.objects import MEASURED
from egad_workflow.settings import Settings, select

DEFAULTS = Settings()
SETTINGS = select(DEFAULTS, MeasureMeshes)


def potato(subdivisions=3):
    """A smooth lump without symmetry, 60 mm long."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = mesh.vertices.T
    mesh.vertices *= (1 + 0.2 * np.sin(2 * x + y) + 0.15 * np.cos(3 * z - x))[:, None]
    mesh.apply_scale(0.06 / mesh.extents.max())
    return mesh


def open_scan():
    """A scan without the patch that the object stood on."""
    mesh = potato()
    low = mesh.triangles_center[:, 2] < mesh.bounds[0, 2] + 0.001
    mesh.update_faces(~low)
    return mesh


def inside_out():
    mesh = potato()
    mesh.invert()
    return mesh


def several_bodies():
    crumb = trimesh.creation.icosphere(subdivisions=1, radius=0.002).apply_translation([0.1, 0, 0])
    return trimesh.util.concatenate([potato(), crumb])


def doubled_and_degenerate():
    mesh = potato()
    faces = np.vstack([mesh.faces, mesh.faces[:20], [[0, 0, 1], [5, 5, 5]]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def plane():
    return trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def triangle():
    return trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def not_finite():
    mesh = potato()
    mesh.vertices[3] = np.nan
    return mesh


@pytest.fixture(scope="module")
def bad(tmp_path_factory):
    """A folder of everything that people have."""
    folder = tmp_path_factory.mktemp("bad")
    meshes = {
        "good": potato(),
        "open_scan": open_scan(),
        "inside_out": inside_out(),
        "several_bodies": several_bodies(),
        "doubled": doubled_and_degenerate(),
        "plane": plane(),
        "triangle": triangle(),
        "not_finite": not_finite(),
        "wide": potato().apply_scale(100),
        "thousandth": potato().apply_scale(0.001),
    }
    for name, mesh in meshes.items():
        mesh.export(folder / f"{name}.ply")
    (folder / "empty.obj").write_text("")
    (folder / "text.stl").write_text("solid nothing of the kind")
    names = [*meshes, "empty", "text", "absent"]
    endings = {"empty": "obj", "text": "stl"}
    return {name: folder / f"{name}.{endings.get(name, 'ply')}" for name in names}


@pytest.fixture(scope="module")
def table(bad):
    return measure_files(SETTINGS, bad, "m", 2).set_index("name")


def test_every_mesh_has_a_row_in_the_order_given(bad, table):
    assert list(table.index) == list(bad)
    assert list(table.reset_index().columns) == MEASURED.names


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("plane", "open edges"),
        ("triangle", "open edges"),
        ("not_finite", "not finite"),
        ("thousandth", "is the unit of the mesh right?"),
        ("empty", "no faces"),
        ("text", "no faces"),
        ("absent", "no such file"),
    ],
)
def test_what_cannot_be_measured_says_why(table, name, reason):
    assert reason in table.loc[name, "reason"]
    assert table.loc[name].drop("reason").isna().all()


@pytest.mark.parametrize("name", ["open_scan", "inside_out", "several_bodies", "doubled"])
def test_what_can_be_mended_is_measured_as_the_whole_mesh(table, name):
    row, good = table.loc[name], table.loc["good"]
    assert row["reason"] == ""
    assert row["repaired"]
    assert not good["repaired"]
    assert row["complexity"] == pytest.approx(good["complexity"], abs=0.1)
    assert row["graspability"] == pytest.approx(good["graspability"], abs=0.0003)
    assert row["longest_side"] == pytest.approx(good["longest_side"], rel=0.01)


def test_open_surfaces_are_measured_as_shells_if_the_settings_say_so(bad, table):
    changes = {"open_surfaces": "thicken", "shell_thickness": 0.004}
    postprocess = SETTINGS.postprocess.model_copy(update=changes)
    settings = SETTINGS.model_copy(update={"postprocess": postprocess})
    bowl = potato()
    bowl.update_faces(bowl.triangles_center[:, 2] < 0)
    path = bad["good"].with_name("bowl.ply")
    bowl.export(path)
    files = {"bowl": path, "good": bad["good"]}
    found = measure_files(settings, files, "m", 1).set_index("name")
    assert found["reason"].tolist() == ["", ""]
    assert found["shell_thickness"].tolist() == [0.004, 0]
    assert found.loc["bowl", "longest_side"] == pytest.approx(bowl.extents.max() + 0.004, rel=0.01)
    pd.testing.assert_series_equal(found.loc["good"], table.loc["good"])


def test_the_size_is_that_of_the_rule(bad, table, caplog):
    large = table.loc["wide"]
    assert (large["rule"], large["opening"]) == ("exact", 0.05)
    assert large["grasped_1"] == pytest.approx(0.8 * 0.05)
    assert large["factor"] == pytest.approx(table.loc["good", "factor"] / 100)
    files = {"small": bad["good"].with_name("small.ply")}
    potato().apply_scale(0.5).export(files["small"])
    measured = measure_files(SETTINGS, files, "m", 1)
    warn_of_measures(measured)
    (scaled,) = measured.to_dict("records")
    assert scaled["factor"] == pytest.approx(2 * table.loc["good", "factor"], rel=1e-3)
    assert (
        "1 of 1 meshes are enlarged before they are measured, for example small by" in caplog.text
    )
    caplog.clear()
    measured = measure_files(SETTINGS, files, "m", 1, "none")
    warn_of_measures(measured)
    (real,) = measured.to_dict("records")
    assert (real["rule"], real["factor"]) == ("none", 1)
    assert real["grasped_3"] == pytest.approx(0.03, rel=0.05)
    assert caplog.text == ""


def test_bodies_that_are_left_out_are_said_with_their_part_of_the_volume(bad, table, caplog):
    crumb, body = trimesh.creation.icosphere(subdivisions=1, radius=0.002), potato()
    part = crumb.volume / (crumb.volume + body.volume)
    row = table.loc["several_bodies"]
    assert (row["dropped_bodies"], row["dropped_volume"]) == (1, pytest.approx(part, rel=1e-4))
    assert (table.loc["good", ["dropped_bodies", "dropped_volume"]] == 0).all()
    warn_of_measures(measure_files(SETTINGS, {"crumbs": bad["several_bodies"]}, "m", 1))
    assert f"crumbs: 1 of 2 bodies was dropped, {100 * part:.2g} % of the volume" in caplog.text


def test_cells_are_comparable_with_the_map_by_its_rule_and_gripper():
    own = DEFAULTS.graspability.gripper
    assert incomparable(DEFAULTS, own, "exact") == ""
    assert "for the rule none and yumi," in incomparable(DEFAULTS, own, "none")
    assert "for the rule exact and panda," in incomparable(DEFAULTS, "panda", "exact")


def test_workers_leave_no_trace(bad, table):
    names = ["several_bodies", "plane", "text", "absent"]
    one = measure_files(SETTINGS, {name: bad[name] for name in names}, "m", 1).set_index("name")
    pd.testing.assert_frame_equal(one, table.loc[names])


def test_an_evolved_object_has_the_measures_of_its_mesh_file(tmp_path):
    """Also in another unit: grasps are named after the triangles."""
    made = surface(np.pad(np.ones((9, 15, 25), bool), 2), DEFAULTS.shape)
    row = solid_row(made, "0123", select(DEFAULTS, PostprocessSolids), resample=False)
    mesh = trimesh.Trimesh(
        np.reshape(row["vertices"], (-1, 3)), np.reshape(row["faces"], (-1, 3)), process=False
    )
    write_obj(mesh, tmp_path / "A00_0.obj")
    write_obj(mesh.copy().apply_scale(1000), tmp_path / "mm.obj")
    for name, units in (("A00_0", "m"), ("mm", "mm")):
        (found,) = measure_files(SETTINGS, {name: tmp_path / f"{name}.obj"}, units, 1).to_dict(
            "records"
        )
        assert found["raw_complexity"] == pytest.approx(row["complexity"], abs=1e-6)
        assert found["complexity"] == pytest.approx(row["complexity"], abs=0.15)
        assert found["graspability"] == pytest.approx(row["graspability"], rel=1e-6)
