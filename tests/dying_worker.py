"""What a stage opens in a process of its own, and dies there."""

import os


class Dying:
    def __init__(self, *_):
        pass

    def __enter__(self):
        return lambda _: os._exit(11)

    def __exit__(self, *_):
        pass
