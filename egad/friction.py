"""Friction of every surface that touches an object, and which use takes it.

| contact | taken from | used by |
| --- | --- | --- |
| that grasps are rated for | `FRICTION` | `quality.friction`; also the pads of simulated labels |
| finger pads on an object | `PADS`, or `friction` of a gripper | trials |
| ring of a suction cup on an object | `CUP_RING` | `cup.friction`: labels and trials |
| table under an object | `TABLE`, `TABLE_ROLLING` | trials |
| objects against each other and walls | `OBJECT` | trials with several objects |
| objects in files for other programs | `OBJECT`, `MJCF_SPIN` | `bundle.friction`, `egad export` |

In MuJoCo, the number of table or robot counts, whatever touches it. PyBullet multiplies the numbers
of both bodies and Drake takes their harmonic mean, so their worlds correct them for the object's.
"""

from typing import NamedTuple


class Surface(NamedTuple):
    """A surface that an object touches."""

    friction: float  # sliding
    radius: float = 0.0  # of the contact patch on a round object, metres; it resists twisting

    @property
    def torsion(self) -> float:
        """Torque about the normal per newton, as of a pressed disc, metres."""
        return 2 / 3 * self.friction * self.radius


FRICTION = 0.5
CUP_RING = Surface(0.5)
# Finger pads on printed plastic (our own typical values)
PADS = {"silicone": Surface(0.8, 0.005), "bare": Surface(0.4, 0.002)}
TABLE = Surface(0.5)  # plastic on wood or paper
# Metres that the table pushes ahead of an object that rolls. Without it, a ball rolls forever.
TABLE_ROLLING = 0.001
OBJECT = Surface(0.5)
MJCF_SPIN = (0.005, 0.0001)  # torsional and rolling, MuJoCo's defaults
