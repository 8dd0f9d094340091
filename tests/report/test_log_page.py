"""The page of `egad log-sheet` in Chromium, as people use it on a phone: `make browser`."""

import json
import re
from importlib import resources

import pytest
import trimesh
from chromium import IN_CHROMIUM, PHONE, STANDARDS
from commands import egad

from egad.bench.stats import LOG_COLUMNS, read, wilson
from egad.report.log_sheet import LogObject, page, plan
from egad.report.pictures import png_bytes, render
from egad.tables.outcomes import OBSERVABLE

playwright = pytest.importorskip("playwright.sync_api")
pytestmark = IN_CHROMIUM
SECOND_TAP = 380  # ms: later than what counts as one tap
MIN_TARGET = 44  # pixels
PLANNED = plan(["A0", "C4"], 10, ["mine", "theirs"], 0, blind=True)
NO_STORAGE = """
const get = () => { throw new DOMException("no", "SecurityError"); };
Object.defineProperty(window, "localStorage", { get });
"""
FULL_STORAGE = """
const setItem = Storage.prototype.setItem;
Storage.prototype.setItem = function (key, value) {
  const isRefused = window.isFull && key.includes("/result/");
  if (isRefused) throw new DOMException("full", "QuotaExceededError");
  return setItem.call(this, key, value);
};
"""


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """The page of two objects, ten attempts of two detectors each, blinded."""
    meshes = {"A0": trimesh.creation.icosphere(), "C4": trimesh.creation.box((1, 2, 3))}
    objects = [LogObject(label, label, png_bytes(render(meshes[label]))) for label in meshes]
    path = tmp_path_factory.mktemp("sheet") / "log.html"
    path.write_text(page(PLANNED, objects, "two objects"), encoding="utf-8")
    return path


def opened(context, sheet):
    tab = context.new_page()
    tab.goto(sheet.as_uri())
    return tab


def begin(tab):
    for name in ("operator", "robot", "gripper"):
        tab.fill(f"#field-{name}", f"the {name}")
    tab.tap("text=Start")


def log(tab, *outcomes):
    for outcome in outcomes:
        tab.tap(f'[data-outcome="{outcome}"]')
        tab.clock.run_for(SECOND_TAP)


def saved(tab):
    return tab.inner_text("#saved")


def download(tab, action, folder):
    with tab.expect_download() as waiting:
        tab.locator(f'[data-do="{action}"]:visible').first.tap()
    path = folder / waiting.value.suggested_filename
    waiting.value.save_as(path)
    return path


def told(tab, selector, words):
    """Wait for words; whitespace does not count."""
    playwright.expect(tab.locator(selector)).to_contain_text(words)


def rows_of(path):
    return path.read_bytes().decode("utf-8-sig").split("\r\n")


def end(tab):
    if tab.is_hidden("#complete"):
        if tab.is_hidden('[data-do="stop"]'):
            tab.tap("#more summary")
        tab.tap('[data-do="stop"]')
    else:
        tab.tap('[data-do="end"]')
    tab.tap("#sure [value=yes]")
    tab.wait_for_selector("#ended")


