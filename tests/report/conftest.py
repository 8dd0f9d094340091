"""A small made-up run: 40 objects in 25 cells, an evaluation set, grasps and trials."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from chromium import CHROMIUM, PHONE, QUIET
from partial_tables import fill_columns

from egad.measures.grid import complexity_cells, difficulty_cells, labels
from egad.report.pictures import png_bytes, render
from egad.report.viewer import GraspScene
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import AGREEMENT, EVAL49, MANIFEST, TRIALS
from egad.tables.evolution import HISTORY
from egad.tables.grasping import GRASPS, SCALES, SIZE_EFFECT
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.datasets import DatasetSection
from egad_workflow.report_page import DatasetReport, ReportData, build
from egad_workflow.settings import Settings


@pytest.fixture(scope="session")
def settings() -> Settings:
    return Settings(
        seed=11,
        datasets={
            "egad": DatasetSection(source="evolved"),
            "mine": DatasetSection(source="primitives", objects=12),
        },
    )


def made_objects(settings: Settings, count: int, seed: int) -> pd.DataFrame:
    random = np.random.default_rng(seed)
    complexity, graspability = random.uniform(1, 5, count), random.uniform(0.0005, 0.004, count)
    frame = pd.DataFrame(
        {
            "id": [f"{seed}-{index}" for index in range(count)],
            "complexity": complexity,
            "graspability": graspability,
            "graspability_std": 0.00002,
            "cell_confidence": random.uniform(0.5, 1, count),
            "complexity_cell": complexity_cells(complexity, settings.space),
            "difficulty_cell": difficulty_cells(graspability, settings.space),
            "diversity": random.uniform(0.1, 0.3, count),
        }
    )
    frame["label"] = labels(frame["complexity_cell"], frame["difficulty_cell"])
    return fill_columns(OBJECTS, frame)


@pytest.fixture(scope="session")
def objects(settings: Settings) -> pd.DataFrame:
    """40 objects, the last five in one cell."""
    frame = made_objects(settings, 40, 1)
    crowd = ["complexity", "graspability", "complexity_cell", "difficulty_cell"]
    frame.loc[35:, crowd] = frame.loc[35, crowd].to_list()
    frame["label"] = labels(frame["complexity_cell"], frame["difficulty_cell"])
    return frame


@pytest.fixture(scope="session")
def pictures(objects: pd.DataFrame) -> dict[str, bytes]:
    """A different box for each object."""
    sides = [(1, 1 + index / 20, 0.5) for index in range(len(objects))]
    drawn = [png_bytes(render(trimesh.creation.box(side), 32)) for side in sides]
    return dict(zip(objects["label"], drawn, strict=True))


@pytest.fixture(scope="session")
def evalset(objects: pd.DataFrame) -> pd.DataFrame:
    chosen = objects.iloc[[3, 7, 20]].rename(columns={"label": "object_label"})
    named = chosen.assign(label=["A0", "C4", "G6"], row=[0, 2, 6], column=[0, 4, 6], nearest=0.2)
    return fill_columns(EVAL49, named[named.columns.intersection(EVAL49.names)])


@pytest.fixture(scope="session")
def trials() -> pd.DataFrame:
    """A0 succeeds in 15 of 20 attempts, C4 in none; G6 was not tried."""
    success = [True] * 15 + [False] * 5 + [False] * 20
    frame = pd.DataFrame(
        {
            "label": ["A0"] * 20 + ["C4"] * 20,
            "success": success,
            "outcome": ["success"] * 15 + ["slipped"] * 5 + ["missed"] * 12 + ["no_grasp"] * 8,
        }
    )
    return fill_columns(TRIALS, frame)


@pytest.fixture(scope="session")
def agreement() -> pd.DataFrame:
    """Robust quality predicts all, nominal quality nothing; two grasps at C4 collide."""
    success = np.tile([True, False], 20)
    frame = pd.DataFrame({"label": ["A0"] * 20 + ["C4"] * 20, "success": success})
    outcome = np.where(success, "success", "dropped").astype(object)
    outcome[[21, 23]] = "collided"
    ratings = {
        "quality": 0.0,
        "robust_quality": np.where(success, 0.002, 0.001),
        "robust_success_rate": 0.5,
    }
    return fill_columns(
        AGREEMENT, frame.assign(outcome=outcome, n_labelled=50, n_collision_free=30, **ratings)
    )


@pytest.fixture(scope="session")
def clutter(evalset) -> pd.DataFrame:
    """Two rounds of piles: one object of two is removed, and then nothing."""
    first, second = evalset["id"].iloc[:2]
    frame = pd.DataFrame(
        {
            "scene": "pile",
            "noise": "none",
            "round": [0, 0, 0, 1, 1],
            "attempt": [0, 1, 2, 0, 1],
            "n_objects": 2,
            "present": [f"{first} {second}", second, second, *[f"{first} {second}"] * 2],
            "success": [True, False, False, False, False],
            "outcome": ["success", "missed", "collided", "missed", "missed"],
            "id": [first, second, second, first, first],
        }
    )
    return fill_columns(CLUTTER, frame)


@pytest.fixture(scope="session")
def history(settings: Settings) -> pd.DataFrame:
    """Three steps of ten offspring that fill one cell after another."""
    cells = [bytes([1] * step + [0] * (settings.space.cells**2 - step)) for step in (1, 2, 3)]
    frame = pd.DataFrame({"step": range(3), "offspring": 10, "refined": 4, "cells": cells})
    return fill_columns(HISTORY, frame.assign(coverage=0.1, filled_cells=0.1, qd_score=1.0))


@pytest.fixture(scope="session")
def grasps(objects: pd.DataFrame) -> pd.DataFrame:
    random = np.random.default_rng(3)
    names = np.repeat(objects["label"].to_numpy(), 10)
    frame = pd.DataFrame(
        {
            "label": names,
            "quality": random.uniform(0, 0.004, len(names)),
            "robust_quality": random.uniform(0, 0.002, len(names)),
            "robust_success_rate": 0.5,
            "collision_free": np.arange(len(names)) % 4 == 0,
        }
    )
    return fill_columns(GRASPS, frame)


@pytest.fixture(scope="session")
def size_effect() -> pd.DataFrame:
    """Two objects at three sizes: the second has grasps in only one repetition at the last."""
    keys = [
        (n, f, r, p) for n in ("A0", "G6") for f in (0.5, 1, 1.2) for r in (0, 1) for p in (65, 85)
    ]
    frame = pd.DataFrame(keys, columns=["name", "fraction", "repeat", "percentile"])
    quality = (frame["percentile"] + frame["repeat"]) / 5e4 / frame["fraction"]
    none = (frame["name"] == "G6") & (frame["fraction"] == 1.2) & (frame["repeat"] == 1)
    known = frame.assign(quality=quality.mask(none), candidates=200, possible=50, grasps=20)
    return fill_columns(SIZE_EFFECT, known)


@pytest.fixture(scope="session")
def report(
    settings, objects, pictures, evalset, grasps, trials, clutter, agreement, history, size_effect
) -> ReportData:
    rejected = pd.DataFrame(
        {
            "id": ["<script>alert(1)</script>", "b", "c"],
            "stage": ["postprocess", "postprocess", "simulated-trial"],
            "reason": ["no volume", "no volume", "no grasps & no parts"],
        }
    )
    scales = pd.DataFrame(
        {"label": objects["label"], "rule": "paper", "opening": 0.075, "factor": 1.0}
    )
    scales.loc[:9, "factor"] = 0.8
    manifest = pd.DataFrame({"label": ["A0", "C4", "G6"], "plate": [1.0, 2.0, np.nan]})
    full = DatasetReport(
        objects,
        rejected,
        pictures,
        evalset,
        grasps={"egad_75mm": grasps, "yumi": grasps.head(100)},
        scales={"egad_75mm": fill_columns(SCALES, scales)},
        size_effects={"egad_75mm": size_effect},
        scenes=[
            GraspScene(name, label, trimesh.creation.box([0.03, 0.04, 0.05]), grasps.head(10))
            for name, label in zip(evalset["label"], evalset["object_label"], strict=True)
        ],
        manifests={"egad_75mm": fill_columns(MANIFEST, manifest)},
        trials={("egad_75mm", "antipodal-depth"): trials},
        clutter={"egad_75mm": {"antipodal-cloud": clutter}},
        clutter_pictures={"egad_75mm": {"pile": [next(iter(pictures.values()))]}},
        agreement={"egad_75mm": agreement},
        history=history,
    )
    compared = DatasetReport(made_objects(settings, 12, 2), parquet.empty(REJECTED))
    comparison = pd.DataFrame(
        {
            "dataset": ["egad", "mine"],
            "objects": [40, 12],
            "coverage": [0.016, 0.0048],
            "attainable_coverage": [0.0174, 0.0052],
            "filled_cells": [0.0576, 0.0192],
            "diversity_min": [0.1, 0.12],
            "diversity_max": [0.3, 0.28],
            "diversity_mean": [0.2, 0.21],
        }
    )
    return ReportData(
        settings, comparison, {"egad": full, "mine": compared}, {"python": "3.11.7", "egad": "0.1"}
    )


@pytest.fixture(scope="session")
def report_html(report: ReportData) -> str:
    return build(report)


@pytest.fixture(scope="module")
def chromium():
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as started:
        yield started.chromium


@pytest.fixture
def browser(chromium, tmp_path):
    """Start a browser that keeps what pages store in a folder: again, if it has the same name.

    Nothing that a page does may fail or ask the network.
    """
    opened, wrong = [], []

    def start(name="phone", **options):
        context = chromium.launch_persistent_context(
            tmp_path / name, executable_path=CHROMIUM, args=QUIET, **(PHONE | options)
        )
        context.on("weberror", lambda each: wrong.append(each.error))
        context.on("console", lambda each: wrong.append(each.text))
        context.on("request", lambda each: asked(each.url))
        context.set_default_timeout(5000)
        context.clock.install()
        opened.append(context)
        return context

    def asked(address):
        if not address.startswith(("file:", "data:", "blob:")):
            wrong.append(address)

    yield start
    for context in opened:
        context.close()
    assert not wrong
