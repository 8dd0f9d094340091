"""SimReady props, read by OpenUSD itself and compared with the table of grasps."""

import json

import numpy as np
import pytest
from described_hands import jaw_urdf
from PIL import Image

pxr = pytest.importorskip("pxr")
from pxr import Usd, UsdGeom, UsdPhysics, UsdValidation  # noqa: E402 (an extra)

import egad  # noqa: E402
from egad.errors import UserError  # noqa: E402
from egad.exchange import NamedGripper, sources, write_format  # noqa: E402
from egad.exchange.grasps.simready import write  # noqa: E402
from egad.exchange.parameters import AllObjects  # noqa: E402
from egad.grasps import Grasps  # noqa: E402
from egad.grippers import GRIPPERS, Gripper  # noqa: E402
from egad.grippers.hand import JAW_CLEARANCE  # noqa: E402
from egad.tables import parquet  # noqa: E402
from egad.tables.grasping import SIMULATED_GRASPS  # noqa: E402
from egad_workflow.settings import select  # noqa: E402

pytestmark = pytest.mark.usefixtures("started_reader")
LABELS = ("A00_0", "B01_0", "C02_0")
OPENING = GRIPPERS["yumi"].opening


def export(settings, dataset, out, **instead):
    reads = {name: dataset / file for name, file in sources("simready", "yumi").items()}
    chosen = select(settings, AllObjects, "yumi")
    write_format("simready", "all", chosen, "yumi", reads | instead, out)
    return out


@pytest.fixture(scope="module")
def grasps(labelled):
    """Grasps of which some slipped at the end, after they were shaken, and some have no label."""
    frame = labelled.copy()
    held = frame.index[frame["simulated_success"].notna()]
    frame.loc[held[::3], ["simulated_success", "simulated_outcome"]] = False, "dropped"
    assert set(frame["simulated_success"].map(str)) == {"True", "False", "None"}
    return frame


@pytest.fixture(scope="module")
def props(settings, dataset, grasps, tmp_path_factory):
    folder = tmp_path_factory.mktemp("simready")
    parquet.write(grasps, SIMULATED_GRASPS, folder / "grasps.parquet")
    return export(settings, dataset, folder / "out", simulated_grasps=folder / "grasps.parquet")


def open_prop(props, label):
    return Usd.Stage.Open(str(props / label / "simready" / f"{label}.usd"))


@pytest.fixture(scope="module")
def stages(props):
    """The props by label; a stage that is dropped closes."""
    return {label: open_prop(props, label) for label in LABELS}


def lines_of(stage):
    """The curves below the default prim whose names say that they are grasps, in their order."""
    prims = Usd.PrimRange(stage.GetDefaultPrim())
    curves = [UsdGeom.BasisCurves(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves)]
    assert all(curve.GetPrim().GetName().startswith("grasp_identifier") for curve in curves)
    return curves


def ends_of(curve):
    """The ends of a line in the frame of the scene, (2, 3)."""
    placed = UsdGeom.XformCache().GetLocalToWorldTransform(curve.GetPrim())
    return np.array([placed.Transform(point) for point in curve.GetPointsAttr().Get()])


def grasp_of(curve):
    return curve.GetPrim().GetCustomDataByKey("egad:grasp")


def test_only_grasps_that_held_in_simulation_have_lines(stages, grasps):
    for label, rows in grasps.groupby("label"):
        held = {row.grasp for row in rows.itertuples() if row.simulated_success is True}
        written = [grasp_of(curve) for curve in lines_of(stages[label])]
        assert set(written) == held
        assert len(written) == len(held) > 2


