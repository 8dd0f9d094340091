"""What Snakemake would do: dry runs of a clean checkout and of a finished run."""

import os
import shutil
from ast import literal_eval
from functools import partial

import pandas as pd
import pytest
import trimesh
from described_hands import PANDA, box_urdf
from failure_searches import FEW, QUICK

from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import AGREEMENT, EVAL49, MANIFEST
from egad.tables.failures import EXAMINED
from egad.tables.grasping import SCALES, SIMULATED_GRASPS, SIMULATED_OBJECTS
from egad_workflow.settings import Settings
from egad_workflow.shards import shard_of

GRIPPER = "egad_75mm"
TRIED = {"simulated_trial", "join_trials"}
AFTER_TRIALS = {"join_trials", "report", "all"}
AFTER_PRINTS = {"datasheet", "report", "all"}
AFTER_GRASPS = {"join_grasps", "join_sampling", "join_ungraspable"} | AFTER_PRINTS
AFTER_SIZES = {"size_effect", "report", "all"}
AFTER_BUNDLE = {"bundle", "simulated_trial"} | AFTER_TRIALS
AFTER_SELECTION = {"print_export"} | AFTER_BUNDLE | AFTER_PRINTS | AFTER_SIZES
AFTER_RESCALE = {"grasp_label", "print_export"} | AFTER_GRASPS | AFTER_BUNDLE
AFTER_COLLECT = {"compare", "rescale", "select_eval"} | AFTER_RESCALE | AFTER_SELECTION
AFTER_POSTPROCESS = {"collect"} | AFTER_COLLECT
EVERYTHING = {
    "evolve",
    "merge",
    "archive",
    "ancestry",
    "history",
    "postprocess",
} | AFTER_POSTPROCESS


@pytest.mark.parametrize("entry", ["Snakefile", "workflow/Snakefile"])
def test_a_clean_checkout_plans_the_whole_pipeline(clean, entry):
    planned = clean.planned("--snakefile", entry, configs=())
    assert set(planned) == EVERYTHING
    assert planned["evolve"] == Settings().epochs * Settings().schedule.islands
    assert (planned["postprocess"], planned["report"]) == (Settings().shards, 1)


def test_as_many_epochs_as_are_allowed_can_be_planned(clean):
    most = clean.overlay("most.yaml", {"schedule": {"epochs": 200, "islands": 2}})
    assert clean.planned(configs=[most])["evolve"] == 400


def named(value):
    """Names of tests that are the same in every process: sets have no order."""
    return "" if isinstance(value, set) else str(value)


@pytest.mark.parametrize(
    ("settings", "rules"),
    [
        ({"trials": {"attempts": 3}}, {"simulated_trial"} | AFTER_TRIALS),
        # the report lists all settings
        ({"keep_going": True}, {"report", "all"}),
        ({"bundle": {"max_parts": 9}}, AFTER_BUNDLE),
        ({"print_export": {"gap": 0.006}}, {"print_export"} | AFTER_PRINTS),
        ({"print_check": {"wall": 0.001}}, {"select_eval"} | AFTER_SELECTION),
        ({"robust": {"samples": 6}}, {"grasp_label"} | AFTER_GRASPS),
        ({"size_effect": {"repeats": 3}}, AFTER_SIZES),
        (
            {"rescale": {"side_fraction": 0.7}},
            {"rescale", "select_eval"} | AFTER_RESCALE | AFTER_SELECTION,
        ),
        ({"postprocess": {"max_candidates": 129}}, {"postprocess"} | AFTER_POSTPROCESS),
        ({"shards": 3}, {"postprocess"} | AFTER_POSTPROCESS),
        ({"evolution": {"population": 11}}, EVERYTHING),
        (
            {"grippers": {"egad_75mm": {"force": 71.0}}},
            {"rescale"} | AFTER_RESCALE | AFTER_SIZES,
        ),
        ({"grippers": {"panda": {"force": 71.0}}}, {"report", "all"}),
    ],
    ids=named,
)
def test_a_setting_re_runs_what_depends_on_it_and_no_more(planned, settings, rules):
    assert set(planned(**settings)) == rules