def test_a_session_survives_reloads_and_closed_tabs(sheet, browser, tmp_path):
    """40 attempts; what is exported, read again and reported is what was tapped."""
    outcomes = (["success", "success", "missed", "slipped_lifting", "no_grasp"] * 8)[:40]
    phone = browser()
    tab = opened(phone, sheet)
    tab.fill("#field-operator", "half")
    tab.reload()
    assert tab.input_value("#field-operator") == "half"
    begin(tab)
    log(tab, *outcomes[:11])
    assert saved(tab) == "Saved 11 of 40"
    tab.fill("#note", "half a note")
    tab.reload()
    assert saved(tab) == "Saved 11 of 40"
    assert tab.input_value("#note") == "half a note"
    tab.fill("#note", '=HYPERLINK("x"); rim\nof it, ü')
    log(tab, *outcomes[11:19], "dropped")
    tab.tap("#undo")
    told(tab, "#said", "Undone: No. 20")
    assert saved(tab) == "Saved 19 of 40"
    log(tab, outcomes[19])
    assert tab.is_visible("#reminder")
    first = download(tab, "csv", tmp_path)
    assert len(rows_of(first)) == 1 + 21 + 1  # the head, 20 and one undone, an empty end
    assert tab.is_hidden("#reminder")
    log(tab, *outcomes[20:23])
    tab.close()
    tab = opened(phone, sheet)
    log(tab, outcomes[23])
    phone.close()
    tab = opened(browser(), sheet)
    assert saved(tab) == "Saved 24 of 40"
    tab.tap("#invalid")
    tab.check("text=camera or network failed")
    tab.tap("text=Repeat the attempt")
    assert saved(tab) == "Saved 24 of 40"
    assert "repeated (1 not valid); no. 25 of 40" in tab.inner_text("#where")
    tab.clock.run_for(SECOND_TAP)
    log(tab, *outcomes[24:])
    assert tab.is_visible("#complete")
    assert "mine" not in tab.inner_text("main")
    shown = tab.inner_text("#rates")
    end(tab)
    assert tab.inner_text("#key").split("\n") == [
        f"{PLANNED.shown[n]} is {n}" for n in PLANNED.shown
    ]
    assert tab.is_hidden("#undo")

    log_file = download(tab, "csv", tmp_path)
    content = log_file.read_bytes()
    assert content.startswith(b"\xef\xbb\xbf" + ",".join(LOG_COLUMNS).encode() + b"\r\n1,")
    assert b'"\'=HYPERLINK(""x""); rim\nof it, \xc3\xbc"' in content
    assert re.search(rb",\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d,C4,C4,0,", content)
    assert b"the operator,the robot,the gripper," in content
    found = read(log_file)
    tapped = dict(zip(PLANNED.order, outcomes, strict=True))
    assert {
        (label, attempt, name): outcome
        for name, table in found.items()
        for label, attempt, outcome in zip(
            table["label"], table["attempt"], table["outcome"], strict=True
        )
    } == tapped
    for name, table in found.items():
        successes = int(table["success"].sum())
        low, high = (round(100 * each) for each in wilson(successes, 20))
        line = [
            PLANNED.shown[name],
            f"{successes} of 20",
            f"{5 * successes} %",
            f"{low} to {high} %",
        ]
        assert "\t".join(line) in shown
    done = egad("trials", "report", log_file, "--out", tmp_path / "report.html")
    assert done.returncode == 0, done.stderr
    assert "2 attempts are not valid: " in done.stderr
    assert "mine vs theirs" in done.stdout


def test_a_backup_is_restored_on_another_phone(sheet, browser, tmp_path):
    one = opened(browser("one"), sheet)
    begin(one)
    log(one, "success", "missed", "dropped")
    early = download_backup(one, tmp_path / "early.json")
    one.tap("#undo")
    log(one, "collided")
    late = download_backup(one, tmp_path / "late.json")

    other = opened(browser("other"), sheet)
    other.set_input_files("#restore", late)
    told(other, "#said", "4 results added, 0 were already here")
    assert saved(other) == "Saved 3 of 40"
    assert other.input_value("#field-robot") == "the robot"
    other.set_input_files("#restore", early)
    told(other, "#said", "0 results added, 4 were already here")
    assert "No. 3, " in other.inner_text("#undo")
    assert "collided" in other.inner_text("#undo")  # what was undone stays undone
    log(other, "timeout")
    log(one, "success")
    apart = download_backup(other, tmp_path / "apart.json")
    one.set_input_files("#restore", apart)
    told(one, "#conflicts", "Attempts with two results, which do not count here: no. 4.")
    assert saved(one) == "Saved 4 of 40"

    end(one)
    late_csv = download(one, "csv", tmp_path)
    assert sum(map(len, read(late_csv).values())) == 3


def download_backup(tab, path):
    saved_as = download(tab, "backup", path.parent)
    return saved_as.rename(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda _: "PNG", "This file is not a backup of a grasp log."),
        (lambda _: "null", "This file is not a backup of a grasp log."),
        (lambda text: text.replace("egad-log", "other"), "This file is not a backup"),
        (lambda text: text.replace('"sheet": "', '"sheet": "f'), "of another sheet (f"),
        (
            lambda text: text.replace('"missed"', '"fell"'),
            "0 results added, 2 were already here. 1 cannot",
        ),
        (lambda text: text.replace('"missed"', '"other"'), "1 differ from those here, which are"),
    ],
)
def test_what_is_no_backup_changes_nothing(sheet, browser, tmp_path, change, words):
    tab = opened(browser(), sheet)
    begin(tab)
    log(tab, "success", "missed")
    path = download_backup(tab, tmp_path / "backup.json")
    path.write_text(change(path.read_text()))
    tab.set_input_files("#restore", path)
    told(tab, "#said", words)
    assert saved(tab) == "Saved 2 of 40"
    assert tab.inner_text("#undo").endswith("missed")


