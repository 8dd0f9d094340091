"""Why jobs run again: which settings have changed, in words, as `snakemake -n` shows it."""

import ast
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import pandas as pd

from egad_workflow.display.messages import LOGGER

MOST = 6  # changes of a job that are shown
NAMES = {"code": "the code of this stage", "contents": "the contents of a file"}


def explain_reasons(workflow: Any) -> None:  # noqa: ANN401 (of Snakemake)
    """Let the messages of Snakemake name the settings because of which a job runs again."""
    for handler in LOGGER.handlers:
        handler.addFilter(partial(_name_changes, workflow))


def _name_changes(workflow: Any, record: Any) -> bool:  # noqa: ANN401 (of Snakemake)
    with suppress(Exception):  # whatever another version of Snakemake says stays as it is
        if "Params have changed" in record.reason:
            (job,) = (each for each in workflow.dag.jobs if each.jobid == record.jobid)
            change = workflow.dag.reason(job).params_changed
            now = {key: each for key, each in job.params.items() if repr(each) in change.only_new}
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
    """The differences between former values of params, without names, and the new ones."""
    former = list(map(_value, before))
    found = [each for name, value in now.items() for each in _changes_of(name, value, former)]
    rest = [f"and {len(found) - MOST} more"] if len(found) > MOST else []
    return ", ".join([*found[:MOST], *rest]) or "parameters that are no longer there"


def _changes_of(name: str, value: Any, former: list[Any]) -> Iterator[str]:  # noqa: ANN401
    same_kind = [each for each in former if type(each) is type(value)]
    if isinstance(value, str | list) or len(same_kind) != 1:  # most texts are versions
        yield NAMES.get(name, name)
        return
    tables = ({name.removeprefix("settings"): each} for each in (same_kind[0], value))
    old, new = (pd.json_normalize(each, sep=".").to_dict("records")[0] for each in tables)
    for key in sorted(map(str, old.keys() | new.keys())):
        if old.get(key) != new.get(key):
            yield f"{key.removeprefix('.')} {old.get(key)} -> {new.get(key)}"


def _value(text: str) -> Any:  # noqa: ANN401 (plain values)
    with suppress(ValueError, SyntaxError):  # `inf`, `<object at ...>`
        return ast.literal_eval(text)
    return text
