"""The rules of the workflow, as their files have them."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXT = "".join(path.read_text() for path in sorted((ROOT / "workflow/rules").glob("*.smk")))
_BODY = r":\n((?: .*\n|\n)+)"
# Those that are written out, and those that are copies of one, with its name.
OWN = dict(re.findall(rf"^rule (\w+){_BODY}", TEXT, flags=re.MULTILINE))
COPIES = {
    name: (base, text)
    for base, name, text in re.findall(
        rf"^use rule (\w+) as (\w+) with{_BODY}", TEXT, flags=re.MULTILINE
    )
}


def script_of(rule):
    """The name of the script that a rule runs."""
    base = COPIES[rule][0] if rule in COPIES else rule
    return re.search(r'script:\n +"\.\./scripts/(\w+)\.py"', OWN[base])[1]
