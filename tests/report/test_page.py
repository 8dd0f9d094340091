import base64
import json
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.report.pictures import png_bytes, render
from egad.tables import parquet
from egad.tables.evaluation import TRIALS
from egad.tables.grasping import GRASPS, SIZE_EFFECT
from egad.tables.objects import OBJECTS, REJECTED
from egad_workflow.report_page import DatasetReport, ReportData, build
from egad_workflow.settings import Settings

VOID = {"meta", "img", "br", "stop", "rect", "image", "link", "input", "hr"}


class Page(HTMLParser):
    """Collects what a page refers to, its ids, and whether its tags close."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.ids: list[str] = []
        self.tags: Counter[str] = Counter()
        self.classes: Counter[str] = Counter()
        self.open: list[str] = []
        self.text: list[str] = []
        self.data: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.tags[tag] += 1
        self.classes.update((values.get("class") or "").split())
        self.references += [values[name] for name in ("src", "href") if name in values]
        self.ids += [values["id"]] if "id" in values else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["script"]:
            self.data.append(data)
        elif self.open[-1:] != ["style"]:
            self.text.append(data)

    def words(self) -> str:
        return " ".join(" ".join(self.text).split())


def cells(page: Page) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    text = next(text for text in page.data if text.startswith('{"across"'))
    return json.loads(text, parse_constant=refuse)["cells"]


@pytest.fixture(scope="module")
def html(report_html) -> str:
    return report_html


@pytest.fixture(scope="module")
def page(html) -> Page:
    return Page(html)


def test_the_page_needs_nothing_else(html, page):
    assert not page.open
    assert all(reference.startswith(("data:", "#")) for reference in page.references)
    assert "@import" not in html
    assert "url(" not in html.replace("url(#scale", "").replace("url(#hatch", "")
    assert "default-src 'none'" in html


def test_the_same_report_gives_the_same_bytes(html, report):
    copied = replace(
        report,
        datasets={
            name: replace(data, objects=data.objects.copy(), rejected=data.rejected.copy())
            for name, data in report.datasets.items()
        },
    )
    assert build(copied) == html


def test_the_map_has_every_cell_and_picture(page, report, objects, pictures):
    space = report.settings.space
    filled = sum(
        data.objects.groupby(["complexity_cell", "difficulty_cell"]).ngroups
        for data in report.datasets.values()
    )
    assert page.classes["empty"] == 2 * space.cells**2
    assert page.classes["cell"] == filled
    best = objects.sort_values("diversity").drop_duplicates(
        ["complexity_cell", "difficulty_cell"], keep="last"
    )
    assert page.tags["image"] == len(best)
    shown = {reference.partition(",")[2] for reference in page.references}
    for label in best["label"]:
        assert base64.b64encode(pictures[label]).decode() in shown


def test_a_cell_tells_its_most_diverse_objects(page, objects, pictures):
    for name, cell in cells(page).items():
        letter, column = ord(name[0]) - 65, int(name[1:])
        inside = objects[
            (objects["difficulty_cell"] == letter) & (objects["complexity_cell"] == column)
        ].sort_values("diversity", ascending=False)
        assert [item[0] for item in cell["items"]] == inside["label"].head(4).tolist()
        assert len(cell["items"]) + cell["more"] == len(inside)
        assert cell["items"][0][7] is None
        for item in cell["items"][1:]:
            assert base64.b64decode(item[7]) == pictures[item[0]]


def test_a_click_on_an_object_of_the_set_leads_to_it_in_the_viewer(page, html, evalset):
    data = next(json.loads(text) for text in page.data if '"finger"' in text)
    assert [item["name"] for item in data["objects"]] == evalset["label"].tolist()
    assert page.classes["viewer"] == 1
    assert page.ids.count("viewer-egad") == 1
    for name in evalset["label"]:
        assert f'data-viewer="viewer-egad" data-object="{name}"' in html


def test_key_numbers(page):
    words = page.words()
    assert "Trial success of antipodal-depth with egad_75mm 38 % 0\N{EN DASH}75" in words
    assert "Evaluation set 3 of 49 Objects 40 Corrected coverage 1.6 %" in words
    assert "15 of 40 attempts on 2 objects" in words
    assert words.count("38 %") == 1
    assert "EGAD, 2020 published 2 331 93 % \N{EN DASH} \N{EN DASH} 0.07 0.27 0.19" in words
    assert "Dex-Net 2.0 published 1 497 37 % \N{EN DASH} \N{EN DASH} 0.03 0.26 0.11" in words
    assert "b postprocess no volume" in words


def test_rows_in_which_no_object_is_expected_are_hatched_and_named(page, html, report):
    words = page.words()
    assert html.count('fill="url(#hatch-') == len(report.datasets)
    assert "Hatched: no object is expected in rows A and B." in words
    assert "It would have to be 3.72 \N{MULTIPLICATION SIGN}10" in words
    assert "A grasp has at most 3.93" in words
    assert "so coverage can be 92 % at most" in words
    assert "Coverage without rows A and B" in words
    assert "egad 40 1.6 % 1.7 %" in words


def test_every_setting_is_listed(page, report):
    words = page.words()
    assert "seed 11 default 0 seed of all random numbers" in words
    for name, field in Settings.model_fields.items():
        assert name in words
        for key in getattr(field.annotation, "model_fields", {}):
            assert key in words, key
    for name in [*report.settings.grippers, *report.versions]:
        assert name in words


def test_settings_are_folded_except_those_that_were_changed(html):
    section = html[html.index('id="parameters"') :]
    before, _, folded = section.partition('<details class="settings">')
    assert "<code>seed</code>" in before
    assert "<code>datasets.mine</code>" in before
    assert "source: primitives, objects: 12" in before
    assert "crossover_probability" not in before
    assert "crossover_probability" in folded.partition("</details>")[0]


@pytest.fixture
def own(report):
    """The first ten objects of the run as a user's meshes, of which three are in the set."""
    meshes = {"mine": {"source": "meshes", "folder": "parts", "units": "mm"}}
    settings = Settings.model_validate({**report.settings.model_dump(), "datasets": meshes})
    egad = report.datasets["egad"]
    labels = egad.objects["label"].iloc[[*range(8), 20, 21]]
    objects = egad.objects[egad.objects["label"].isin(labels)]
    data = replace(egad, objects=objects, history=None)
    return replace(report, settings=settings, datasets={"mine": data})


