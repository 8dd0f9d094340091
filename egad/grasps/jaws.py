"""How jaws that are not parallel affect a grasp (ours).

The faces of a jaw that turns are parallel at one opening only. An object between them touches both,
and the line of the closing force then leans by half the angle to either face: a body that lies flat
against one face presses on it off its middle, and a round one turns. So friction must carry half
the angle at each contact, whatever the surface of the object is like, or the object is squeezed
out.
"""

from typing import NamedTuple, Self

import numpy as np

from egad._util.arrays import Floats
from egad.grasps.antipodal import ContactPairs
from egad.grippers import HandBody, JawBody


class JawFaces(NamedTuple):
    """The inner faces of a hand with one moving jaw, at n grasps."""

    body: JawBody
    approaches: Floats  # (n, 3) unit vectors along which it points
    excess: Floats  # (n,) how much wider than the contacts it stays open, stopped before, metres

    @classmethod
    def of(
        cls, body: HandBody, grasps: ContactPairs, approaches: Floats, needed: Floats
    ) -> Self | None:
        """The jaw faces at n grasps at the openings they need, metres; None for parallel jaws."""
        if not isinstance(body, JawBody):
            return None
        excess = np.where(np.isfinite(needed), needed - grasps.widths, 0.0)
        return cls(body, approaches, excess)

    def normals(self, grasps: ContactPairs) -> Floats:
        """Outward normals (n, 2, 3) of an object that fits the faces at the contacts.

        The grasps are the same, or as many copies of each, grasp by grasp.
        """
        copies = len(grasps) // max(len(self.excess), 1)
        excess = np.repeat(self.excess, copies)
        approaches = np.repeat(self.approaches, copies, axis=0)
        angles = self.body.model.angle_at(grasps.widths + excess)
        return face_normals(grasps.axes, approaches, angles)


def face_normals(axes: Floats, approaches: Floats, angles: Floats) -> Floats:
    """Outward normals (n, 2, 3) of objects that fit between jaws at angles (n,), radians.

    Positive angles are those of faces farther apart at the tips. Both lean equally to the axes (n,
    3); the components of the approaches along them do not count.
    """
    along = np.einsum("nk,nk->n", approaches, axes)[:, None] * axes
    ahead = approaches - along
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    cosine, sine = np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None]
    return np.stack([-cosine * axes - sine * ahead, cosine * axes - sine * ahead], axis=1)
