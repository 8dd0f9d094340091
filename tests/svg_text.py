"""What a figure says."""

from xml.etree import ElementTree

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    """All texts of an SVG figure, in their order."""
    root = ElementTree.fromstring(svg)  # noqa: S314 (our own)
    return ["".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")]