@pytest.mark.parametrize(
    ("module", "old", "new", "rules"),
    [
        (
            "egad/sim/world.py",
            "GRAVITY = 9.81",
            "GRAVITY = 1.62",
            {"simulated_trial"} | AFTER_TRIALS,
        ),
        (
            "egad/measures/parameters.py",
            "percentile of the qualities",
            "of them",
            {"report", "all"},
        ),
    ],
    ids=named,
)
def test_an_edit_re_runs_the_stages_that_use_it(copy, module, old, new, rules):
    copy.take_library()
    path = copy.folder / module
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert set(copy.planned()) == rules


def test_an_edited_script_re_runs_its_rules(copy):
    path = copy.folder / "workflow/scripts/join.py"
    text, time = path.read_text(encoding="utf-8"), path.stat().st_mtime
    old = 'f"joining {len(tables)} tables"'
    assert old in text
    path.write_text(text.replace(old, '"joining"'), encoding="utf-8")
    os.utime(path, (time, time))
    assert set(copy.planned()) == {"join_trials", "history"} | AFTER_GRASPS


def test_a_touched_or_commented_module_or_script_re_runs_nothing(copy):
    copy.take_library()
    scripts = [str(path) for path in (copy.folder / "workflow/scripts").glob("*.py")]
    modules = ["egad/tables/objects.py", "egad/random.py", "egad/evolution/island.py"]
    for module in (*modules, *scripts):
        path = copy.folder / module
        path.write_text(f"# a comment\n{path.read_text()}\n\n")
        os.utime(path)
    assert copy.planned() == {}


def changed_by(change, checkout, *targets, configs):
    """The rules of the jobs that have other params after a change, which makes them run again."""
    before = checkout.told(*targets, configs=configs)
    change()
    after = checkout.told(*targets, configs=configs)
    return {job.rule for job in after if job not in before}


def test_an_edited_measure_or_mesh_of_ones_own_evolves_again(clean):
    measure, mesh = clean.folder / "mine.py", clean.folder / "part.stl"
    measure.write_text("def size(mesh): return mesh.volume\n")
    trimesh.creation.box().export(mesh)
    own = {
        "measures": {"complexity": "mine.py:size"},
        "keep_solid": {"kind": "mesh", "mesh": "part.stl", "size": [0.3, 0.3, 0.3]},
    }
    given = "results/egad/archive.parquet"
    configs = ["config/test.yaml", clean.overlay("own.yaml", own)]
    for change in (
        lambda: measure.write_text("def size(mesh): return mesh.area\n"),
        lambda: trimesh.creation.icosphere().export(mesh),
    ):
        assert "evolve" in changed_by(change, clean, given, configs=configs)


def test_an_edited_detector_of_ones_own_tries_again(clean):
    """One that is no target too; nothing is asked of detectors that nobody wants."""
    code = "def nothing(view, gripper, rng): return []\n"
    detector = clean.folder / "mine.py"
    own = {"detectors": {name: {"detector": f"{name}.py:nothing"} for name in ("mine", "lost")}}
    wanted = {"targets": {"detectors": ["antipodal-depth", "mine"]}}
    configs = ["config/test.yaml", clean.overlay("own.yaml", own)]
    target = "results/egad/trials/egad_75mm/{}.parquet"
    for asked in (configs, [*configs, clean.overlay("wanted.yaml", wanted)]):
        detector.write_text(code)
        edit = partial(detector.write_text, code.replace("[]", "None"))
        assert changed_by(edit, clean, target.format("mine"), configs=asked) == {"simulated_trial"}
    status, said = clean.snakemake("--dry-run", target.format("lost"), configs=configs)
    assert status != 0
    assert "The detector lost cannot be used: detectors: lost.py:nothing: there is no such" in said


def test_the_labels_detector_waits_for_the_grasps(copy):
    target = "results/egad/trials/egad_75mm/labels.parquet"
    assert set(copy.planned(target)) == TRIED
    (copy.results / "egad/grasps/egad_75mm.parquet").unlink()
    assert "join_grasps" in copy.planned(target)


