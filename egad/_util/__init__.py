"""Files, worker processes, progress and compiled code: what all packages share."""
