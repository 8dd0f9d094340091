"""MAP-Elites: variation, evaluation and the archive of elites."""
