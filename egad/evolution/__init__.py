"""MAP-Elites: breeding, evaluation and the archive of elites."""