def test_engraved_labels_wait_for_the_grasps_that_they_keep_away_from(planned):
    engraving, others = {"engraving": True}, {"samples": 6}
    assert set(planned(print_export=engraving)) == {"print_export"} | AFTER_PRINTS
    target = f"results/egad/print/{GRIPPER}/manifest.parquet"
    assert "join_grasps" in planned(target, print_export=engraving, robust=others)
    assert planned(target, robust=others) == {}


def boxes_with_a_palm(folder):
    trimesh.creation.box([0.1, 0.06, 0.05]).apply_translation([0, 0, -0.025]).export(
        folder / "hand.stl"
    )
    return {"opening": 0.07, "mesh": "hand.stl"}


def described_hand(folder):
    box_urdf(folder / "hand.urdf")
    return {"file": "hand.urdf"}


@pytest.mark.parametrize("hand_in", [boxes_with_a_palm, described_hand])
def test_a_gripper_of_ones_own_has_targets_in_every_stage(clean, hand_in):
    hand = hand_in(clean.folder)
    own = clean.overlay("own.yaml", {"grippers": {"mine": hand}})
    stages = {
        "rescaled/mine/scales.parquet": {"rescale"},
        "graspability/mine.parquet": {"graspability"},
        "grasps/mine.parquet": {"grasp_label", "join_grasps"},
        "grasps/mine.sampling.parquet": {"grasp_label", "join_sampling"},
        "print/mine/manifest.parquet": {"print_export"},
        "trials/mine/antipodal-depth.parquet": {"simulated_trial", "join_trials"},
        "agreement/mine.parquet": {"agreement", "join_agreement"},
        "images/mine/card.md": {"render", "image_card"},
        "scenes/mine/card.md": {"scenes", "scene_card"},
        "size_effect/mine.parquet": {"size_effect"},
        "exchange/mine.hdf5": {"dexnet"},
        "exchange/mine-acronym": {"export"},
    }
    targets = [f"results/egad/{target}" for target in stages]
    told = clean.told(*targets, configs=["config/test.yaml", own])
    makers = {file: job.rule for job in told for file in job.output.split()}
    assert {job.rule for job in told} >= set().union(*stages.values())
    for target, rules in zip(targets, stages.values(), strict=True):
        assert makers[target] in rules


def test_an_edited_mesh_of_a_gripper_labels_again(clean):
    """Its objects are as large as before: the opening is given."""
    own = clean.overlay("own.yaml", {"grippers": {"mine": boxes_with_a_palm(clean.folder)}})
    palm, hand = trimesh.creation.icosphere(radius=0.03), clean.folder / "hand.stl"
    target, configs = "results/egad/grasps/mine.parquet", ["config/test.yaml", own]
    changed = changed_by(lambda: palm.export(hand), clean, target, configs=configs)
    assert changed == {"grasp_label"}


def test_a_gripper_by_file_has_objects_and_prints_of_its_opening(copy):
    hands = {"mine": described_hand(copy.folder), "boxes": {"opening": PANDA["opening"] + 2e-4}}
    configs = ["config/test.yaml", copy.overlay("own.yaml", {"grippers": hands})]
    scaled, printed = (
        [f"results/egad/{table.format(name)}.parquet" for name in hands]
        for table in ("rescaled/{}/scales", "print/{}/manifest")
    )
    chosen = copy.results / "egad/eval49.parquet"
    parquet.write(parquet.read(chosen, EVAL49).head(2), EVAL49, chosen)
    copy.make("--cores", 1, *scaled, *printed, configs=configs)
    for files, schema in ((scaled, SCALES), (printed, MANIFEST)):
        mine, boxes = (parquet.read(copy.folder / file, schema) for file in files)
        pd.testing.assert_frame_equal(mine, boxes, rtol=1e-6)
    trials = "results/egad/trials/mine/antipodal-depth.parquet"
    everything = ["--forceall", *scaled, *printed, trials]
    before = copy.told(*everything, configs=configs)
    box_urdf(copy.folder / "hand.urdf", changes={'effort="10"': 'effort="11"'})
    after = copy.told(*everything, configs=configs)
    assert {job.rule for job in after if job not in before} == {"simulated_trial"}


