"""The gallery of a small dataset on disk, read as the page reads it."""

import json
import re
import shutil
import subprocess
from functools import partial
from pathlib import Path
from urllib.parse import quote, unquote

import gallery
import pandas as pd
import pyarrow as pa
import pytest
import trimesh
from partial_tables import write_rows

import egad
from egad.data import released
from egad.exchange.release import Gallery
from egad.exchange.release import tables as release_files
from egad.measures import MeasureSpace
from egad.report.gallery import page as gallery_files
from egad.report.viewer import STEPS
from egad.tables import parquet
from egad.tables.columns import LABEL
from egad.tables.evolution import ARCHIVE, LINEAGE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(space=MeasureSpace(cells=5)), Gallery, "egad_75mm")
HOSTILE = "a#b?c%41 & <b>'\"é"


def read(folder: Path, name: str) -> dict:
    """The data of a script, which must be called what the page asks for."""
    found = re.fullmatch(r"egadData\((.*)\);\n", (folder / f"{name}.js").read_text("utf-8"))
    called, data = json.loads(f"[{found[1]}]")
    assert called == name
    return data


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    """A released object with the line of its first parents, and a box with a hostile name."""
    folder = tmp_path_factory.mktemp("dataset")
    known = egad.load()
    line = next(line for each in known if len(line := known.lineage.line(each.id)) == 3)
    related = known.lineage.table[known.lineage.table["id"].isin(line)]
    parents = [[each for each in ids if each in line] for ids in related["parents"]]
    parquet.write(related.assign(parents=parents), LINEAGE, folder / "ancestry.parquet")
    elites = parquet.read(released(), ARCHIVE)
    parquet.write(elites[elites["id"] == line[0]], ARCHIVE, folder / "archive.parquet")
    (folder / "meshes").mkdir()
    known[line[0]].mesh.export(folder / "meshes" / "M01_0.obj")
    trimesh.creation.box([0.03, 0.04, 0.05]).export(folder / "meshes" / f"{HOSTILE}.obj")
    objects = pd.DataFrame({"id": [line[0], "../../x"], "label": ["M01_0", HOSTILE]})
    write_rows(OBJECTS, objects, folder / "objects.parquet")
    return folder


def make(dataset: Path, site: Path, **more) -> Path:
    """Write the gallery into a folder."""
    tables = dataset / "objects.parquet", dataset / "meshes"
    gallery.run(SETTINGS, *tables, site / "gallery", site / "index.html", **more)
    return site


def lineage(dataset: Path) -> dict[str, Path]:
    return {name: dataset / f"{name}.parquet" for name in ("archive", "ancestry")}


@pytest.fixture(scope="module")
def site(dataset, tmp_path_factory) -> Path:
    """The gallery in a folder with some files of a release."""
    site = tmp_path_factory.mktemp("site")
    for name in ("meshes", "archives", "data/grasps"):
        (site / name).mkdir(parents=True)
    (site / "README.md").touch()
    (site / "meshes" / f"{HOSTILE}.glb").touch()
    (site / "archives" / "usd.zip").touch()
    table = site / "data" / "grasps" / "train.parquet"
    write_rows(pa.schema([LABEL]), [{"label": HOSTILE}] * 2, table)
    pieces, archives = [site / "data", site / "meshes"], [site / "archives" / "usd.zip"]
    return make(dataset, site, pieces=pieces, archives=archives, **lineage(dataset))


def test_all_that_the_page_can_load_is_there(site):
    index = read(site / "gallery", "index")
    for label, rank in zip(index["columns"]["label"], index["columns"]["rank"], strict=True):
        assert (site / index["sheets"][rank]).is_file()
        relatives = read(site / "gallery", f"objects/{label}")["relatives"]
        assert (relatives is None) == (label == HOSTILE)
    entries = [entry for each in relatives_of(site, "objects/M01_0").values() for entry in each]
    ancestors = [entry for entry in entries if isinstance(entry, list)]
    assert len(ancestors) == 3  # of the line two, and the parent again
    for name, number in ancestors:
        page = read(site / "gallery", f"ancestors/{number}")
        assert page["id"] == name
        assert page["scene"]["counts"][0] > 0  # its genome still gives the shape with this id
        assert page["genome"]["drawing"].startswith("<svg")
        assert "output = " in page["genome"]["text"]
    assert (site / "gallery" / "sheets" / "ancestors-0.webp").is_file()


def relatives_of(site: Path, name: str) -> dict:
    return read(site / "gallery", name)["relatives"]


