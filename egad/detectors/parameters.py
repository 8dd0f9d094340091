"""Settings of grasp detectors."""

from typing import Self

from pydantic import Field, model_validator

from egad._util.parameters import Parameters

SHIPPED = ("antipodal-cloud", "antipodal-depth", "ggcnn", "labels", "random", "vgn")


class DetectorConfig(Parameters):
    """A named grasp detector."""

    detector: str = Field(
        description=f"a built-in one ({', '.join(SHIPPED)}), or your own: FILE.py:CLASS or "
        "package.module:CLASS"
    )
    weights: str | None = Field(
        None, description="file that the detector loads, such as the weights of a network"
    )

    @model_validator(mode="after")
    def _detector_can_be_found(self) -> Self:
        module, _, name = self.detector.rpartition(":")
        if self.detector not in SHIPPED and not (module and name.isidentifier()):
            raise ValueError(
                f"detector is {self.detector!r}; allowed: {', '.join(SHIPPED)}, "
                "FILE.py:CLASS or package.module:CLASS"
            )
        if self.weights and self.detector in SHIPPED and self.detector not in ("ggcnn", "vgn"):
            raise ValueError(f"the detector {self.detector} takes no `weights`")
        return self


DETECTORS = {name: DetectorConfig(detector=name) for name in SHIPPED}