@pytest.mark.slow
def test_exports_are_made_if_they_are_asked_for(copy):
    asked = {"targets": {"exports": ["dexnet", "acronym"]}, "simulated_label": {"grasps": 3}}
    configs = ["config/test.yaml", copy.overlay("exports.yaml", asked)]
    planned = copy.planned(configs=configs)
    simulated = {"convex_parts": 2, "simulated_label": 2, "join_grasps": 1, "datasheet": 1}
    written = {"dexnet_objects": 2, "dexnet": 1, "export": 1, "report": 1, "all": 1}
    assert planned == simulated | written
    copy.make("--cores", 2, configs=configs)
    assert copy.planned(configs=configs) == {}
    assert (copy.results / "egad/exchange/egad_75mm.hdf5").stat().st_size > 10_000
    labels = {path.stem for path in (copy.results / "egad/exchange/egad_75mm-acronym").glob("*.h5")}
    assert labels <= {path.stem for path in (copy.results / "egad/meshes").glob("*.obj")}
    assert labels
    for setting, rules in (
        ({"dexnet": {"field_size": 24}}, {"dexnet_objects", "dexnet"}),
        ({"acronym": {"min_robust_success_rate": 0.9}}, {"export"}),
    ):
        changed = copy.overlay("changed.yaml", setting)
        assert set(copy.planned(configs=[*configs, changed])) == rules | {"report", "all"}


def test_more_epochs_extend_a_finished_run(planned):
    jobs = planned(schedule={"epochs": 4}, evolution={"evaluations": 160})
    assert (jobs["evolve"], jobs["merge"], jobs["archive"]) == (4, 2, 1)
    assert jobs["history"] == 1


def test_fewer_epochs_need_no_evolution(planned):
    made = {"archive", "ancestry", "history", "postprocess"}
    fewer = planned(schedule={"epochs": 1}, evolution={"evaluations": 40})
    assert set(fewer) == made | AFTER_POSTPROCESS


def test_random_objects_need_no_file_and_more_of_them_are_made_again(clean):
    dataset = {"source": "primitives", "objects": 3}
    random = {"shards": 1, "datasets": {"random": dataset}}
    configs = ["config/test.yaml", clean.overlay("random.yaml", random)]
    dataset["objects"] = 4
    changed = changed_by(
        lambda: clean.overlay("random.yaml", random),
        clean,
        "results/random/objects.parquet",
        configs=configs,
    )
    assert changed == {"postprocess"}


def test_a_mesh_more_makes_its_shard_again_and_those_that_it_renames(clean):
    box, folder = trimesh.creation.box(), clean.folder / "boxes"
    folder.mkdir()
    # with `name.stl` beside it, `name.obj` stays in its shard, but its object gets another name
    name = next(
        name
        for name in map(str, range(100))
        if shard_of(name, 2) == shard_of(f"{name}-obj", 2) != shard_of(f"{name}-stl", 2)
    )
    other = next(each for each in "abcdef" if shard_of(each, 2) != shard_of(name, 2))
    for each in (name, other):
        box.export(folder / f"{each}.obj")
    dataset = {"source": "meshes", "folder": "boxes", "units": "mm"}
    configs = ["config/test.yaml", clean.overlay("own.yaml", {"datasets": {"own": dataset}})]
    targets = [f"results/own/parts/solids-{shard}.parquet" for shard in (0, 1)]
    before = clean.told(*targets, configs=configs)
    for added, count in ((f"{other}.stl.obj", 1), (f"{name}.stl", 2)):
        box.export(folder / added)
        after = clean.told(*targets, configs=configs)
        assert len([job for job in after if job not in before]) == count
        (folder / added).unlink()


def test_an_evaluation_set_is_cut_into_no_more_shards_than_it_has_objects(clean):
    """It has up to 3 x 3 here."""
    many = clean.overlay("many.yaml", {"shards": 32, "targets": {"agreement": True}})
    planned = clean.planned(configs=["config/test.yaml", many])
    assert (planned["postprocess"], planned["grasp_label"]) == (32, 32)
    assert (planned["simulated_trial"], planned["agreement"]) == (9, 9)


