"""The `egad` command: one module per command, and `commands` for the list of all."""

from egad_workflow.program import readable_errors, start_logging


def main() -> None:
    """Run the command."""
    start_logging()
    with readable_errors():
        from egad.cli.commands import app

        app(prog_name="egad")
