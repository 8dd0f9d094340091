"""Units of mesh files: those that a caller gives, a file states, or its format prescribes."""

import re

from egad.errors import RejectedError, UserError

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
LENGTHS = {**METRES, "foot": 0.3048, "micron": 1e-6}  # what files state, too
LENGTHS |= {"dm": 0.1, "km": 1000.0, "nm": 1e-9, "yard": 0.9144, "mil": 2.54e-5}
PRESCRIBED = {"glb": "m", "3mf": "mm"}  # by formats, where a file does not state its unit
ALLOWED = "m, cm, mm or inch"
COMMENTS = 4096  # bytes at the start of a file in which a comment may state its unit
_SPELLINGS = {
    "m": ("m", "meter", "meters", "metre", "metres"),
    "cm": ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
    "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    "inch": ("in", "inch", "inches"),
    "foot": ("ft", "foot", "feet"),
    "micron": ("um", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"),
    "dm": ("dm", "decimeter", "decimeters", "decimetre", "decimetres"),
    "km": ("km", "kilometer", "kilometers", "kilometre", "kilometres"),
    "nm": ("nm", "nanometer", "nanometers", "nanometre", "nanometres"),
    "yard": ("yd", "yard", "yards"),
    "mil": ("mil", "mils", "thou"),
}
UNIT_OF = {spelling: unit for unit, spellings in _SPELLINGS.items() for spelling in spellings}
_STATEMENT = re.compile(
    rb"\b(?:units?[ \t]*[:=]|units[ \t]+(?:are[ \t]+)?in\b)[ \t]*(?:1[ \t]*)?"
    rb"([a-z]+)\b(?![ \t]*[\w/^*\x80-\xff])",
    re.IGNORECASE,
)
_COMMENTS = re.compile(rb"(?:#|^(?:comment|obj_info)\b)[^\n]*", re.MULTILINE)


def stated_in(comment: bytes) -> str | None:
    """The unit of length that a comment states, as `unit: millimetre` or `units in cm`, or None."""
    words = (word.decode().lower() for word in _STATEMENT.findall(comment))
    return next((UNIT_OF[word] for word in words if word in UNIT_OF), None)


def stated_in_comments(data: bytes) -> str | None:
    """The unit that comments at the start of an OBJ, OFF or PLY file state."""
    start = data[:COMMENTS].replace(b"\r", b"\n")
    return stated_in(b"\n".join(_COMMENTS.findall(start)))


def check_unit(asked: str | None) -> None:
    """Raise `UserError` if a unit is neither None nor one that a caller may give."""
    if asked is not None and asked not in METRES:
        raise UserError(f"unit {asked!r} is not known; allowed: {', '.join(METRES)}")


def metres_per_unit(asked: str | None, stated: str | None, ending: str) -> float:
    """Metres per unit of a file; errors if those asked for and stated differ, or neither is."""
    check_unit(asked)
    if asked and stated and asked != stated:
        raise RejectedError(f"the file states the unit {stated}, but {asked} is given")
    unit = asked or stated or PRESCRIBED.get(ending)
    if unit is None:
        raise RejectedError(f"the file does not state its unit; give `units`: {ALLOWED}")
    return LENGTHS[unit]
