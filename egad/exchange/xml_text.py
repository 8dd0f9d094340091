"""Text of XML descriptions: numbers, inertia and the document."""

from xml.etree import ElementTree

import numpy as np

from egad.geometry import MassProperties

DRAKE = "http://drake.mit.edu"  # namespace of what Drake adds to URDF and SDFormat
# kg m2: MuJoCo takes no principal moment below 1e-14, that of a ball of 0.9 mm at 400 kg/m3. A body
# with a larger moment starts and stops turning more slowly, and falls as before.
MIN_MOMENT = 2e-14
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def number_text(*values: float) -> str:
    """Numbers separated by spaces, with enough digits to read them back."""
    return " ".join(repr(float(value)) for value in values)


def moments(physics: MassProperties) -> dict[str, float]:
    """The moments of inertia about the center of mass, kg m2, by their names in URDF and SDFormat.

    Principal moments below 2e-14 kg m2 are raised to it, which simulators need.
    """
    tensor = physics.inertia
    principal, axes = np.linalg.eigh(tensor)
    if principal.min() < MIN_MOMENT:
        tensor = (axes * np.maximum(principal, MIN_MOMENT)) @ axes.T
    values = (*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])
    return {name: float(value) for name, value in zip(MOMENTS, values, strict=True)}


def xml_document(root: ElementTree.Element) -> str:
    """The document as indented text."""
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
