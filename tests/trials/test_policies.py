from typing import get_args

from egad.settings import Targets
from egad.trials.policies import DETECTORS


def test_the_settings_allow_just_the_detectors_that_there_are() -> None:
    (names,) = get_args(Targets.model_fields["policies"].annotation)
    assert set(get_args(names)) == set(DETECTORS)
