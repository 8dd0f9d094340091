"""Errors that are meant to be read by a person."""

LESS_MEMORY = "use fewer cores: --jobs of a command, --cores of the workflow"


class EgadError(Exception):
    """Any error that egad raises on purpose: the message is a sentence for a person."""


class UserError(EgadError, ValueError):
    """Something the person at the keyboard can mend: what is wrong, where, what is allowed."""


class RejectedError(EgadError):
    """One object cannot be used. The message is the reason; the other objects go on."""


class TableError(EgadError, ValueError):
    """A Parquet file is missing, damaged, or does not have the columns of its schema."""
