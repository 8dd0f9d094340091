"""The report card of hands: its words, and its width on screens."""

import re

import pytest
from chromium import IN_CHROMIUM
from hand_cards import card

from egad.report.hands import Impossible, Shown, by_size, maps, page


def words(html):
    """The text of a page without its tags."""
    return " ".join(re.sub(r"<[^>]*>", " ", html.partition("<body>")[2]).split())


@pytest.fixture(scope="module")
def html():
    film = Shown("panda", "palm", "data:image/webp;base64,")
    lost = Impossible("B3", "data:image/png;base64,", 6, "palm 4, finger 2", [film])
    return page(card(), {"yumi": [], "panda": [lost]})


def test_the_page_says_what_each_hand_does(html):
    text = words(html).replace("\N{NO-BREAK SPACE}", " ").replace("&nbsp;", " ")
    assert "panda vs yumi" in text or "panda is better than yumi" in text
    assert "yumi opens 50 mm, closes with 20 N" in text
    assert "Each hand made 16 attempts with the best grasps" in text
    assert "panda best grasps 37.5 points" in text
    assert "the smallest side is at most 48 mm, 80 % of an opening of 60 mm" in text
    assert "panda: 1 object" in text
    assert "6 attempts: palm 4, finger 2." in text
    assert "errors of the cell: typical" in text


def test_a_single_hand_is_compared_with_none():
    alone = card()
    alone.hands = {"panda": alone.hands["panda"]}
    text = words(page(alone, {"panda": []}))
    assert "Differences" not in text
    assert "rank" not in text


def test_objects_are_grouped_by_their_sides():
    found = {title: (count, rates["panda"].attempts) for title, count, rates in by_size(card())}
    assert found["smallest side 20 to 40 mm"] == (8, 16)
    assert found["longest side 20 to 40 mm"] == (1, 2)
    assert len(found) == 1 + 8


def test_objects_of_the_evaluation_set_are_on_a_map():
    assert list(maps(card())) == ["yumi", "panda"]
    own = card()
    own.table["label"] = "mug"
    assert maps(own) == {}


@pytest.mark.parametrize("width", [390, 1200])
@IN_CHROMIUM[0]
@IN_CHROMIUM[1]
def test_the_page_does_not_scroll_sideways(html, browser, tmp_path, width):
    path = tmp_path / "card.html"
    path.write_text(html, encoding="utf-8")
    shown = browser(viewport={"width": width, "height": 900}, is_mobile=False).new_page()
    shown.goto(path.as_uri())
    assert shown.evaluate("document.documentElement.scrollWidth") == width