def test_links_to_the_release_resolve(site):
    html = (site / "index.html").read_text("utf-8")
    whole = re.findall(r'href="([^"#]+)"', html)
    own = [link for _, link in read(site / "gallery", f"objects/{HOSTILE}")["links"]]
    assert len(whole) == 2
    assert len(own) == 2
    for link in whole + own:
        assert (site / unquote(link)).is_file()
        assert not re.search(r"[#?&<'\" ]", link)
    assert read(site / "gallery", "objects/M01_0")["links"] == []


def test_nothing_is_written_outside_the_folder(site):
    files = {path.relative_to(site).parts[0] for path in site.rglob("*")}
    assert files == {"README.md", "archives", "data", "gallery", "index.html", "meshes"}
    assert not list(site.parent.glob("x*"))


def shown_by_browser(site: Path, profile: Path, fragment: str) -> str:
    """The page from disk after its scripts have run."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    address = f"{(site / 'index.html').as_uri()}#{fragment}"
    place = f"--user-data-dir={profile}"
    command = ["chromium", *options, place, "--virtual-time-budget=5000", "--dump-dom"]
    return subprocess.run(
        [*command, address], capture_output=True, check=True, text=True, timeout=60
    ).stdout


@pytest.mark.skipif(not shutil.which("chromium"), reason="chromium is not installed")
def test_a_browser_finds_the_files_of_many_objects(dataset, tmp_path, monkeypatch):
    for module in (release_files, gallery_files):
        monkeypatch.setattr(module, "MAX_FILES", 1)
    site = make(dataset, tmp_path / "site", **lineage(dataset))
    folders = [path for path in (site / "gallery/objects").iterdir() if path.is_dir()]
    assert [len(list(path.iterdir())) for path in folders] == [1, 1]
    (ancestor,) = (site / "gallery/ancestors/01").iterdir()
    assert ancestor.name == "1.js"
    second = json.loads(ancestor.read_text().split(",", 1)[1].removesuffix(");\n"))
    for fragment, name in (("M01_0", "M01_0"), ("ancestor=1", second["id"])):
        html = shown_by_browser(site, tmp_path / "profile", fragment)
        assert re.search(r'<h2 id="name"[^>]*>(.*?)</h2>', html)[1] == name
        assert re.search(r'<p id="trouble"[^>]*hidden', html)


@pytest.mark.skipif(not shutil.which("chromium"), reason="chromium is not installed")
def test_a_browser_shows_what_the_address_names(site, tmp_path):
    shown = partial(shown_by_browser, site, tmp_path / "profile")
    html = shown(quote(HOSTILE))
    assert "<b>&#39;" not in html
    heading = re.search(r'<h2 id="name"[^>]*>(.*?)</h2>', html)[1]
    assert heading == HOSTILE.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert re.search(r'<p id="trouble"[^>]*hidden', html)
    html = shown(f"text={quote('M01')}")
    assert re.search(r'<h2 id="count"[^>]*>1 object</h2>', html)
    assert 'href="#M01_0"' in html
    (site / "elsewhere.js").write_text("document.title = 'run'", "utf-8")
    html = shown("ancestor=../../elsewhere")
    (site / "elsewhere.js").unlink()
    assert "<title>run</title>" not in html
    html = shown("ancestor=0")
    assert read(site / "gallery", "ancestors/0")["id"][:8] in html


def test_the_same_tables_give_the_same_bytes(site, dataset, tmp_path):
    again = make(dataset, tmp_path, **lineage(dataset), jobs=1)
    for path in sorted((site / "gallery" / "ancestors").iterdir()):
        assert path.read_bytes() == (again / "gallery" / "ancestors" / path.name).read_bytes()
    for name in ("index.js", "objects/M01_0.js", "sheets/0.webp", "sheets/ancestors-0.webp"):
        assert (site / "gallery" / name).read_bytes() == (again / "gallery" / name).read_bytes()


def test_objects_that_cannot_be_scaled_are_shown_as_they_are(dataset, tmp_path):
    scaled = tmp_path / "rescaled"
    scaled.mkdir()
    trimesh.creation.box([0.015, 0.02, 0.025]).export(scaled / "M01_0.obj")
    write_rows(SCALES, [{"label": "M01_0", "factor": 0.5}], scaled / "scales.parquet")
    made = make(dataset, tmp_path / "site", gripper="panda", scales=scaled / "scales.parquet")
    index, other = (read(made / "gallery", f"objects/{each}") for each in ("M01_0", HOSTILE))
    assert index["scene"]["step"] * STEPS == pytest.approx(0.025)
    assert other["scene"]["step"] * STEPS == pytest.approx(0.05)
    assert "panda" in other["note"]
    assert index["relatives"] is index["labels"] is None
