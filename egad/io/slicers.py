"""What slicers say about the volumes of a 3MF file: which are solid, cut out, or only settings.

PrusaSlicer, SuperSlicer and Slic3r divide the triangles of an object into volumes; Bambu Studio and
OrcaSlicer, which divide an object into parts, name their kinds; Cura marks whole objects.
"""

from collections.abc import Sequence
from typing import NamedTuple
from xml.etree.ElementTree import Element

from egad.errors import RejectedError

CONFIGS = tuple(
    f"metadata/{name}.config"
    for name in ("superslicer_model", "slic3r_pe_model", "slic3r_model", "model_settings")
)
SLIC3R = "{http://schemas.slic3r.org/3mf/2017/06}"
MODIFIER = "ParameterModifier"
OF_CURA = frozenset({"infill_mesh", "cutting_mesh", "support_mesh", "anti_overhang_mesh"})
SOLID = frozenset({"", "0", "ModelPart", "normal_part"})
CUT_OUT = frozenset({"NegativeVolume", "negative_part"})
LEFT_OUT = OF_CURA | {
    *("1", MODIFIER, "modifier_part"),
    *("SupportBlocker", "SupportEnforcer", "support_blocker", "support_enforcer"),
    *("SeamPosition", "BrimPatch", "BrimNegative"),
}


class Volume(NamedTuple):
    """A volume of an object: its kind, and its mesh object or its first and last triangle."""

    kind: str
    number: str | None
    first: str | None
    last: str | None


def sign_of(kind: str) -> int:
    """What a volume of some kind adds to the solid: 1: itself; 0: nothing; -1: it is cut out."""
    if kind not in SOLID | LEFT_OUT | CUT_OUT:
        raise RejectedError(
            f"it has a volume of the kind {kind[:40]!r}, which is not supported; export the solid "
            "as STL"
        )
    return (kind in SOLID) - (kind in CUT_OUT)


def configured_volumes(root: Element) -> dict[str, list[Volume]]:
    """The volumes of each object, by its number, in one of `CONFIGS`."""
    objects = root.iterfind("object")
    return {
        str(each.get("id")): [_volume(part) for part in each if part.tag in ("volume", "part")]
        for each in objects
    }


def _volume(part: Element) -> Volume:
    kind = part.get("subtype", "")
    for entry in part.iterfind("metadata"):
        key, value = entry.get("key"), entry.get("value", "")
        if key in ("volume_type", "part_type"):
            kind = value
        elif key == "modifier" and value == "1":
            kind = MODIFIER
    return Volume(kind, part.get("id"), part.get("firstid"), part.get("lastid"))


def marked_volumes(mesh: Element) -> list[Volume]:
    """The volumes that Slic3r notes within a mesh."""
    return [
        Volume(each.get("modifier", "0"), None, each.get("ts"), each.get("te"))
        for each in mesh.iterfind(f"{SLIC3R}volumes/{SLIC3R}volume")
    ]


def cura_kind(found: Element) -> str:
    """The kind that Cura gives an object; empty for a solid."""
    for each in found.iter():
        kind = each.get("name", "").removeprefix("cura:")
        if kind in OF_CURA and (each.text or "").strip().lower() in ("true", "1"):
            return kind
    return ""


def part_kind(volumes: Sequence[Volume], index: int, number: str) -> str | None:
    """The kind of the `index`-th mesh object, which may occur several times; None if not there."""
    same = [each.kind for each in volumes[index : index + 1] if each.number == number]
    same += [each.kind for each in volumes if each.number == number and each.first is None]
    return same[0] if same else None


def volume_sizes(volumes: Sequence[Volume], count: int) -> list[tuple[str, int]]:
    """The kinds of volumes of an object, each with its number of triangles; or `RejectedError`."""
    if all(sign_of(each.kind) == 1 for each in volumes):
        return [("", count)]
    try:
        ranges = sorted((int(str(v.first)), int(str(v.last)) + 1, v.kind) for v in volumes)
    except ValueError as error:
        raise RejectedError("it is damaged: a volume has no range of triangles") from error
    ends = [0, *(end for _, end, _ in ranges)]
    if [*(start for start, _, _ in ranges), count] != ends or sorted({*ends}) != ends:
        raise RejectedError(f"its volumes do not fit the {count:,} triangles of an object")
    return [(kind, end - start) for start, end, kind in ranges]
