import numpy as np
import pandas as pd

from egad.map_elites.ribs import ribs_frame
from egad.measures.grid import complexity_cells, difficulty_cells
from egad.pipeline.config import Space


def test_indices_are_those_of_a_grid_over_the_measures():
    """The twin: pyribs' grid over two ranges, by searching the edges."""
    space = Space(cells=5)
    rng = np.random.default_rng(0)
    complexity, difficulty = rng.uniform(1, 5, 50), rng.uniform(0.0005, 0.004, 50)
    archive = pd.DataFrame(
        {
            "id": [str(number) for number in range(50)],
            "complexity": complexity,
            "difficulty": difficulty,
            "diversity": rng.random(50),
            "complexity_cell": complexity_cells(complexity, space),
            "difficulty_cell": difficulty_cells(difficulty, space),
        }
    )
    frame = ribs_frame(archive, space)
    first = np.searchsorted(np.linspace(1, 5, 6), complexity) - 1
    second = np.searchsorted(np.linspace(0.0005, 0.004, 6), difficulty) - 1
    assert frame["index"].tolist() == (5 * first + second).tolist()
    assert frame["objective"].tolist() == archive["diversity"].tolist()