def test_a_double_tap_or_a_key_held_down_is_one_attempt(sheet, browser):
    tab = opened(browser(), sheet)
    begin(tab)
    tab.clock.run_for(SECOND_TAP)
    tab.locator('[data-outcome="success"]').dblclick()
    assert saved(tab) == "Saved 1 of 40"
    tab.clock.run_for(SECOND_TAP)
    tab.focus('[data-outcome="missed"]')
    for _ in range(15):
        tab.keyboard.down("Enter")  # repeats, as the key is not let go
        tab.wait_for_timeout(50)
    tab.keyboard.up("Enter")
    assert saved(tab) == "Saved 2 of 40"
    tab.locator("#undo").dblclick()
    assert saved(tab) == "Saved 1 of 40"


def test_everything_can_be_done_with_keys(sheet, browser):
    tab = opened(browser("desktop", viewport={"width": 1200, "height": 800}), sheet)
    tab.focus("#field-operator")
    for text in ("me", "Tab", "robot", "Tab", "hand", "Enter"):
        tab.keyboard.press(text) if text in ("Tab", "Enter") else tab.keyboard.type(text)
    assert tab.evaluate("document.activeElement.id") == "now"
    reached = []
    for _ in OBSERVABLE:
        tab.keyboard.press("Tab")
        reached.append(tab.evaluate("document.activeElement.dataset.outcome"))
        assert tab.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    assert reached[0] == "success"
    assert set(reached) == set(OBSERVABLE)
    tab.keyboard.press("Space")
    assert saved(tab) == "Saved 1 of 40"
    assert tab.evaluate("document.activeElement.dataset.outcome") == reached[-1]
    tab.clock.run_for(SECOND_TAP)
    tab.focus("#invalid")
    for key in ("Enter", "Space", "Enter"):  # opens, chooses the first reason, repeats
        tab.keyboard.press(key)
    assert "repeated (1 not valid)" in tab.inner_text("#where")


def test_an_attempt_that_cannot_be_made_is_left_out(sheet, browser, tmp_path):
    tab = opened(browser(), sheet)
    begin(tab)
    tab.tap("#invalid")
    tab.tap("text=Leave it out")
    assert tab.is_visible("#why")  # a reason is wanted
    tab.check("text=another reason")
    tab.tap("text=Leave it out")
    assert tab.is_visible("#why")  # in words
    tab.fill("[name=words]", "object lost")
    tab.tap("text=Leave it out")
    assert saved(tab) == "Saved 1 of 40"
    tab.clock.run_for(SECOND_TAP)
    log(tab, "success")
    path = download(tab, "csv", tmp_path)
    assert ",,,0,object lost,," in rows_of(path)[1]
    assert sum(map(len, read(path).values())) == 1


def test_the_csv_can_be_copied(sheet, browser):
    phone = browser(permissions=["clipboard-read", "clipboard-write"])
    tab = opened(phone, sheet)
    begin(tab)
    log(tab, "success")
    tab.tap('[data-do="copy"]')
    told(tab, "#said", "Copied")
    text = tab.evaluate("navigator.clipboard.readText()")
    assert text.startswith(",".join(LOG_COLUMNS))
    assert tab.inner_text("#unexported") == "All results are in a saved file."


def test_another_session_keeps_the_first(sheet, browser):
    tab = opened(browser(), sheet)
    begin(tab)
    log(tab, "success", "missed")
    first = tab.input_value("#sessions")
    tab.tap("#more summary")
    tab.tap('[data-do="new"]')
    assert tab.input_value("#field-operator") == "the operator"
    tab.tap("text=Start")
    assert saved(tab) == "Saved 0 of 40"
    assert tab.input_value("#sessions") != first
    tab.select_option("#sessions", first)
    assert saved(tab) == "Saved 2 of 40"


def test_a_page_that_cannot_store_says_so_at_once(sheet, browser, tmp_path):
    phone = browser()
    phone.add_init_script(NO_STORAGE)
    tab = opened(phone, sheet)
    assert "This browser stores nothing for this page" in tab.inner_text("[role=alert]")
    begin(tab)
    log(tab, "success", "missed")
    assert saved(tab) == "Saved 2 of 40"
    assert sum(map(len, read(download(tab, "csv", tmp_path)).values())) == 2


