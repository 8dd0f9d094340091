"""The helper that runs commands of `egad` within the process of the tests."""

import subprocess
import sys

import commands


def test_what_a_process_of_a_command_says_is_in_its_errors(monkeypatch):
    """In the order in which all of them wrote, and not afterwards."""

    def main():
        print("before", file=sys.stderr)
        subprocess.run([sys.executable, "-SIc", "raise ValueError"], check=False)
        sys.exit("after")

    monkeypatch.setattr(commands, "main", main)
    for _ in range(2):
        first, second, *_, last, end = commands.egad("anything").stderr.splitlines()
        assert (first, last, end) == ("before", "ValueError", "after")
        assert second.startswith("Traceback")
