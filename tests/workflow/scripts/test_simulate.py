"""Trials of a bundle, whatever is in it; and any attempt again, as a film."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import simulate
import trimesh
from commands import egad
from dying_worker import Dying
from PIL import Image

from egad import sample_grasps
from egad.bench import SimulatedTrials, film_attempt
from egad.detectors import DetectorConfig
from egad.errors import UserError
from egad.exchange import bundle_models, evaluation_objects, model_in, write_bundle
from egad.io import write_obj
from egad.sim import SimulationBundle, make_simulation_object
from egad.sim.film import write_film
from egad.sim.model import model_of
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE, EVAL49, TRIALS
from egad_workflow.settings import Settings, select

WHOLE = Settings.model_validate({"trials": {"attempts": 3}})
SETTINGS = select(WHOLE, SimulatedTrials, "egad_75mm", "antipodal-depth")
BOX = trimesh.creation.box((0.04, 0.04, 0.04))
OPEN = BOX.vertices, BOX.faces[1:]
MESHES = {
    "A0": trimesh.creation.box(
        (0.04, 0.03, 0.05), trimesh.transformations.rotation_matrix(1, (1, 2, 3))
    ),
    "A1": trimesh.creation.cylinder(0.02, 0.07),
    "B0": trimesh.Trimesh(*OPEN, process=False),  # no solid
}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """A folder as the pipeline makes it, with an object that is not in the bundle."""
    folder = tmp_path_factory.mktemp("results") / "egad"
    meshes, evaluation = folder / "rescaled" / "egad_75mm", folder / "eval49.parquet"
    rows = []
    for label, mesh in MESHES.items():
        write_obj(mesh.copy().apply_translation((0.1, 0.2, 0.3)), meshes / f"{label}.obj")
        blank = dict.fromkeys(EVAL49.names, 0)
        rows.append(blank | {"label": label, "id": f"id-{label}", "object_label": label})
    parquet.write(pd.DataFrame(rows), EVAL49, evaluation)
    items = evaluation_objects(evaluation, meshes)
    write_bundle(select(WHOLE, SimulationBundle), items, "m", folder / "bundle" / "egad_75mm")
    return folder


def tried(dataset, out, shard=(0, 1), settings=SETTINGS):
    made = dataset / "bundle" / "egad_75mm"
    simulate.run(settings, dataset / "eval49.parquet", made, shard, out)
    return out


@pytest.fixture(scope="module")
def table(dataset):
    return tried(dataset, dataset / "trials" / "egad_75mm" / "antipodal-depth.parquet")


def test_a_model_is_that_of_the_bundle(dataset):
    made = dataset / "bundle" / "egad_75mm"
    rows = parquet.records(parquet.read(made / "bundle.parquet", BUNDLE))
    for row in rows:
        mesh = MESHES[row["label"]].copy().apply_translation((0.1, 0.2, 0.3))
        whole = make_simulation_object(mesh, WHOLE.material.density, WHOLE.bundle)
        expected = model_of(whole.mesh, whole.parts, whole.physics, whole.volume_error)
        found = model_in(made, row)
        assert found.mass == expected.mass
        np.testing.assert_allclose(found.inertia, expected.inertia, rtol=1e-12)
        np.testing.assert_allclose(found.mesh.bounds, expected.mesh.bounds, atol=1e-12)
        assert len(found.parts) == len(expected.parts)


def test_every_object_is_tried_and_one_without_a_model_fails(table):
    trials = parquet.read(table, TRIALS)
    assert trials.groupby("label").size().to_dict() == dict.fromkeys(MESHES, 3)
    outcomes = trials.groupby("label")["outcome"].unique()
    assert set(outcomes["B0"]) == {"failed"}
    assert trials.loc[trials["label"] != "B0", "success"].any()


def test_shards_together_have_the_same_rows(dataset, table, tmp_path):
    parts = [tried(dataset, tmp_path / f"{n}.parquet", (n, 2)) for n in range(2)]
    frames = [parquet.read(part, TRIALS) for part in parts]
    together = pd.concat(frames).sort_values(["label", "attempt"], ignore_index=True)
    pd.testing.assert_frame_equal(together, parquet.read(table, TRIALS), check_exact=True)


def test_an_object_that_ends_the_process_twice_is_marked(dataset, tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(simulate, "open_trials", Dying)
    trials = parquet.read(tried(dataset, tmp_path / "out.parquet"), TRIALS)
    outcomes = dict(zip(trials["label"], trials["outcome"], strict=True))
    assert outcomes == {"A0": "crashed", "A1": "crashed", "B0": "failed"}
    assert "A0 (id-A0): everything crashed" in caplog.text


def known_of(folder, path, *labels):
    """Settings with the files of grasps of some objects as the detector."""
    folder.mkdir()
    for label in labels:
        mesh = MESHES[label].copy().apply_translation((0.1, 0.2, 0.3))
        poses = sample_grasps(mesh, SETTINGS.gripper, n=200).poses
        np.savez(folder / f"{label}.npz", poses=poses, frame="x z", depth=0.0, units="m")
    detector = DetectorConfig(detector=f"grasps:{path}")
    return SETTINGS.model_copy(update={"detector": detector})


def test_known_grasps_are_tried_wherever_their_objects_lie(dataset, tmp_path):
    """They are in the frame of the scaled mesh, whose origin is far from the object."""
    settings = known_of(tmp_path / "all", tmp_path / "all", "A0", "A1")
    trials = parquet.read(tried(dataset, tmp_path / "a.parquet", settings=settings), TRIALS)
    assert (trials[trials["label"] != "B0"]["outcome"] == "success").mean() > 0.6


@pytest.mark.parametrize("path", ["one", "one/A0.npz"])
def test_each_object_needs_known_grasps_of_its_own(dataset, tmp_path, path):
    settings = known_of(tmp_path / "one", tmp_path / path, "A0")
    with pytest.raises(UserError, match="there are no grasps of 'A1'; there are some of A0"):
        tried(dataset, tmp_path / "a.parquet", settings=settings)


def replayed(dataset, label, attempt, out):
    trials = dataset / "trials" / "egad_75mm" / "antipodal-depth.parquet"
    models = bundle_models(dataset / "bundle" / "egad_75mm")
    return film_attempt(SETTINGS, trials, models, label, attempt, out)


@pytest.mark.usefixtures("small_films")
def test_an_attempt_is_filmed(dataset, table, tmp_path):
    trials = parquet.read(table, TRIALS)
    wanted = trials[trials["label"] == "A0"].iloc[1]
    film = tmp_path / "film.gif"
    assert replayed(dataset, "A0", 1, film) == wanted["outcome"]
    with Image.open(film) as picture:
        frames = []
        for number in range(picture.n_frames):
            picture.seek(number)
            frames.append(np.asarray(picture.convert("RGB"), dtype=int))
    assert len(frames) > 40
    orange = [((f[..., 0] - f[..., 2]) > 60).sum() for f in frames]
    assert min(orange) > 5  # the object is seen from beginning to end
    assert np.abs(frames[0] - frames[-1]).max() > 50


@pytest.mark.usefixtures("small_films")
@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_replay_from_the_command_line(dataset, table, tmp_path, monkeypatch, elsewhere):
    monkeypatch.chdir(tmp_path)
    config = tmp_path / "mine.yaml"
    config.write_text("trials: {attempts: 3}\n")
    shutil.copy(table, tmp_path / "network.parquet")
    where = ["--table", "network.parquet", "--detector", "random"] if elsewhere else []
    arguments = ["trials", "replay", "A1", 0, "--in", dataset, "--config", config]
    done = egad(*arguments, *where)
    assert done.returncode == 0, done.stderr
    assert "A1, attempt 0: " in done.stdout
    assert Path("A1-0.gif").stat().st_size > 10_000


def test_without_ffmpeg_a_film_can_be_a_gif(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    frames = [np.full((400, 352, 3), shade, np.uint8) for shade in (10, 200)]
    with pytest.raises(UserError, match=r"MP4 needs ffmpeg \(pip install imageio-ffmpeg\); GIF"):
        write_film(frames, tmp_path / "film.mp4")
    write_film(frames, tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as film:
        assert (film.n_frames, film.info["duration"]) == (2, 50)


@pytest.mark.parametrize(
    ("label", "attempt", "said"),
    [
        ("Z9", 0, "no object Z9; allowed: A0, A1, B0"),
        ("A0", 3, "A0 has no attempt 3; its last is 2"),
        ("B0", 0, "B0, attempt 0 never started: failed"),
    ],
)
@pytest.mark.usefixtures("table")
def test_what_cannot_be_replayed_is_said(dataset, tmp_path, label, attempt, said):
    with pytest.raises(UserError, match=said):
        replayed(dataset, label, attempt, tmp_path / "film.gif")


@pytest.mark.usefixtures("small_films")
def test_a_replay_under_other_settings_is_noticed(dataset, table, tmp_path):
    other = SETTINGS.gripper.model_copy(update={"friction": 0.02})
    trials = parquet.read(table, TRIALS)
    row = trials[trials["success"]].iloc[0]
    with pytest.raises(UserError, match="was not reproduced"):
        film_attempt(
            SETTINGS.model_copy(update={"gripper": other}),
            table,
            bundle_models(dataset / "bundle" / "egad_75mm"),
            row["label"],
            int(row["attempt"]),
            tmp_path / "film.gif",
        )


def verified(dataset, trials, tmp_path, *words):
    path = tmp_path / "submitted.parquet"
    parquet.write(trials, TRIALS, path)
    config = tmp_path / "mine.yaml"
    config.write_text("trials: {attempts: 3}\n")
    return egad("trials", "verify", path, "--in", dataset, "--config", config, *words)


def test_a_table_is_verified_without_its_detector(dataset, table, tmp_path):
    trials = parquet.read(table, TRIALS)
    all_of_it = verified(dataset, trials, tmp_path).stdout
    assert "9 of 9 attempts are the same" in all_of_it
    assert "6 of 6 attempts" in verified(dataset, trials, tmp_path, "--sample", 2).stdout


@pytest.mark.parametrize("column", ["lifted", "initial_z"])
def test_a_table_altered_in_one_place_is_refused(dataset, table, tmp_path, column):
    trials = parquet.read(table, TRIALS)
    row = trials.index[(trials["label"] == "A1") & trials["success"]][0]
    trials.loc[row, column] += 1e-3
    refused = verified(dataset, trials, tmp_path)
    assert refused.returncode == 1
    assert "of 9 attempts are not reproduced" in refused.stderr
    assert f"A1, attempt {trials['attempt'][row]}: " in refused.stderr
