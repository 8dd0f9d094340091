"""Where files come from, read back: as a tree, and whether they are still what was made."""
