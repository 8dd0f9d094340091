"""CSV files that people write, by hand or with a spreadsheet."""

import csv
import io
import re
from collections.abc import Collection
from itertools import islice
from pathlib import Path

from egad.errors import UserError
from egad.io.text import is_utf16

MAX_BYTES, MAX_ROWS = 1 << 24, 100_000
SAVE = "save it as CSV UTF-8"
_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_SEPARATOR = re.compile(r'\s*"?sep=(.)"?[,;\t]*(?=\n)', re.IGNORECASE)
_COMMA = re.compile(r"^([-+]?\d*),(\d+(?:e[-+]?\d+)?(?:\s*%)?)$", re.IGNORECASE)
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")


def csv_lines(
    path: Path, columns: Collection[str], numbers: Collection[str] = ()
) -> list[tuple[int, list[str]]]:
    """The cells of the lines of a CSV file, with line numbers; empty lines are left out.

    Cells are separated by commas or, as in spreadsheets, by semicolons, tabs or what `sep=;` says;
    then the decimal comma of `numbers`, columns in small letters, becomes a point. The text is
    UTF-8 or UTF-16, but cells outside `columns` may be in another encoding. `UserError` if it is no
    CSV.
    """
    if path.stat().st_size > MAX_BYTES:
        raise UserError(f"{path}: larger than {MAX_BYTES:,} bytes; split it")
    try:
        text, separator = _separator(_decoded(path))
        reader = csv.reader(io.StringIO(text), delimiter=separator, strict=True)
        rows = ((reader.line_num, [each.strip() for each in row]) for row in reader)
        filled = list(islice((row for row in rows if any(row[1])), MAX_ROWS + 2))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: not a CSV file: {error}; {SAVE}") from error
    if len(filled) > MAX_ROWS + 1:
        raise UserError(f"{path}: more than {MAX_ROWS:,} rows; split it")
    header = [name.lower() for name in filled[0][1]] if filled else []
    used = [(place, name) for place, name in enumerate(header) if name in columns]
    for line, row in filled:
        for place, name in used:
            if any("\udc80" <= letter <= "\udcff" for letter in "".join(row[place : place + 1])):
                raise UserError(
                    f"{path}, line {line}, column {place + 1} ({name}): a letter is not UTF-8; "
                    f"{SAVE}"
                )
            if name not in numbers or separator == "," or place >= len(row):
                continue
            # unless its comma may separate thousands
            if not (separator == "\t" and _THOUSANDS.fullmatch(row[place])):
                row[place] = _COMMA.sub(r"\1.\2", row[place])
    return filled


def _decoded(path: Path) -> str:
    """The text of a file, with newlines; bytes that are not UTF-8 become surrogates."""
    data = path.read_bytes()
    if data.startswith(_WORKBOOKS):
        raise UserError(f"{path}: a workbook of a spreadsheet, not a CSV file; {SAVE}")
    if not is_utf16(data):
        if b"\0" in data:
            raise UserError(f"{path}: not a CSV file: it is not text; {SAVE}")
        text = data.decode("utf-8-sig", errors="surrogateescape")
    elif data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = data.decode("utf-16")
    else:
        text = data.decode("utf-16-be" if data[0] == 0 else "utf-16-le")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _separator(text: str) -> tuple[str, str]:
    """A text without the line that states the separator, and the separator."""
    if stated := _SEPARATOR.match(text):
        return text[stated.end() :], stated[1]
    head = re.sub(r'"[^"]*"', "", text.strip().partition("\n")[0])
    return text, max(",;\t", key=head.count)
