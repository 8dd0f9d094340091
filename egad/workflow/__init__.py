"""How scripts of the workflow run, what they share with commands, and the display of a run."""
