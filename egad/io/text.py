"""Text of mesh files: encodings, line endings and numbers of all programs."""

import re
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad.errors import RejectedError

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
START = 1024  # bytes that say whether a file is text
_UTF16 = re.compile(rb"\xff\xfe|\xfe\xff|(?:[^\0]\0){4}|(?:\0[^\0]){4}")
# How C and C++ libraries write what is not finite, other than `nan` and `inf`
_MICROSOFT = re.compile(  # rounded to few digits as if the letters were digits
    rb"\d\.#(?:[QS](?:NAN|NB|O)|R|T|IN[DF]|IO|J)\d*\b", re.IGNORECASE
)
_PAYLOAD = re.compile(rb"\((?<=nan\()\w*\)", re.IGNORECASE)
_BLANKS = dict.fromkeys(map(ord, "\t\n\r\x1a"))


def plain_text(data: bytes) -> bytes:
    r"""A text without byte-order mark, with `\n` at ends of lines and `nan` as such; UTF-8 only."""
    if is_utf16(data):
        raise RejectedError("it is UTF-16 text; save it as UTF-8")
    if 0 in data[:START]:
        raise RejectedError("it is binary, not text")
    text = with_plain_nan(data.removeprefix(BYTE_ORDER_MARK))
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def with_plain_nan(text: bytes) -> bytes:
    """A text with `nan` for numbers such as `1.#QNAN` and `nan(ind)`, which are not finite."""
    if b".#" in text:
        text = _MICROSOFT.sub(b"nan", text)
    return _PAYLOAD.sub(b"", text) if b"(" in text else text


def is_utf16(data: bytes) -> bool:
    """Whether a file starts as UTF-16 text does: with its mark, or every second byte is 0."""
    return _UTF16.match(data) is not None


def is_padding(rest: bytes) -> bool:
    """Whether what follows the data of a binary file is not data: only zeros, or text."""
    text = rest.strip(b"\0")
    return text.isascii() and text.decode("latin-1").translate(_BLANKS).isprintable()


def reals(words: Sequence[bytes], what: str) -> Floats:
    """Words as numbers, (n,), or a `RejectedError` that quotes the wrong one and names `what`."""
    try:
        return _numbers(words, np.float64)
    except ValueError:
        no_number(words, what, float)


def integers(words: Sequence[bytes], what: str) -> Ints:
    """Words as whole numbers, (n,); raises as `reals`."""
    try:
        return _numbers(words, np.int64)
    except (ValueError, OverflowError):
        no_number(words, what, int)


def _numbers(words: Sequence[bytes], kind: type[np.number[Any]]) -> NDArray[Any]:
    check_digits(words)
    return np.array(words, dtype="S").astype(kind)


def check_digits(words: Sequence[bytes]) -> None:
    """Raise `ValueError` for numbers that only Python accepts: with underscores between digits."""
    if b"_" in b"".join(words):
        raise ValueError


def no_number(words: Sequence[bytes], what: str, kind: type[float]) -> NoReturn:
    """Say which of some words is no number."""
    for word in words:
        try:
            check_digits([word])
            kind(word)
        except ValueError:
            text = word[:20].decode("latin-1")
            hint = "; it has a decimal comma, save the file with decimal points"
            comma = re.fullmatch(rb"[-+]?\d*,\d+(e[-+]?\d+)?", word, re.IGNORECASE)
            raise RejectedError(f"{what}: {text!r} is not a number{hint * bool(comma)}") from None
    raise RejectedError(f"{what}: a number is too large")