def test_a_storage_that_is_full_loses_nothing(sheet, browser):
    phone = browser()
    phone.add_init_script(FULL_STORAGE)
    tab = opened(phone, sheet)
    begin(tab)
    log(tab, "success")
    assert tab.inner_text("#alerts") == ""
    tab.evaluate("window.isFull = true")
    log(tab, "missed")
    assert "Not stored: the browser refuses to store more" in tab.inner_text("[role=alert]")
    assert saved(tab) == "Saved 2 of 40"
    tab.evaluate("window.isFull = false")
    log(tab, "dropped")
    assert tab.inner_text("#alerts") == ""
    tab.reload()
    assert saved(tab) == "Saved 3 of 40"


def test_two_tabs_notice_each_other(sheet, browser):
    phone = browser()
    one = opened(phone, sheet)
    begin(one)
    log(one, "success")
    other = opened(phone, sheet)
    for tab in (one, other):
        told(tab, "#alerts", "another tab")
    log(other, "missed")
    told(one, "#saved", "Saved 2 of 40")
    log(one, "dropped")
    told(other, "#saved", "Saved 3 of 40")
    other.close(run_before_unload=True)
    playwright.expect(one.locator("#alerts")).to_be_empty()


def test_the_order_can_be_printed(sheet, browser):
    tab = opened(browser(), sheet)
    assert tab.is_hidden("#paper")
    tab.emulate_media(media="print")
    assert tab.is_hidden(".app")
    rows = tab.locator("#paper tbody tr")
    assert rows.count() == 40
    assert rows.last.is_visible()
    assert "slipped lifting (lost during the lift)" in tab.inner_text("#paper")


def test_without_scripts_the_order_is_there_to_fill_in(sheet, browser):
    tab = opened(browser(java_script_enabled=False), sheet)
    assert "Scripts do not run here" in tab.inner_text("noscript")
    assert tab.is_visible("#paper")
    assert tab.is_hidden(".app")


def views(tab):
    """Go through all that the page can show; the name of each."""
    yield "setup"
    begin(tab)
    log(tab, *["success"] * 21)
    tab.tap("#undo")
    yield "work"
    tab.tap("#more summary")
    yield "details"
    tab.tap("#invalid")
    yield "dialog"
    tab.tap('[data-do="cancel"]')
    end(tab)
    yield "ended"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_is_accessible(sheet, browser, scheme):
    axe = resources.files("axe_playwright_python").joinpath("axe.min.js").read_text()
    tab = opened(browser(color_scheme=scheme, reduced_motion="reduce"), sheet)
    for view in views(tab):
        tab.evaluate(axe)
        found = tab.evaluate("tags => axe.run(document, { runOnly: tags })", STANDARDS)
        assert not found["violations"], (view, json.dumps(found["violations"], indent=1))
        for name, width, height in targets(tab):
            assert width >= MIN_TARGET, (view, name)
            assert height >= MIN_TARGET, (view, name)
        assert tab.evaluate(EDGES) >= 3, view
        tab.set_viewport_size({"width": 320, "height": 640})
        assert tab.evaluate("document.documentElement.scrollWidth") == 320, view
        tab.set_viewport_size(PHONE["viewport"])
    assert tab.get_attribute("html", "lang") == "en"


def targets(tab):
    """What can be tapped: its text, width and height; of a choice, its whole label."""
    return tab.evaluate("""() =>
      [...document.querySelectorAll("button, input, select, textarea, summary, .button")]
        .map((each) => each.type === "radio" ? each.closest("label") : each)
        .filter((each) => each.checkVisibility())
        .map((each) => [each, each.getBoundingClientRect()])
        .map(([each, box]) => [each.textContent || each.id, box.width, box.height])""")


EDGES = """() => {
  const light = (color) => {
    const parts = color.match(/[\\d.]+/g).slice(0, 3).map((part) => {
      const share = part / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
  };
  const ground = light(getComputedStyle(document.body).backgroundColor);
  const contrasts = [...document.querySelectorAll("button, select, textarea, .button")]
    .filter((each) => each.checkVisibility())
    .map((each) => light(getComputedStyle(each).borderTopColor))
    .map((edge) => (Math.max(edge, ground) + 0.05) / (Math.min(edge, ground) + 0.05));
  return Math.min(...contrasts);
}"""
