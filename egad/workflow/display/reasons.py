"""Why jobs run again: which settings have changed, in words, as `snakemake -n` shows it."""

import ast
import re
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any

from egad.workflow.display.messages import LOGGER

MOST = 6  # changes of a job that are shown
VERSION = re.compile(r"[0-9a-f]{16}")
NAMES = {"code": "the code of this stage", "contents": "the contents of a file"}


def explain_reasons(workflow: Any) -> None:  # noqa: ANN401 (of Snakemake)
    """Let the messages of Snakemake name the settings because of which a job runs again."""
    for handler in LOGGER.handlers:
        handler.addFilter(partial(_name_changes, workflow))


def _name_changes(workflow: Any, record: Any) -> bool:  # noqa: ANN401 (of Snakemake)
    if "Params have changed" in (getattr(record, "reason", None) or ""):
        job = next(each for each in workflow.dag.jobs if each.jobid == record.jobid)
        change = workflow.dag.reason(job).params_changed
        now = {name: value for name, value in job.params.items() if repr(value) in change.only_new}
        words = changes(change.only_old, now)
        for kind in ("gripper", "detector"):  # stages get one of them
            if name := job.wildcards.get(kind):
                words = re.sub(rf"\b{kind}\.", f"{kind}s.{name}.", words)
        record.reason = record.reason.replace(
            f"Params have changed since last execution: {change}",
            f"Changed since last execution: {words}",
        )
    return True


def changes(before: Collection[str], now: Mapping[str, Any]) -> str:
    """The differences between params.

    Args:
        before: Former values of those that have changed, as Snakemake keeps them: without names.
        now: Their new values.
    """
    former = [_value(text) for text in before]
    found = [each for name, value in now.items() for each in _changes_of(name, value, former)]
    rest = [f"and {len(found) - MOST} more"] if len(found) > MOST else []
    return ", ".join([*found[:MOST], *rest]) or "parameters that are no longer there"


def _changes_of(name: str, value: Any, former: list[Any]) -> Iterator[str]:  # noqa: ANN401
    same_kind = [each for each in former if type(each) is type(value)]
    if (not isinstance(value, dict) and VERSION.search(repr(value))) or len(same_kind) != 1:
        yield NAMES.get(name, name)
        return
    old, new = (dict(_flat(each, name)) for each in (same_kind[0], value))
    for key in sorted(old.keys() | new.keys()):
        if old.get(key) != new.get(key):
            yield f"{key.removeprefix('settings.')} {old.get(key)} -> {new.get(key)}"


def _flat(value: Any, name: str) -> Iterator[tuple[str, Any]]:  # noqa: ANN401 (plain values)
    """The entries of nested tables by the names that the configuration gives them."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, each in value.items():
        yield from _flat(each, f"{name}.{key}")


def _value(text: str) -> Any:  # noqa: ANN401 (plain values)
    try:
        return ast.literal_eval(text)
    except ValueError:  # `inf`
        return text
