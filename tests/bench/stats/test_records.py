"""Results of a real robot: what is read, and what is said about mistakes."""

import csv
import io
import logging

import numpy as np
import pandas as pd
import pytest
from partial_tables import write_rows

from egad.bench.stats import LOG_COLUMNS, gather, read, template
from egad.bench.stats.records import COLUMNS
from egad.errors import UserError
from egad.tables import parquet
from egad.tables.evaluation import RESULTS, TRIALS

GOOD = """label,attempt,success,outcome,quality,detector
A0,0,1,,0.8,mine
A0,1,no,slipped,,mine
C4,0,TRUE,success,0.5,other
G6,0,,,,mine
"""


@pytest.fixture
def written(tmp_path):
    def write(text, name="results.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_text(text, encoding=encoding)
        return path

    return write


def test_a_file_is_read_by_detector(written):
    found = read(written(GOOD))
    assert list(found) == ["mine", "other"]
    mine = found["mine"]
    assert mine.columns.tolist() == RESULTS.names
    assert mine["success"].tolist() == [True, False]
    assert mine["outcome"].tolist() == ["success", "slipped"]
    assert mine["quality"].tolist()[0] == 0.8
    assert np.isnan(mine["quality"].tolist()[1])
    assert set(mine["id"]) == set(mine["initial_pose"]) == {""}  # known by their label only


SHEET = [
    ["Label", "Detector", "Attempt", "Success", "Quality", "Note"],
    ["A0", "mine", "0", "1", "0.8", "Köln, links; oben"],
    ["A0", "mine", "1", "0", "1e-3", ""],
    ["", "", "", "", "", ""],
    ["C4", "mine", "0", "1", "0.125", '"so"'],
]
WORDS = {"1": "0", "TRUE": "FALSE", "WAHR": "FALSCH", "VRAI": "FAUX", "VERDADERO": "FALSO"}
WORDS |= {"VERO": "FALSO", "VERDADEIRO": "FALSO", "PRAWDA": "FAŁSZ", "WAAR": "ONWAAR"}
WORDS |= {"TOSI": "EPÄTOSI", "DOĞRU": "YANLIŞ", "PRAVDA": "NEPRAVDA", "ИСТИНА": "ЛОЖЬ"}
SAVED = {  # encoding, separator, head, ends of lines
    "csv": ("utf-8", ",", "", "\n"),
    "excel utf-8": ("utf-8-sig", ";", "", "\r\n"),
    "excel sep": ("utf-8-sig", ";", "sep=;\r\n", "\r\n"),
    "excel ansi": ("cp1252", ";", "", "\r\n"),
    "excel of a mac": ("mac-roman", ";", "", "\r"),
    "unicode text": ("utf-16", "\t", "", "\r\n"),
    "big endian": ("utf-16-be", ";", "\ufeff", "\n"),
    "no mark": ("utf-16-le", ",", "", "\n"),
    "sep tab": ("utf-8", "\t", '"sep=\t"\n', "\n"),
    "sep bar": ("utf-8", "|", "sep=|\n", "\n"),
}


def sheet(how, rows=SHEET, more=2):
    """What a spreadsheet saves, with empty columns and lines at the end."""
    encoding, separator, head, end = SAVED[how]
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator=end)
    writer.writerows([[*row, *[""] * more] for row in [*rows, *[[""] * 6] * more]])
    return (head + text.getvalue()).encode(encoding)


@pytest.mark.parametrize("how", SAVED)
@pytest.mark.parametrize(("true", "false"), WORDS.items())
def test_what_spreadsheets_save_is_read(tmp_path, how, true, false):
    words = {"1": true, "0": false}
    rows = [SHEET[0], *([*r[:3], words.get(r[3], r[3]), *r[4:]] for r in SHEET[1:])]
    if true not in ("1", "TRUE") and SAVED[how][1] != ",":
        rows = [[*row[:4], row[4].replace(".", ","), row[5]] for row in rows]
    try:
        data = sheet(how, rows)
    except UnicodeEncodeError:
        pytest.skip("this encoding lacks these letters")
    (tmp_path / "log.csv").write_bytes(data)
    if SAVED[how][0] in ("cp1252", "mac-roman") and not (true + false).isascii():
        with pytest.raises(UserError, match=r"line 3, column 4 \(success\): .* CSV UTF-8"):
            read(tmp_path / "log.csv")
        return
    table = read(tmp_path / "log.csv")["mine"]
    assert table["success"].tolist() == [True, False, True]
    assert table["quality"].tolist() == [0.8, 0.001, 0.125]
    assert table["attempt"].tolist() == [0, 1, 0]


@pytest.mark.parametrize(("how", "cell"), [("csv", "0,8"), ("unicode text", "1,234")])
def test_a_comma_that_may_separate_thousands_is_refused(tmp_path, how, cell):
    rows = [SHEET[0], [*SHEET[1][:4], cell, ""]]
    (tmp_path / "log.csv").write_bytes(sheet(how, rows))
    with pytest.raises(UserError, match=r"line 2: quality is .*; allowed: a number"):
        read(tmp_path / "log.csv")