@pytest.mark.parametrize(
    ("name", "folder"), [("ycb", "ycb"), ("egad_train", "egad"), ("egad_eval", "egad_eval")]
)
def test_datasets_of_others_are_compared_alone_or_beside_the_evolved_one(clean, name, folder):
    mesh = clean.folder / "data" / folder / "A/google_16k/nontextured.ply"
    mesh.parent.mkdir(parents=True)
    mesh.touch()
    (clean.folder / "data" / folder / "A00_0.obj").touch()
    configs = [f"config/datasets/{folder}.yaml"]
    everything = clean.planned("--replace-workflow-config", configs=configs)
    assert set(everything) == AFTER_POSTPROCESS | {"postprocess"}
    beside = clean.told("results/comparison.parquet", configs=configs)
    compared = {"evolve", "merge", "archive", "postprocess", "collect", "compare"}
    assert {job.rule for job in beside} == compared
    part = f"results/{name}/parts/"
    job = next(job for job in beside if job.rule == "postprocess" and part in job.output)
    pattern = literal_eval(job.params["dataset"])["pattern"]
    assert pattern == ("*/google_16k/nontextured.ply" if name == "ycb" else None)


def test_a_target_that_cannot_be_made_is_refused(clean):
    shapes = {"datasets": {"shapes": {"source": "primitives", "objects": 20}}}
    own, target = clean.overlay("shapes.yaml", shapes), "results/shapes/archive.parquet"
    status, said = clean.snakemake("--dry-run", "--cores", 2, target, configs=[own])
    assert status != 0
    assert "MissingRuleException" in said
    assert target in said


def test_a_wrong_configuration_stops_with_every_problem(clean):
    wrong = {"seed": "3", "evolution": {"poplation": 5}, "targets": {"grippers": ["yumy"]}}
    status, said = clean.snakemake("--cores", 2, configs=[clean.overlay("wrong.yaml", wrong)])
    assert status != 0
    for line in (
        'seed: "3" is not allowed',
        "evolution.poplation: unknown key; did you mean evolution.population?",
        "targets.grippers: 'yumy' is not defined; known: cup_15mm",
    ):
        assert line in said
    assert "Traceback" not in said
    assert not clean.results.exists()


def test_meshes_need_a_unit_unless_they_state_it_and_odd_sizes_are_said_once(clean):
    folder, target = clean.folder / "own", "results/own/objects.parquet"
    folder.mkdir()
    cube = trimesh.creation.box((60, 60, 60))
    cube.export(folder / "cube.3mf")  # says millimetres
    own = {"datasets": {"own": {"source": "meshes", "folder": "own"}}}
    configs = ["config/test.yaml", clean.overlay("own.yaml", own)]
    assert "postprocess" in clean.planned(target, configs=configs)
    for name in ("cube.ply", "block.ply"):
        cube.export(folder / name)
    status, said = clean.snakemake("--dry-run", target, configs=configs)
    assert status != 0
    assert "block.ply does not state its unit; give `units`" in said
    metres = clean.overlay("metres.yaml", {"datasets": {"own": {"units": "m"}}})
    said = clean.make("--cores", 1, target, configs=[*configs, metres])
    doubt = (
        "own: 2 of 2 meshes are smaller than 0.005 m or larger than 1 m, for example block (60 m)"
    )
    assert said.count(doubt) == 1
    assert "cannot be used; cube-3mf: the file states the unit mm, but m is given" in said


@pytest.mark.slow
def test_labelled_grasps_are_carried_out_if_that_is_asked_for(copy):
    asked = {"targets": {"agreement": True}, "agreement": {"grasps": 4}}
    configs = ["config/test.yaml", copy.overlay("agreement.yaml", asked)]
    made = {"agreement": 2, "join_agreement": 1, "report": 1, "all": 1}
    assert copy.planned(configs=configs) == made
    copy.make("--cores", 2, configs=configs)
    assert copy.planned(configs=configs) == {}
    table = parquet.read(copy.results / "egad/agreement/egad_75mm.parquet", AGREEMENT)
    assert 0 < len(table) <= 4
    assert 'id="agreement"' in (copy.results / "report.html").read_text(encoding="utf-8")
    changed = copy.overlay("changed.yaml", {"agreement": {"grasps": 5}})
    assert copy.planned(configs=[*configs, changed]) == made


