"""The description of a release, from a web server and beside the files, and its card."""

import hashlib
import json
import threading
import urllib.request
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pandas as pd
import pytest
import yaml

from egad.exchange.release import OTHER_FILES, RAI, TABLES, croissant_json
from egad.exchange.release import tables as release_files
from egad.exchange.release.dataset_card import front_matter
from egad.tables import parquet

ROWS = 3


@pytest.fixture
def release(tmp_path):
    for table in TABLES:
        rows = pd.concat([parquet.empty(table.schema)] * 2).reindex(range(ROWS))
        rows.to_parquet(tmp_path / table.pattern.removeprefix("data/"))
    (tmp_path / "data").mkdir()
    for path in tmp_path.glob("*.parquet"):
        path.rename(tmp_path / "data" / path.name)
    return tmp_path


class Handler(SimpleHTTPRequestHandler):
    def log_message(self, *words):
        """Nothing is printed."""


@pytest.fixture
def url(release):
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(release)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()


def write(release, url=None):
    about = {"name": "tiny", "version": "1.0.0", "url": url, "license": "x", **RAI}
    about |= {"description": "d", "datePublished": "2026-01-01", "citeAs": "c"}
    sums = {
        each.pattern: hashlib.sha256((release / each.pattern).read_bytes()).hexdigest()
        for each in TABLES
    }
    text = croissant_json(about, TABLES, OTHER_FILES[:1], sums)
    (release / "croissant.json").write_text(text)
    return json.loads(text)


def table_files(whole):
    """The file of each table, as the description has it."""
    by_id = {each["@id"]: each for each in whole["distribution"]}
    sources = {
        each["@id"]: {field["source"]["fileObject"]["@id"] for field in each["field"]}
        for each in whole["recordSet"]
    }
    return {name: by_id[found] for name, (found,) in sources.items()}


@pytest.mark.parametrize("end", ["", "/", "/index.html"])
def test_tables_of_a_hosted_release_are_at_their_addresses(release, url, end):
    files = table_files(write(release, url + end))
    assert files.keys() == {"objects", "grasps", "evaluation_set"}
    for file in files.values():
        content = urllib.request.urlopen(file["contentUrl"]).read()  # noqa: S310
        assert hashlib.sha256(content).hexdigest() == file["sha256"]


def test_tables_of_a_dataset_on_the_hub_are_in_its_repository(release):
    files = table_files(write(release, "https://huggingface.co/datasets/me/egad"))
    address = "https://huggingface.co/datasets/me/egad/resolve/main/data/objects.parquet"
    assert files["objects"]["contentUrl"] == address


def test_tables_of_other_releases_are_beside_the_description(release):
    whole = write(release)
    for file in table_files(whole).values():
        content = (release / file["contentUrl"]).read_bytes()
        assert hashlib.sha256(content).hexdigest() == file["sha256"]
    assert whole["rai:dataLimitations"]


@pytest.mark.parametrize("hosted", [True, False])
def test_mlcroissant_reads_the_tables(release, url, hosted):
    mlcroissant = pytest.importorskip("mlcroissant")
    write(release, url if hosted else None)
    place = f"{url}/croissant.json" if hosted else release / "croissant.json"
    dataset = mlcroissant.Dataset(jsonld=place)
    assert not dataset.metadata.issues.errors
    assert dataset.metadata.data_limitations == RAI["rai:dataLimitations"]
    for table in TABLES:
        assert len(list(dataset.records(table.name))) == ROWS


def test_no_folder_has_more_files_than_the_hub_takes():
    labels = [f"L{number}" for number in range(20_001)]
    for count in (10_000, 10_001, 20_001):
        table = release_files.with_files(pd.DataFrame({"label": labels[:count]}), labels[:count])
        for column in ("mesh", "preview"):
            assert table[column].is_unique
            folders = table[column].str.rpartition("/")[0]
            assert folders.value_counts().max() <= 10_000
            assert (folders.nunique() == 1) == (count == 10_000)
    assert table["mesh"].iloc[-1] == "meshes/02/L20000.glb"


@pytest.mark.parametrize(
    ("rows", "category"),
    [(999, "n<1K"), (1000, "1K<n<10K"), (999_999, "100K<n<1M"), (11_000_000, "10M<n<100M")],
)
def test_the_size_is_a_category_of_hugging_face(rows, category):
    assert yaml.safe_load(front_matter("Name", 100, rows - 100))["size_categories"] == [category]
