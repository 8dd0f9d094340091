"""Compile the modules that runs import, once, so that no job has to.

    .venv/bin/python envs/compile.py

pip would compile all modules of all packages, which takes longer than the rest of a setup and twice
the space. Where Python may not keep compiled modules, each job would compile what it imports.
"""

import importlib
import pkgutil
import sys

import egad
import egad_workflow

# What Snakemake imports only while it runs.
LATER = (
    "requests",
    "rich.markdown",
    "rich.progress",
    "smart_open",
    "snakemake.cli",
    "snakemake.report.html_reporter",
    "yte",
)


def main() -> None:
    """Import all; extras need not be installed."""
    sys.dont_write_bytecode = False
    found = [
        *pkgutil.walk_packages(egad.__path__, "egad."),
        *pkgutil.walk_packages(egad_workflow.__path__, "egad_workflow."),
    ]
    modules = [each.name for each in found]
    for name in [*modules, *LATER]:
        try:
            importlib.import_module(name)
        except ImportError as error:
            if (error.name or "").startswith(("egad", "snakemake")):
                raise


if __name__ == "__main__":
    main()