@pytest.mark.slow
def test_tables_are_cleared_if_that_is_asked_for(copy):
    few = {"rounds": 2, "objects": 2, "scenes": ["pile"], "noise": ["none"]}
    asked = {"targets": {"clutter": ["antipodal-cloud", "labels"]}, "clutter": few}
    configs = ["config/test.yaml", copy.overlay("clutter.yaml", asked)]
    made = {"clutter": 4, "join_clutter": 2, "report": 1, "all": 1}
    assert copy.planned(configs=configs) == made
    copy.make("--cores", 2, configs=configs)
    assert copy.planned(configs=configs) == {}
    for detector in ("antipodal-cloud", "labels"):
        table = parquet.read(copy.results / f"egad/clutter/egad_75mm/{detector}.parquet", CLUTTER)
        assert table.groupby("round").size().index.tolist() == [0, 1]
    assert 'id="clutter"' in (copy.results / "report.html").read_text(encoding="utf-8")
    changed = copy.overlay("changed.yaml", {"clutter": {"rounds": 3}})
    assert copy.planned(configs=[*configs, changed]) == made


SEARCHED = {
    "search_failures": 2,
    "join_failures": 1,
    "explain_failures": 1,
    "report": 1,
    "all": 1,
}


def few_failures(checkout, detector="own.py:beside", **changes):
    """A configuration that asks for failures of a detector of the user's own."""
    (checkout.folder / "own.py").write_text(
        "from egad.detectors import Grasp\n\n"
        "def beside(view, gripper, rng):\n"
        "    return [Grasp((0.1, 0.1, 0.03), 0.0, gripper.opening, 0.0, 1.0)]\n"
    )
    asked = {
        "targets": {"failures": ["own"]},
        "failures": FEW | {"attempts": 8} | changes,
        "detectors": {"own": {"detector": detector}},
        "bundle": QUICK["bundle"],
    }
    return ["config/test.yaml", checkout.overlay("failures.yaml", asked)]


def test_failures_are_searched_again_for_what_decides_them(copy):
    target = f"results/egad/failures/{GRIPPER}/own.parquet"
    jobs = {"search_failures": 2, "join_failures": 1}
    assert copy.planned(target, configs=few_failures(copy)) == jobs
    assert copy.planned(target, configs=few_failures(copy, shards=3)) == jobs | {
        "search_failures": 3
    }
    own, configs = copy.folder / "own.py", few_failures(copy)
    noisier = partial(few_failures, copy, depth_noise=0.2)
    assert changed_by(noisier, copy, target, configs=configs) == set(jobs)
    edit = partial(own.write_text, own.read_text().replace("0.03", "0.02"))
    assert changed_by(edit, copy, target, configs=configs) == set(jobs)


@pytest.mark.slow
def test_failures_are_searched_if_that_is_asked_for(copy):
    """The same bytes on one core; again once the detector changes."""
    configs = few_failures(copy)
    own = copy.folder / "own.py"
    # the bundle is another one, too
    assert SEARCHED.items() <= copy.planned(configs=configs).items()
    copy.make("--cores", 2, configs=configs)
    assert copy.planned(configs=configs) == {}
    folder = copy.results / f"egad/bench/failures/{GRIPPER}"
    tables = {path.name: path.read_bytes() for path in folder.iterdir()}
    ends = (".parquet", ".examined.parquet", ".attempts.parquet", ".html", ".html.sha256")
    assert set(tables) == {f"own{end}" for end in ends}
    examined = parquet.read(folder / "own.examined.parquet", EXAMINED)
    assert set(examined["shard"]) == {0, 1}
    assert examined["attempts"].sum() >= 8
    for path in folder.iterdir():
        path.unlink()
    shutil.rmtree(copy.results / "egad/parts")
    target = f"results/egad/failures/{GRIPPER}/own.html"
    copy.make("--cores", 1, target, configs=configs)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == tables
    own.write_text(own.read_text().replace("0.03", "0.02"))
    again = {"search_failures": 2, "join_failures": 1, "explain_failures": 1}
    assert copy.planned(target, configs=configs) == again