def test_own_meshes_are_listed_and_not_mapped(own, evalset):
    text = build(own)
    page = Page(text)
    assert {"objects", "trials", "rejected"} <= set(page.ids)
    assert not {"map", "evaluation", "comparison"} & set(page.ids)
    assert "overage" not in page.words()
    table = pd.read_html(StringIO(text[text.index('class="cards"') - 7 :]))[0]
    rows = table.set_index(table.columns[1]).astype(str)
    objects = own.datasets["mine"].objects
    assert rows.index.tolist() == objects["label"].tolist()
    labels = dict(zip(evalset["label"], evalset["object_label"], strict=True))
    assert rows.loc[labels["A0"], "successes"] == "15 of 20"
    assert rows.loc[labels["G6"], "successes"] == "\N{EN DASH}"
    assert rows.loc[labels["C4"], "in the set"] == "C4"
    assert (rows["in the set"] == "\N{EN DASH}").sum() == len(objects) - 3
    assert rows.loc[objects["label"].iloc[0], "scale"] == "0.8"


def test_names_from_files_are_escaped(report):
    data = report.datasets["egad"]
    strange = data.objects.assign(id="</script><script>alert(2)</script>")
    listed = DatasetReport(strange, data.rejected, data.pictures)
    html = build(replace(report, datasets={"egad": listed}))
    assert "<script>alert" not in html
    assert "</script><script>" not in html
    found = cells(Page(html))
    assert next(iter(found.values()))["items"][0][1] == "</script><script>alert(2)</script>"


def test_a_compared_dataset_has_a_map_and_no_more(report):
    page = Page(build(replace(report, datasets={"mine": report.datasets["mine"]})))
    assert {"map", "comparison", "rejected"} <= set(page.ids)
    assert not {"evaluation", "grasps", "trials"} & set(page.ids)
    assert page.tags["image"] == 0
    assert "No object was left out" in page.words()


def test_datasets_without_objects_or_diversity(report):
    none = DatasetReport(parquet.empty(OBJECTS), parquet.empty(REJECTED))
    lonely = report.datasets["mine"].objects.head(1).assign(diversity=np.nan)
    alone = DatasetReport(lonely, parquet.empty(REJECTED))
    page = Page(build(replace(report, datasets={"egad": none, "mine": alone})))
    assert "The dataset egad holds no objects" in page.words()
    assert page.classes["cell"] == 1
    assert [json.loads(text, parse_constant=pytest.fail)["cells"] for text in page.data[:2]][1]


def test_tables_without_rows_count_as_absent(report, evalset):
    data = replace(
        report.datasets["egad"],
        evalset=evalset.head(0),
        grasps={"yumi": parquet.empty(GRASPS)},
        scales={},
        size_effects={"yumi": parquet.empty(SIZE_EFFECT)},
        manifests={},
        trials={("yumi", "antipodal-depth"): parquet.empty(TRIALS)},
    )
    page = Page(build(replace(report, datasets={"egad": data})))
    assert not {"evaluation", "grasps", "trials"} & set(page.ids)


def test_nine_hundred_pictures_stay_below_six_megabytes(report, objects):
    knot = trimesh.creation.torus(1, 0.35)
    knot.vertices += 0.05 * np.sin(9 * knot.vertices[:, [1, 2, 0]])
    picture = png_bytes(render(knot, 96))
    assert len(picture) > 2000
    many = objects.loc[np.arange(900) % len(objects)].reset_index(drop=True)
    number = np.arange(900)
    many = many.assign(
        complexity_cell=number % 225 % 25,
        difficulty_cell=number % 225 // 25,
        label=[f"X{index}" for index in number],
    )
    data = DatasetReport(
        many, report.datasets["egad"].rejected, dict.fromkeys(many["label"], picture)
    )
    whole = ReportData(report.settings, report.comparison, {"egad": data}, {})
    assert 900 * len(picture) < len(build(whole)) < 6e6
