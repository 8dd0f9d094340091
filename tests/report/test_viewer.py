import base64
import json
import re
import zlib

import numpy as np
import pandas as pd
import pytest
import trimesh

import egad
from egad.errors import UserError
from egad.grasps import GraspLabel
from egad.grasps.parameters import LabelParameters
from egad.grasps.sampling import Labeller
from egad.grippers import GRIPPERS, BoxBody
from egad.report import viewer
from egad.report.viewer import GraspScene
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(grasp_label=GraspLabel(grasps=20)), LabelParameters, "yumi")
MESH = trimesh.creation.torus(0.03, 0.008)
MESH.vertices += [0.5, -0.2, 0.0]


def unpack(item: dict) -> dict[str, np.ndarray]:
    """What the script does, in Python."""
    content = zlib.decompress(base64.b64decode(item["data"]))
    vertices, faces, grasps = item["counts"]
    parts, start = {}, 0
    for name, kind, rows, columns in (
        ("faces", "u1", 4, 3 * faces),
        ("vertices", "u1", 4, 3 * vertices),
        ("quality", "<f4", grasps, 1),
        ("robust_quality", "<f4", grasps, 1),
        ("contacts", "<u2", 2 * grasps, 3),
        ("approach", "<i2", grasps, 3),
        ("free", "u1", grasps, 1),
    ):
        count = rows * columns
        parts[name] = np.frombuffer(content, kind, count, start).reshape(rows, columns)
        assert start % np.dtype(kind).itemsize == 0  # typed arrays want it
        start += count * np.dtype(kind).itemsize
    assert start == len(content)
    for name in ("faces", "vertices"):
        folded = (parts[name].T.astype(np.int64) * 256 ** np.arange(4)).sum(axis=1)
        steps = np.where(folded % 2, -(folded + 1) // 2, folded // 2)
        parts[name] = np.cumsum(steps.reshape(-1, 3), axis=0)
    for name in ("vertices", "contacts"):
        parts[name] = np.array(item["origin"]) + item["step"] * parts[name].astype(float)
    return parts


@pytest.fixture(scope="module")
def grasps() -> pd.DataFrame:
    return Labeller(SETTINGS)(MESH, MESH.center_mass, np.random.default_rng(0)).table


@pytest.fixture(scope="module")
def html(grasps) -> str:
    return viewer.page(GraspScene("ring", "", MESH, grasps), "yumi", GRIPPERS["yumi"])


def vectors(frame, name):
    return frame[[f"{name}_{part}" for part in "xyz"]].to_numpy()


def test_what_is_packed_can_be_unpacked(grasps):
    item = viewer.pack(GraspScene("ring", "of a torus", MESH, grasps, "a note"))
    assert (item["name"], item["title"], item["note"]) == ("ring", "of a torus", "a note")
    parts = unpack(item)
    half = 0.5 * item["step"] + 1e-12
    assert item["step"] < 1e-5
    assert np.abs(parts["vertices"] - MESH.vertices).max() <= half
    np.testing.assert_array_equal(parts["faces"], MESH.faces)
    contacts = np.stack([vectors(grasps, "contact0"), vectors(grasps, "contact1")], axis=1)
    assert np.abs(parts["contacts"] - contacts.reshape(-1, 3)).max() <= half
    np.testing.assert_allclose(parts["approach"] / 32767, vectors(grasps, "approach"), atol=2e-5)
    for key in viewer.METRICS:
        np.testing.assert_allclose(parts[key][:, 0], grasps[key], rtol=1e-6)
    np.testing.assert_array_equal(parts["free"][:, 0].astype(bool), grasps["collision_free"])


def test_a_mesh_without_grasps_can_be_packed():
    item = viewer.pack(GraspScene("ring", "", MESH, parquet.empty(GRASPS), "no grasp"))
    assert item["counts"] == [len(MESH.vertices), len(MESH.faces), 0]
    np.testing.assert_array_equal(unpack(item)["faces"], MESH.faces)
    data = viewer.viewer_data(
        [GraspScene("ring", "", MESH, parquet.empty(GRASPS))], GRIPPERS["yumi"]
    )
    assert all(top > 0 for _, _, top in data["metrics"])


def test_colors_mean_the_same_for_all_objects(grasps):
    poor = grasps.assign(quality=grasps["quality"] / 10)
    scenes = [GraspScene("good", "", MESH, grasps), GraspScene("poor", "", MESH, poor)]
    data = viewer.viewer_data(scenes, GRIPPERS["yumi"])
    tops = {key: top for key, _, top in data["metrics"]}
    both = pd.concat([grasps, poor])["quality"]
    assert grasps["quality"].median() < tops["quality"] <= grasps["quality"].max()
    assert (both <= tops["quality"]).mean() == pytest.approx(0.98, abs=0.03)


@pytest.mark.parametrize("name", [name for name, each in GRIPPERS.items() if not each.cup])
def test_the_jaws_reach_back_to_the_palm_mesh_the_gripper(name):
    gripper = GRIPPERS[name]
    data = viewer.viewer_data([GraspScene("ring", "", MESH, parquet.empty(GRASPS))], gripper)
    assert data["finger"] == pytest.approx(-BoxBody(gripper).parts()[2].box[1, 2])


def test_the_page_needs_nothing_else(html):
    assert "default-src 'none'" in html
    assert not re.search(
        r"""(src|href)\s*=|https?:|//cdn|@import|url\(|\bfetch\(|\bimport """, html
    )


def test_the_page_has_what_the_script_asks_for(html):
    names = set(re.findall(r'part\("(\w+)"\)', html))
    assert len(names) > 10
    for name in names:
        assert re.search(rf'(name|class)="{name}"', html), name
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', html)[1])
    assert [bool(item["counts"][2]) for item in data["objects"]] == [True, False]


def test_names_from_files_are_escaped(grasps):
    name = "</script><script>alert(1)</script>"
    html = viewer.page(GraspScene(name, name, MESH, grasps, name), "yumi", GRIPPERS["yumi"])
    assert "<script>alert" not in html


def test_the_same_object_gives_the_same_bytes(html, grasps):
    assert (
        viewer.page(GraspScene("ring", "", MESH, grasps.copy()), "yumi", GRIPPERS["yumi"]) == html
    )


def test_grasps_of_another_size_are_not_shown():
    box = trimesh.creation.box((0.03, 0.04, 0.05))
    grasps = egad.sample_grasps(box, "panda", n=5)
    assert "Gripper panda, opening 80 mm" in egad.view(box, grasps, "panda").html
    with pytest.raises(UserError, match="same scale"):
        egad.view(box.copy().apply_scale(0.5), grasps, "panda")
    with pytest.raises(UserError, match=r"a mesh must be a trimesh\.Trimesh"):
        egad.view(trimesh.Scene(box))
    for wrong in (grasps.to_frame(), grasps.poses, "grasps"):
        name = type(wrong).__name__
        with pytest.raises(UserError, match=rf"grasps are egad\.Grasps, got {name}"):
            egad.view(box, wrong, "panda")
    with pytest.raises(UserError, match="path is None"):
        egad.view(box).save(None)


def test_grasps_are_shown_with_the_gripper_that_they_are_for():
    box = trimesh.creation.box((0.03, 0.04, 0.05))
    hand = egad.Gripper(opening=0.065)
    grasps = egad.sample_grasps(box, hand, n=5)
    assert "Gripper, opening 65 mm" in " ".join(egad.view(box, grasps, hand).html.split())
    with pytest.raises(UserError, match="fingers of a gripper: name one"):
        egad.view(box, grasps)
    assert "opening" not in egad.view(box).html.partition("<script")[0].partition("<h1")[2]