@pytest.mark.slow
def test_labelled_grasps_are_simulated_if_that_is_asked_for(copy):
    few = {"simulated_label": {"grasps": 3}, "naive_grasp": {"grasps": 4}}
    asked = {"targets": {"simulated_labels": True}, **few}
    configs = ["config/test.yaml", copy.overlay("simulated.yaml", asked)]
    labels = {"simulated_label": 2, "join_grasps": 1, "datasheet": 1}
    rates = {"naive_grasp": 2, "join_naive_grasps": 1, "simulated_success_rate": 1}
    assert copy.planned(configs=configs) == labels | rates | {"report": 1, "all": 1}
    copy.make("--cores", 2, configs=configs)
    assert copy.planned(configs=configs) == {}
    grasps = parquet.read(copy.results / "egad/grasps/egad_75mm.parquet", SIMULATED_GRASPS)
    objects = parquet.read(copy.results / "egad/simulated/egad_75mm.parquet", SIMULATED_OBJECTS)
    assert objects["n_simulated"].sum() == grasps["simulated_outcome"].notna().sum() > 0
    assert objects["n_simulated"].max() == 3
    assert set(objects["n_free"]) == set(objects["n_table"]) == {4}
    for name in ("simulated_success_rate", "table_success_rate"):
        assert objects[name].between(0, 1).all()


def test_scenes_are_made_if_that_is_asked_for(copy):
    asked = {"targets": {"scenes": True}, "scenes": {"scenes": 120}}
    configs = ["config/test.yaml", copy.overlay("scenes.yaml", asked)]
    parts = {"convex_parts": 2, "join_convex_parts": 1}
    made = {"scenes": 3, "scene_card": 1, "report": 1, "all": 1}
    assert copy.planned(configs=configs) == parts | made
    folder = "results/egad/scenes/egad_75mm"
    told = [job for job in copy.told(f"{folder}/card.md", configs=configs) if job.rule == "scenes"]
    assert {job.output for job in told} == {
        f"{folder}/scenes-{number}.parquet {folder}/grasps-{number}.parquet" for number in range(3)
    }


def test_images_are_rendered_if_that_is_asked_for(copy):
    asked = {"targets": {"render": True}, "render": {"images": 501}}
    configs = ["config/test.yaml", copy.overlay("render.yaml", asked)]
    made = {"render": 2, "image_card": 1, "report": 1, "all": 1}
    assert copy.planned(configs=configs) == made


RELEASE = {"release_tables", "release_meshes", "release_previews", "release_archive"}
RELEASE |= {"gallery", "release_card", "release"}


def test_a_release_simulates_the_grasps_of_its_gripper_only(clean):
    planned = clean.planned("release", configs=())
    assert set(planned) >= RELEASE
    assert planned["simulated_label"] == planned["grasp_label"] == Settings().shards
    assert not {"report", "simulated_trial", "bundle", "join_grasps"} & set(planned)


def test_a_release_of_given_objects_has_their_ancestors_only_if_they_are_known(clean):
    no_extra = clean.overlay("no_extra.yaml", {"release": {"archives": ["urdf", "mjcf"]}})
    released = clean.planned("release", configs=["config/released.yaml", no_extra])
    assert set(released) >= RELEASE
    assert not {"evolve", "ancestry"} & set(released)
    primitives = {
        "datasets": {"shapes": {"source": "primitives", "objects": 20}},
        "release": {"dataset": "shapes", "gripper": "egad_75mm"},
    }
    planned = clean.planned("release", configs=[clean.overlay("shapes.yaml", primitives)])
    assert set(planned) >= RELEASE
    assert not {"evolve", "ancestry"} & set(planned)
