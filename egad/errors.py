"""Errors that are meant to be read by a person."""

import difflib
from collections import Counter
from collections.abc import Iterable

LESS_MEMORY = "use fewer processes: `jobs` in Python, --jobs of a command, --cores of the workflow"
MAX_NAMES = 12


class EgadError(Exception):
    """Any error that egad raises on purpose: the message is a sentence for a person."""


class UserError(EgadError, ValueError):
    """An error that the user can fix: the message says what is wrong, where, what is allowed."""


class MissingPackageError(ModuleNotFoundError, UserError):
    """A package of an extra is not installed; the message names the extra."""


class RejectedError(EgadError):
    """One object cannot be used. The message is the reason; work on the other objects continues."""


class NoGraspError(RejectedError):
    """A sampler found no grasp of an object."""


class TableError(EgadError, ValueError):
    """A Parquet file is missing, damaged, or does not have the columns of its schema."""


def most_common(reasons: Counter[str]) -> str:
    """The three most frequent reasons with their counts."""
    return "; ".join(f"{reason} ({count})" for reason, count in reasons.most_common(3))


def check_name(what: str, name: object, names: Iterable[str], where: str = "") -> str:
    """Return a name if it is a known one.

    Raises:
        UserError: The name is unknown, or not a string; the message lists the most similar names,
            or a few of all.
    """
    allowed = sorted(names)
    if isinstance(name, str) and name in allowed:
        return name
    near = difflib.get_close_matches(str(name), allowed, n=5, cutoff=0.5)
    few = ", ".join(allowed[:MAX_NAMES]) + (", ..." if len(allowed) > MAX_NAMES else "")
    hint = f"did you mean {' or '.join(near)}?" if near else f"known: {few or 'none'}"
    raise UserError(f"{what} {name!r} is not known{where}; {hint}")
