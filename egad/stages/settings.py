from egad.stage_settings import *  # noqa: F403