@pytest.mark.parametrize("start", [b"PK\x03\x04", b"\xd0\xcf\x11\xe0"])
def test_a_workbook_is_named(tmp_path, start):
    (tmp_path / "log.csv").write_bytes(start + bytes(100))
    with pytest.raises(UserError, match=r"workbook .*save it as CSV UTF-8"):
        read(tmp_path / "log.csv")


def test_semicolons_separate_what_has_commas_in_it(written):
    """As written where 0,5 is a half: a comma in a cell does not cut it."""
    text = "label;attempt;success;detector\nA0;0;1;mine, the new one\n"
    assert list(read(written(text))) == ["mine, the new one"]


def test_a_name_with_a_comma_is_no_number(written):
    text = "label;attempt;success;detector;quality\n1,5;0;1;2,5;0,5\n"
    ((detector, table),) = read(written(text)).items()
    assert (detector, *table.loc[0, ["label", "quality"]]) == ("2,5", "1,5", 0.5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a CSV file: it is empty"),
        ("label,attempt\nA0,0\n", "the column success is missing; needed: label, attempt, success"),
        ("label,attempt,success\nA0,0,\n", "no row says whether"),
        (
            "label,attempt,success\nA0,0,1\nA0,1,maybe\n",
            "line 3: success is 'maybe'; allowed: 1, 0",
        ),
        ("label,attempt,success\n,0,1\nmug,0,1\n", "line 2: label is ''; allowed: a name"),
        (
            "label,attempt,success,outcome\nA0,0,0,fell\n",
            "outcome is 'fell'; allowed: success, coll",
        ),
        ("label,attempt,success,outcome\nA0,0,0,success\n", "success if and only if success is 1"),
        ("label,attempt,success\nA0,0,1\nA0,1,0,missed\n", "line 3: 4 cells; the first line has 3"),
        ('label,attempt,success\nA0,0,1\n"A1,0,1\n', "not a CSV file: unexpected end of data"),
        ("\n\nlabel,attempt,success\n\nA0,0,1\n,,\nA1,0,2\n", "line 7: success is '2'"),
    ],
)
def test_mistakes_are_named_with_their_line(written, text, words):
    with pytest.raises(UserError, match=words):
        read(written(text))


@pytest.mark.parametrize(
    ("labels", "strange"),
    [
        (["mug", "small box", "A1"], "mug, small box"),
        (["a0", "b3", "C44"], "C44"),
        (["mug", "B0"], "mug"),
        (["M3", "M4", "bolt", "nut"], ""),  # in no cell of the usual grid
        (["m3", "m4", "m5"], ""),
    ],
)
def test_own_objects_have_names_of_their_own(written, caplog, labels, strange):
    text = "label,attempt,success\n" + "".join(f"{label},0,1\n" for label in labels)
    assert read(written(text))["results"]["label"].tolist() == labels
    warning = f"labels are taken as names, not cells of the grid, due to {strange}\n"
    assert caplog.text.endswith(warning) if strange else not caplog.text


def test_a_filled_template_is_read_again(tmp_path):
    frame = template(["A0", "B1"], 3, "mine")
    assert tuple(frame.columns) == COLUMNS
    assert len(frame) == 6
    frame["success"] = ["1", "0", "1", "", "", "0"]
    path = tmp_path / "filled.csv"
    frame.to_csv(path, index=False)
    assert read(path)["mine"]["success"].tolist() == [True, False, True, False]


def test_a_table_round_trips_through_parquet(written, tmp_path):
    whole = pd.concat(read(written(GOOD)).values())
    parquet.write(whole, RESULTS, tmp_path / "r.parquet")
    again = read(tmp_path / "r.parquet")
    for name, table in read(written(GOOD)).items():
        pd.testing.assert_frame_equal(again[name], table, check_dtype=False)


def test_tables_of_the_simulation_have_the_name_of_their_file(tmp_path):
    row = {"label": "A0", "id": "some/object", "seed": "ff", "outcome": "success", "success": True}
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        path = tmp_path / folder / "antipodal-depth.parquet"
        write_rows(TRIALS, [row], path)
    (found,) = parquet.records(read(path)["antipodal-depth"])
    assert (found["id"], found["initial_pose"]) == ("some/object", "00" * 56)  # seven zeros
    files = [tmp_path / folder / "antipodal-depth.parquet" for folder in ("one", "two")]
    assert list(gather(files)) == ["antipodal-depth", "two/antipodal-depth"]
    with pytest.raises(UserError, match="two tables have the same detector two/antipodal-depth"):
        gather([*files, files[1]])


def test_a_file_that_is_far_too_large_is_not_read(tmp_path):
    with (tmp_path / "results.csv").open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(UserError, match="larger than 16,777,216 bytes"):
        read(tmp_path / "results.csv")


