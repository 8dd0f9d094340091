"""Memory and time of each rule: `python docs/scripts/cluster.py FOLDERS` of finished runs.

docs/cluster.md has the rules that take most.
"""

import re
import sys
from pathlib import Path

import pandas as pd

ROOT = Path(__file__).parents[2]
RULE = re.compile(
    r"^(?:use rule (\w+)(?: from egad)? as|rule) (\w+)(.*?)(?=^\S|\Z)", re.DOTALL | re.MULTILINE
)
ASKED = re.compile(r"needs\(mb=(\d+)(?:, mb_per_thread=(\d+))?, minutes=(\d+)\)")


def needs() -> dict[str, tuple[str, ...]]:
    """Megabytes, further megabytes for each thread if any, and minutes, by rule."""
    found: dict[str, tuple[str, ...]] = {}
    files = sorted(
        (ROOT / "workflow/rules").glob("*.smk"), key=lambda path: path.name != "join.smk"
    )
    for base, name, text in (rule for path in files for rule in RULE.findall(path.read_text())):
        asked = ASKED.search(text)
        if asked or base in found:
            found[name] = asked.groups("") if asked else found[base]
    return found


NEEDS = needs()


def main(folders: list[Path]) -> None:
    """Print the most that a job of each rule used, and what the rule requests."""
    jobs = pd.concat([job(path) for folder in folders for path in folder.rglob("*.tsv")])
    most = jobs.groupby("rule")[["max_rss", "max_pss", "cpu_time"]].max()
    print("| rule | memory, MB | shared counted once | CPU time, s | requested MB | minutes |")
    print("| --- " * 6 + "|")
    for rule, (memory, of_thread, minutes) in NEEDS.items():
        took = [f"{most.at[rule, name]:.0f}" if rule in most.index else "-" for name in most]
        asked = f"{memory}" + f" + {of_thread} a thread" * bool(of_thread)
        print(f"| {rule} | {' | '.join(took)} | {asked} | {minutes} |")


def job(path: Path) -> pd.DataFrame:
    """What a job used, with its rule: the last part of the file's path that names a rule."""
    parts = reversed(path.with_suffix("").parts)
    return pd.read_csv(path, sep="\t").assign(rule=next(name for name in parts if name in NEEDS))


if __name__ == "__main__":
    main([Path(folder) for folder in sys.argv[1:]])
