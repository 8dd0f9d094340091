"""Settings of a release and of its gallery."""

from pydantic import Field

from egad._util.parameters import Fraction, Name, ParameterGroup, Parameters
from egad.evolution import EvolutionParameters
from egad.exchange.registry import ObjectFormat
from egad.geometry import Material
from egad.grasps import Quality
from egad.grippers import Gripper


class Release(Parameters):
    """The folder `results/release`, a dataset that anyone can host: docs/released.md."""

    dataset: Name = "egad"
    """dataset whose objects are released"""
    gripper: Name = "panda"
    """gripper that the objects are scaled to and the grasps are for, from the table `grippers`"""
    grasps: int = Field(100, ge=1)
    """maximum number of grasps per object; only grasps with a simulated label are released, at most
    `simulated_label.grasps`"""
    validation: Fraction = Field(0.15, lt=1)
    """maximum fraction of the objects outside the test split to use for validation; families are
    kept together"""
    archives: list[ObjectFormat] = Field(["urdf", "mjcf"])
    """formats of the object archives for simulators; usd needs `pip install 'egad[usd]'`"""
    title: str = "EGAD: evolved objects for robot grasping"
    """human-readable name of the dataset"""
    version: str = "1.0.0"
    """version of the dataset, stated in its card"""
    date: str | None = Field(None, pattern=r"^\d{4}-\d{2}-\d{2}$")
    """date of publication, YYYY-MM-DD, stated in its card"""
    url: str | None = None
    """address of the folder where it is hosted, or of the dataset on Hugging Face; stated in its
    card"""


class Gallery(EvolutionParameters):
    """The gallery: how genomes become shapes, the space, and the gripper of the release."""

    map_gripper: Gripper  # the one that graspability is for
    release: Release


class ReleaseTables(ParameterGroup):
    """Tables of a release."""

    seed: int
    release: Release


class ReleaseCard(ParameterGroup):
    """What the card of a release says."""

    release: Release
    material: Material
    quality: Quality