def test_lines_run_from_pad_to_pad_of_the_open_hand(stages, grasps):
    rows = grasps.set_index(["label", "grasp"])
    for label in ("A00_0", "B01_0"):
        for curve in lines_of(stages[label]):
            row = rows.loc[label, grasp_of(curve)]
            center, axis, *contacts = (
                row[[f"{name}_{part}" for part in "xyz"]].to_numpy(float)
                for name in ("center", "axis", "contact0", "contact1")
            )
            start, end = ends_of(curve)
            np.testing.assert_allclose((start + end) / 2, center, atol=1e-7)
            np.testing.assert_allclose(end - start, OPENING * axis, atol=1e-7)
            assert curve.GetTypeAttr().Get() == "linear"
            assert list(curve.GetCurveVertexCountsAttr().Get()) == [2]
            along = [np.dot(contact - start, axis) for contact in contacts]
            assert 0 < along[0] < along[1] < OPENING


def test_the_most_robust_grasp_comes_first_and_each_says_what_was_measured(stages, grasps):
    rows = grasps.set_index(["label", "grasp"])
    curves = lines_of(stages["A00_0"])
    about = [curve.GetPrim().GetCustomDataByKey("egad") for curve in curves]
    quality = [each["robust_quality"] for each in about]
    assert quality == sorted(quality, reverse=True)
    for each in about:
        row = rows.loc["A00_0", each["grasp"]]
        assert each["gripper"] == "yumi"
        assert each["simulated_attempts"] == 1
        assert each["simulated_engine"] == "mujoco"
        for name in ("width", "robust_quality", "robust_success_rate", "simulated_outcome"):
            assert each[name] == row[name]
        np.testing.assert_allclose(
            each["approach"], [row[f"approach_{part}"] for part in "xyz"], rtol=1e-12
        )


def test_an_object_that_no_grasp_held_is_a_prop_without_lines(settings, dataset, tmp_path, caplog):
    out = export(settings, dataset, tmp_path / "out")
    stage = open_prop(out, "C02_0")
    assert lines_of(stage) == []
    assert not stage.GetPrimAtPath("/C02_0/grasps")
    said = [record.message for record in caplog.records if "no grasp lines" in record.message]
    assert said == ["C02_0 has no grasp that held in simulation: its prop has no grasp lines"]


def test_the_metadata_are_those_of_the_prop(stages):
    for label, stage in stages.items():
        data = stage.GetRootLayer().customLayerData
        about = data["SimReady_Metadata"]
        assert data.items() >= about.items()
        assert about["asset_name"] == label
        mass = UsdPhysics.MassAPI(stage.GetDefaultPrim()).GetMassAttr().Get()
        assert about["mass"] == pytest.approx(mass, rel=1e-6)
        cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
        box = cache.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
        np.testing.assert_allclose(about["asset_extents"], box.GetSize(), rtol=1e-5)
        found = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"])
        bodies, _ = found[UsdPhysics.ObjectType.RigidBody]
        assert about["rigid_body_count"] == len(bodies)


def test_the_bytes_are_the_same_on_the_date_that_is_asked_for(
    settings, dataset, grasps, tmp_path, monkeypatch
):
    parquet.write(grasps, SIMULATED_GRASPS, tmp_path / "grasps.parquet")
    texts = []
    for number, second in enumerate(("0", "3600", "90000")):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", second)
        out = tmp_path / str(number)
        export(settings, dataset, out, simulated_grasps=tmp_path / "grasps.parquet")
        stage = open_prop(out, LABELS[0])
        date = stage.GetRootLayer().customLayerData["usd_date_generated"]
        assert date == ("1970-01-02" if number == 2 else "1970-01-01")
        texts.append([path.read_bytes() for path in sorted(out.rglob("*.usd"))])
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_files_lie_where_the_rules_want_them(props):
    for label in LABELS:
        files = {
            str(path.relative_to(props / label))
            for path in (props / label).rglob("*")
            if path.is_file()
        }
        picture = f"simready/.thumbs/256x256/{label}.usd.png"
        assert files == {f"simready/{label}.usd", "simready/poses.json", picture}
        with Image.open(props / label / picture) as image:
            assert (image.format, image.size) == ("PNG", (256, 256))
            assert image.convert("RGBA").getextrema()[3] == (0, 255)
        assert json.loads((props / label / "simready/poses.json").read_text())


def test_the_validators_of_usd_have_no_complaint(stages):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    for stage in stages.values():
        assert UsdValidation.ValidationContext(validators).Validate(stage) == []


