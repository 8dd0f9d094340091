"""Work of a stage that engines may crash in: in a process that is started again."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from egad._util.child_process import (
    MakeWork,
    Work,
    Worker,
    WorkerDiedError,
    WorkerTimeoutError,
    one_thread,
)

log = logging.getLogger(__name__)
MAX_ATTEMPTS = 2


class RestartingWorker(Worker):
    """Work in one thread of a process of its own, restarted when it dies or takes too long."""

    def __init__(self, make_work: MakeWork, limit: float | None = None) -> None:
        """Prepare as a `Worker`; a process that takes longer than `limit` counts as dead."""
        super().__init__(partial(_in_one_thread, make_work), limit)

    def __call__(self, item: Any) -> Any:  # noqa: ANN401 (whatever the work takes and gives)
        """The work on one item, or what it raises; None if the process died of it twice."""
        for _ in range(MAX_ATTEMPTS):
            try:
                return super().__call__(item)
            except (WorkerDiedError, WorkerTimeoutError) as error:
                log.warning("%s", error)
        return None


@contextmanager
def _in_one_thread(make_work: MakeWork) -> Iterator[Work]:
    with one_thread(), make_work() as work:
        yield work
