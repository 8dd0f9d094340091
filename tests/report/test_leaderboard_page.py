"""The leaderboard in Chromium: `make browser`."""

import numpy as np
import pytest
from chromium import IN_CHROMIUM, STANDARDS
from partial_tables import fill_columns

from egad.bench.reproduction import Reproduction
from egad.report.leaderboard import Board, Protocol, Refusal, SubmittedTable, page
from egad.tables.evaluation import TRIALS

playwright = pytest.importorskip("playwright.sync_api")
pytestmark = IN_CHROMIUM
FILMS = {"A0, attempt 0": "films/a.gif"}
ABOUT = {
    "detector": "mine",
    "by": "us",
    "hardware": "a computer",
    "paper": "a paper",
    "link": "https://example.org/mine",
    "sees": "a depth image",
    "seconds": 0.25,
    "license": "CC-BY-4.0",
    "reference": None,
}


def attempts(rate, engine):
    """Four attempts at each of the 49 objects."""
    labels = [f"{letter}{digit}" for letter in "ABCDEFG" for digit in range(7)]
    won = np.random.default_rng(0).random((len(labels), 4)) < rate
    rows = [
        {"label": label, "id": label, "attempt": number, "engine": engine}
        | {"success": bool(each), "outcome": "success" if each else "slipped_lifting"}
        for label, own in zip(labels, won, strict=True)
        for number, each in enumerate(own)
    ]
    return fill_columns(TRIALS, rows)


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    protocols = {
        f"single-{engine}": Protocol(f"single-{engine}", engine, False, "trials: {}", "same")
        for engine in ("mujoco", "pybullet")
    }
    tables = [
        SubmittedTable(
            name,
            protocol,
            attempts(rate, each.engine),
            Reproduction(196, same=196),
            {"A0, attempt 0": "films/a.gif"},
        )
        for protocol, each in protocols.items()
        for name, rate in (("good", 0.9), ("fair", 0.5))
    ]
    entries = {"good": ABOUT, "fair": ABOUT | {"reference": "it knows the object"}}
    refused = [Refusal("bad", "single-mujoco", ["1 of 196 attempts are not reproduced"])]
    path = tmp_path_factory.mktemp("leaderboard") / "index.html"
    path.write_text(page(Board(entries, protocols, tables, refused, ["an entry is missing"])))
    return path


@pytest.mark.parametrize(("width", "scheme"), [(390, "dark"), (1200, "light")])
def test_the_page_fits_and_gives_the_command_of_any_attempt(board, browser, width, scheme):
    accessibility = pytest.importorskip("axe_playwright_python.sync_playwright")
    size = {"viewport": {"width": width, "height": 844}, "is_mobile": False}
    tab = browser(color_scheme=scheme, **size).new_page()
    tab.goto(board.as_uri())
    for each in tab.locator("details:not(.film)").all():
        each.evaluate("box => { box.open = true; }")
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    box = tab.locator(".replay").nth(1)
    box.locator("select").nth(0).select_option("C4")
    box.locator("select").nth(1).select_option("3")
    assert box.locator("input").input_value() == (
        "egad trials replay C4 3 --table leaderboard/entries/good/single-pybullet.parquet "
        "--in evaluation-set --config leaderboard/protocols/single-pybullet.yaml"
    )
    box.locator("button").click()
    playwright.expect(box.locator("button")).to_have_text("Copied")  # the clipboard takes time
    found = accessibility.Axe().run(tab, options={"runOnly": STANDARDS})
    assert found.response["violations"] == []
