import collect
import numpy as np
import pandas as pd
import pytest
import trimesh
from postprocess import from_folder, from_primitives, measure_objects, solid_row

from egad.errors import UserError
from egad.evolution import PostprocessSolids
from egad.measures import CellsAndDiversities, CustomMeasures
from egad.tables import parquet
from egad.tables.objects import REJECTED, SOLIDS
from egad_workflow.settings import Settings, select

COARSE = Settings.model_validate(
    {
        "postprocess": {"max_candidates": 128},
        "similarity": {"vertices": 1000, "base_count": 20},
        "shape": {"longest_side": 0.07},
    }
)


@pytest.fixture
def scans(tmp_path):
    for side, name in enumerate(["can", "mug", "bowl"], start=1):
        (tmp_path / name / "scan").mkdir(parents=True)
        trimesh.creation.box([side] * 3).export(tmp_path / name / "scan" / "mesh.ply")
    return tmp_path


def test_a_pattern_finds_and_names_the_meshes_of_sub_folders(scans):
    sources, known = from_folder(scans, "cm", 0, 1, "*/scan/mesh.ply")
    assert known.empty
    sides = {name: load().extents[0] for name, load in sources.items()}
    assert sides == pytest.approx({"can": 0.01, "mug": 0.02, "bowl": 0.03})


def postprocessed(folder, count, shards):
    """The solids and the rejected ones among so many random objects, of all shards.

    Their complexity is a function that takes no time.
    """
    (folder / "mine.py").write_text("def faces(mesh): return float(len(mesh.faces))\n")
    settings = select(COARSE, PostprocessSolids).model_copy(
        update={"measures": CustomMeasures(complexity=f"{folder}/mine.py:faces")}
    )
    solids, rejected = [], []
    for shard in range(shards):
        sources, known = from_primitives(count, settings, shard, shards)
        assert known.empty
        out, left_out = folder / f"solids-{shard}.parquet", folder / f"rejected-{shard}.parquet"
        measure_objects(settings, sources, known, out, left_out)
        solids.append(parquet.read(out, SOLIDS))
        rejected.append(parquet.read(left_out, REJECTED))
    return pd.concat(solids).sort_values("id", ignore_index=True), pd.concat(rejected)


def test_random_objects_are_the_same_however_many_and_in_any_number_of_shards(tmp_path):
    whole, _ = postprocessed(tmp_path, 6, 1)
    parts, _ = postprocessed(tmp_path, 8, 3)
    assert parts["id"].tolist() == [f"p{number:05d}" for number in range(8)]
    pd.testing.assert_frame_equal(whole, parts.head(6))
    assert whole[["extents_x", "extents_y", "extents_z"]].max(axis=1).to_numpy() == pytest.approx(
        [0.07] * 6
    )


@pytest.mark.slow
def test_no_random_object_is_rejected(tmp_path):
    solids, rejected = postprocessed(tmp_path, 100, 1)
    assert (len(solids), len(rejected)) == (100, 0)
    assert solids["watertight"].all()
    assert solids["volume"].gt(0).all()
    assert solids["volume"].nunique() == 100


def test_a_dataset_without_an_object_stops_with_the_reasons(tmp_path):
    (tmp_path / "mine.py").write_text("def hollow(mesh): return float('nan')\n")
    measures = {
        "complexity": f"{tmp_path}/mine.py:hollow",
        "graspability": f"{tmp_path}/mine.py:hollow",
    }
    settings = select(
        COARSE.model_copy(update={"measures": CustomMeasures(**measures)}), PostprocessSolids
    )
    sources = {name: lambda: trimesh.creation.box((0.03, 0.04, 0.05)) for name in ("a", "b")}
    solids, rejected = tmp_path / "out.parquet", tmp_path / "no.parquet"
    measure_objects(settings, sources, pd.Series(), solids, rejected)
    folder = tmp_path / "mine"
    written = (folder / "objects.parquet", folder / "rejected.parquet", folder / "meshes")
    given = select(COARSE, CellsAndDiversities)
    with pytest.raises(UserError) as stopped:
        collect.run(given, "meshes", [solids], [rejected], *written)
    assert str(stopped.value) == (
        "mine: none of 2 objects could be used: hollow is not a finite number (nan) (2)"
    )
    assert not folder.exists()


def write_cup(path, side=0.04, height=0.05):
    """Four walls and a floor of a cup, without thickness."""
    mesh = trimesh.creation.box([side, side, height])
    mesh.update_faces(mesh.face_normals[:, 2] < 0.9)
    mesh.export(path)


def test_open_meshes_become_shells_if_the_settings_say_so(tmp_path):
    """Their mass is that of the walls, and both tables say what was done."""
    write_cup(tmp_path / "cup.ply")
    trimesh.creation.box([0.04, 0.04, 0.05]).export(tmp_path / "block.ply")
    out, left_out = tmp_path / "solids.parquet", tmp_path / "rejected.parquet"
    changes = {"open_surfaces": "thicken", "shell_thickness": 0.003}
    thicken = Settings.model_validate(
        COARSE.model_dump() | {"postprocess": {"max_candidates": 128, **changes}}
    )
    for whole in (COARSE, thicken):
        settings = select(whole, PostprocessSolids)
        measure_objects(settings, *from_folder(tmp_path, "m", 0, 1, "*.ply"), out, left_out)
        rows = parquet.read(out, SOLIDS).set_index("id")
        rejected = parquet.read(left_out, REJECTED)
        assert rows.loc["block", "shell_thickness"] == 0
        if whole is COARSE:
            assert rejected["reason"].tolist() == [
                "open surface: 4 open edges that could not be closed; `open_surfaces: thicken` "
                "gives a surface without thickness a wall"
            ]
        else:
            assert rejected.empty
            cup, area = rows.loc["cup"], 0.04**2 + 4 * 0.04 * 0.05
            assert cup["shell_thickness"] == 0.003
            assert cup["watertight"]
            assert cup["mass"] == pytest.approx(settings.material.density * area * 0.003, rel=0.05)
            assert cup["extents_x"] == pytest.approx(0.043, rel=0.01)


def test_a_turned_block_has_the_textbook_moments_about_its_own_axes():
    sides, settings = np.array([0.03, 0.05, 0.08]), select(COARSE, PostprocessSolids)
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    row = solid_row(trimesh.creation.box(sides).apply_transform(turn), "block", settings)
    tensor = np.array([[row[f"inertia_{min(a, b)}{max(a, b)}"] for a in "xyz"] for b in "xyz"])
    moments = settings.material.density * sides.prod() / 12 * (sides @ sides - sides**2)
    axes = turn[:3, :3]
    np.testing.assert_allclose(tensor @ axes, axes * moments, atol=1e-6 * moments.max())
