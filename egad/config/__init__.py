"""Every setting of the pipeline, as pydantic models.

The models are the only source of names, defaults, bounds and meanings: `check` says what is wrong
with a configuration, `manual` lists them all in `config/README.md`.
Lengths are metres, masses kilograms, densities kg/m3, forces newtons, angles degrees.
"""

from egad.config.sections import DatasetSection, Postprocess, Release
from egad.config.settings import Settings

__all__ = ["DatasetSection", "Postprocess", "Release", "Settings"]
