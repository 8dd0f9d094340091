"""CSV files that people write, by hand or with a spreadsheet."""

import csv
import io
from itertools import islice
from pathlib import Path

from egad.errors import UserError

MAX_BYTES, MAX_ROWS = 1 << 24, 100_000


def csv_lines(path: Path) -> list[tuple[int, list[str]]]:
    """The cells of the lines of a CSV file, with line numbers; empty lines are left out.

    Cells are separated by commas or, as some programs do, by semicolons.

    Raises:
        UserError: It is not a CSV file, or is too large.
    """
    if path.stat().st_size > MAX_BYTES:
        raise UserError(f"{path}: larger than {MAX_BYTES:,} bytes; split it")
    try:
        text = path.read_text(encoding="utf-8-sig")
        head = text.strip().partition("\n")[0]
        separator = ";" if head.count(";") > head.count(",") else ","
        reader = csv.reader(io.StringIO(text), delimiter=separator, strict=True)
        rows = ((reader.line_num, [cell.strip() for cell in row]) for row in reader)
        filled = list(islice((row for row in rows if any(row[1])), MAX_ROWS + 2))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: not a CSV file: {error}") from error
    if len(filled) > MAX_ROWS + 1:
        raise UserError(f"{path}: more than {MAX_ROWS:,} rows; split it")
    return filled
