"""Random generators that depend on what they are for, never on when they are made."""

import hashlib

import numpy as np


def entropy(seed: int, purpose: str, *index: int | str) -> int:
    """A 128-bit number that names one random stream.

    Args:
        seed: The seed of the configuration.
        purpose: What the numbers are for, e.g. `"regrade"`.
        *index: Which one of these, e.g. epoch, island and step, or an object's id.

    Returns:
        The same number on every machine; unrelated for any two different arguments.
    """
    text = "\x1f".join([str(seed), purpose, *map(str, index)])
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:16], "little")


def generator(seed: int, purpose: str, *index: int | str) -> np.random.Generator:
    """A numpy generator for one purpose (see `entropy`)."""
    return np.random.default_rng(entropy(seed, purpose, *index))
