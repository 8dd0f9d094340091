"""Errors that are meant to be read by a person."""

LESS_MEMORY = "use fewer cores: --jobs of a command, --cores of the workflow"


class UserError(Exception):
    """Something the person at the keyboard can mend: what is wrong, where, what is allowed."""


class RejectedError(Exception):
    """One object cannot be used. The message is the reason; the other objects go on."""


class TableError(ValueError):
    """A Parquet file is missing, damaged, or does not have the columns of its schema."""
