"""Names that a person gives, and what to say if there is no such thing."""

import difflib
from collections.abc import Iterable

from egad.errors import UserError

MOST_NAMES = 12


def known(what: str, name: str, names: Iterable[str], where: str = "") -> str:
    """The name, if there is such a thing.

    Raises:
        UserError: There is none; the text has those that are spelled most alike, or a few.
    """
    allowed = sorted(names)
    if name in allowed:
        return name
    near = difflib.get_close_matches(name, allowed, n=5, cutoff=0.5)
    few = ", ".join(allowed[:MOST_NAMES]) + (", ..." if len(allowed) > MOST_NAMES else "")
    hint = f"did you mean {' or '.join(near)}?" if near else f"known: {few or 'none'}"
    raise UserError(f"{what} {name!r} is not known{where}; {hint}")
