"""A page about trials alone, of the simulation or of a real robot."""

from collections.abc import Mapping

import pandas as pd

from egad.report.environment import environment
from egad.report.trial_views import Set, results


def page(tables: Mapping[str, pd.DataFrame], tried: Set) -> str:
    """Show what detectors achieved.

    Args:
        tables: Columns of `tables.evaluation.RESULTS`, by detector.
        tried: The evaluation set.

    Returns:
        An HTML page that needs no other file.
    """
    template = environment().get_template("trial_results.html.j2")
    return template.render(results=results(tables, tried))