def test_a_fixed_jaw_has_its_end_of_a_line_before_the_first_contact(made, labelled, tmp_path):
    hand = Gripper.from_file(jaw_urdf(tmp_path / "hand.urdf"))
    rows = labelled[labelled["label"] == "B01_0"].assign(simulated_success=True)
    write(tmp_path, "ell", made, rows, NamedGripper("hand", hand))
    rows = rows.set_index("grasp")
    stage = open_prop(tmp_path, "ell")
    for curve in lines_of(stage):
        row = rows.loc[grasp_of(curve)]
        start, end = ends_of(curve)
        axis, contact = (
            row[[f"{name}_{part}" for part in "xyz"]].to_numpy(float)
            for name in ("axis", "contact0")
        )
        np.testing.assert_allclose(start, contact - JAW_CLEARANCE * axis, atol=2e-5)
        np.testing.assert_allclose(end - start, hand.opening * axis, atol=1e-7)


def test_lines_are_read_again_in_the_frame_of_the_prop(props, grasps, tmp_path):
    path = tmp_path / "moved.usda"
    stage = open_prop(props, "B01_0")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.XformCommonAPI(stage.GetDefaultPrim()).SetTranslate((1, 2, 3))
    scope = UsdGeom.Xform.Define(stage, "/B01_0/grasps")
    scope.AddTranslateOp().Set((1, 0, 0))
    scope.AddRotateZOp().Set(90)
    stage.GetRootLayer().Export(str(path))
    rows = grasps[(grasps["label"] == "B01_0") & grasps["simulated_success"].eq(True)]
    expected = Grasps(rows).sorted_by("robust_quality")
    found = egad.read_grasps(props / "B01_0/simready/B01_0.usd")
    assert found.poses == pytest.approx(expected.poses, abs=1e-6)
    assert (found.widths == expected.widths).all()
    assert found.source_success.all()
    small = egad.read_grasps(path)
    assert small.widths == pytest.approx(expected.widths / 100, rel=1e-12)
    center = small.poses[:, :3, 3]
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.GetRootLayer().Export(str(path))
    moved = np.array([[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) @ expected.poses
    assert egad.read_grasps(path).poses == pytest.approx(moved, abs=1e-6)
    assert center == pytest.approx(moved[:, :3, 3] / 100, abs=1e-8)


def test_props_that_cannot_be_read_are_refused(props, tmp_path):
    path = tmp_path / "a.usda"
    path.write_text("#usda 1.0\ndef")
    with pytest.raises(UserError, match="not a file of OpenUSD, or it is damaged"):
        egad.read_grasps(path)
    stage = open_prop(props, "B01_0")
    lines_of(stage)[0].GetPrim().ClearCustomData()
    stage.GetRootLayer().Export(str(path))
    with pytest.raises(UserError, match=r"1 of 8 grasp lines do not say where the hand comes"):
        egad.read_grasps(path)
    lines_of(stage)[1].GetPrim().ClearCustomDataByKey("egad:width")
    stage.GetRootLayer().Export(str(path))
    with pytest.raises(UserError, match=r"2 of 8 grasp lines .*: export it again"):
        egad.read_grasps(path)
    stage.ClearDefaultPrim()
    stage.GetRootLayer().Export(str(path))
    with pytest.raises(
        UserError, match=r"no grasp lines, grasp_identifier_\.\.\., under its default"
    ):
        egad.read_grasps(path)


def test_grasps_of_a_fixed_jaw_are_read_again(made, labelled, tmp_path):
    hand = Gripper.from_file(jaw_urdf(tmp_path / "hand.urdf"))
    rows = labelled[labelled["label"] == "B01_0"].assign(simulated_success=True)
    write(tmp_path, "ell", made, rows, NamedGripper("hand", hand))
    found = egad.read_grasps(tmp_path / "ell/simready/ell.usd")
    expected = Grasps(rows).sorted_by("robust_quality")
    assert found.poses == pytest.approx(expected.poses, abs=1e-6)
