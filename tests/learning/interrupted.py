"""Trainings that end after their second epoch, and whether two have the same result."""

import pytest

torch = pytest.importorskip("torch")
training = pytest.importorskip("egad.learning.training")


class InterruptionError(Exception):
    pass


class Breaking(training.Checkpoint):
    def save(self, state):
        super().save(state)
        if len(state.rows) == 2:
            raise InterruptionError


def same(one, other):
    return one[0] == other[0] and all(torch.equal(one[1][name], other[1][name]) for name in one[1])
