"""Settings of older versions are told by their new names, which CHANGELOG.md lists."""

from pathlib import Path

import pytest

from egad.config.check import check
from egad.config.renamed import RENAMED
from egad.errors import UserError

CHANGELOG = (Path(__file__).parents[2] / "CHANGELOG.md").read_text(encoding="utf-8")


def listed():
    """The old names of settings in the first table, and the text about each, as it stands there."""
    table = CHANGELOG.split("\n| --- | --- |\n")[1].split("\n\n")[0]
    for line in table.splitlines():
        old, new = (cell.strip().replace("`", "") for cell in line.strip("| ").split(" | ", 1))
        if old != "(new)":
            yield old, new


def as_config(key):
    """A configuration with a setting of an older version."""
    path, _, value = key.partition(": ")
    found = value or 3
    for name in reversed(path.split(".")):
        found = {name: found}
    return found


@pytest.mark.parametrize("key", RENAMED)
def test_an_old_setting_is_refused_with_its_new_name(key):
    with pytest.raises(UserError) as caught:
        check(as_config(key))
    where = key.partition(":")[0]
    lines = [line for line in str(caught.value).split("\n") if line.startswith(f"{where}:")]
    assert any(RENAMED[key] in line for line in lines)


def keys_of(old):
    """The keys that a cell of the table means."""
    if ": " in old:  # a value; or a key and its values
        return [old if old in RENAMED else old.partition(": ")[0]]
    first, *others = old.split(", ")
    return [first, *others]


def test_the_new_names_are_those_of_the_changelog():
    texts = {key: new for old, new in listed() for key in keys_of(old)}
    assert texts.keys() == RENAMED.keys()
    for key, new in RENAMED.items():
        assert new in texts[key]