@pytest.mark.parametrize(("blank", "rows"), [(1_000_000, 5), (0, 100_001)])
def test_there_are_not_too_many_rows(written, blank, rows):
    path = written("label,attempt,success\n" + "\n" * blank + "A0,,\n" * rows)
    reason = "more than 100,000 rows" if rows > 5 else "no row says whether"
    with pytest.raises(UserError, match=reason):
        read(path)


def test_no_table_grows_to_rows_times_columns(written):
    text = "label,attempt,success" + "," * 10_000 + "\n" + "A0,0,1\n" * 100_000
    with pytest.raises(UserError, match="10003 columns; at most 1000"):
        read(written(text))


def log_text(*rows):
    """A log as its page exports it, of rows that differ from a good one."""
    usual = dict.fromkeys(LOG_COLUMNS, "") | {
        "schema": "1",
        "session": "monday",
        "time": "2026-11-27T09:59:00+01:00",
        "label": "C4",
        "id": "cafe",
        "attempt": "0",
        "detector": "mine",
        "success": "1",
        "outcome": "success",
        "valid": "1",
    }
    text = io.StringIO()
    writer = csv.DictWriter(text, LOG_COLUMNS)
    writer.writeheader()
    writer.writerows(usual | row for row in rows)
    return "\ufeff" + text.getvalue()


FAILED = {"success": "0", "outcome": "slipped_lifting"}


def test_attempts_that_are_not_valid_are_left_out_and_counted(written, caplog):
    stopped = {"valid": "0", "success": "", "outcome": "", "reason": "stopped"}
    undone = {"valid": "no", "reason": "undone", **FAILED}
    found = read(written(log_text(stopped, undone, undone, {})))
    assert found["mine"]["success"].tolist() == [True]
    assert "3 attempts are not valid: undone (2); stopped (1)" in caplog.text


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"label": ""}, "line 3: label is ''; allowed: a name"),
        ({"schema": "2"}, "line 3: schema is '2'; allowed: 1"),
    ],
)
def test_a_log_is_read_without_the_rows_that_are_wrong(written, caplog, row, words):
    found = read(written(log_text({}, {"attempt": "1", **row}, {"attempt": "2"})))
    assert found["mine"]["attempt"].tolist() == [0, 2]
    assert words in caplog.text
    assert "left out" in caplog.text


def test_a_log_without_a_row_that_can_be_used_is_a_mistake(written):
    with pytest.raises(UserError, match="no row says whether"):
        read(written(log_text({"attempt": "first"})))
    with pytest.raises(UserError, match="no attempt is left"):
        read(written(log_text({}, FAILED)))


def test_a_log_of_another_version_is_refused(written):
    newer = {"schema": "2", "attempt": "1"}
    with pytest.raises(UserError, match="line 2: schema is '2'; allowed: 1; a newer egad may"):
        read(written(log_text(newer)))


def test_results_of_a_session_that_contradict_each_other_are_left_out(written, caplog):
    """Two copies of one session went on apart, and somebody has joined their files."""
    found = read(written(log_text({}, {"attempt": "1"}, {"attempt": "1", **FAILED})))
    assert found["mine"]["attempt"].tolist() == [0]
    told = "lines 3 and 4: session monday has several results of attempt 1 at C4 by mine"
    assert told in caplog.text
    assert "success and slipped_lifting; left out" in caplog.text


def test_what_a_log_has_twice_counts_once(written, caplog):
    caplog.set_level(logging.WARNING)
    found = read(written(log_text({}, {"attempt": "1", **FAILED}, {}, {"attempt": "1", **FAILED})))
    assert found["mine"]["success"].tolist() == [True, False]
    assert not caplog.records


def test_attempts_of_another_session_are_counted_on(written, caplog):
    tuesday = {"session": "tuesday", **FAILED}
    rows = {}, {"attempt": "1"}, tuesday, {"detector": "theirs"}, tuesday | {"detector": "theirs"}
    found = read(written(log_text(*rows)))
    assert found["mine"]["attempt"].tolist() == [0, 1, 2]
    assert found["mine"]["success"].tolist() == [True, True, False]
    assert found["theirs"]["attempt"].tolist() == [0, 2]
    assert "2 attempts were made in an earlier session, too" in caplog.text


def test_one_repeated_attempt_leaves_the_others_their_numbers(written):
    """Those of another detector in the same session are still its pairs."""
    tuesday = [{"session": "tuesday", "attempt": str(n), "detector": "theirs"} for n in range(3)]
    again = {"session": "tuesday", "attempt": "1", **FAILED}
    monday = [{"attempt": str(number)} for number in range(3)]
    found = read(written(log_text(*monday, *tuesday, again)))
    assert found["mine"]["attempt"].tolist() == [0, 1, 2, 4]
    assert found["theirs"]["attempt"].tolist() == [0, 1, 2]
