"""Text of mesh files: encodings, line ends and numbers of all programs."""

import re
from collections.abc import Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from egad.errors import RejectedError

BYTE_ORDER_MARK = b"\xef\xbb\xbf"


def plain_text(data: bytes) -> bytes:
    r"""A text without byte-order mark, and with `\n` at the ends of its lines.

    Raises:
        RejectedError: It is UTF-16 or UTF-32.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or 0 in data[:2]:
        raise RejectedError("it is UTF-16 text; save it as UTF-8")
    text = data.removeprefix(BYTE_ORDER_MARK)
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def reals(words: Sequence[bytes], what: str) -> NDArray[np.float64]:
    """Words as numbers, (n,).

    Args:
        words: The words.
        what: What each of them belongs to, for the message.

    Raises:
        RejectedError: One of them is no number; the message has it.
    """
    try:
        return np.array(words, dtype="S").astype(np.float64)
    except ValueError:
        no_number(words, what, float)


def integers(words: Sequence[bytes], what: str) -> NDArray[np.int64]:
    """Words as whole numbers, (n,); raises as `reals`."""
    try:
        return np.array(words, dtype="S").astype(np.int64)
    except (ValueError, OverflowError):
        no_number(words, what, int)


def no_number(words: Sequence[bytes], what: str, kind: type[float]) -> NoReturn:
    """Say which of some words is no number."""
    for word in words:
        try:
            kind(word)
        except ValueError:
            text = word[:20].decode("latin-1")
            hint = "; it has a decimal comma, save the file with decimal points"
            comma = re.fullmatch(rb"[-+]?\d*,\d*(e[-+]?\d+)?,?", word, re.IGNORECASE)
            raise RejectedError(f"{what}: {text!r} is not a number{hint * bool(comma)}") from None
    raise RejectedError(f"{what}: a number is too large")
