"""The terminal display while the workflow runs: its jobs and the progress of each.

Jobs write their progress to their logs, whatever machine they run on. Snakemake's own process reads
the ends of these logs, and draws bars on a terminal or prints plain lines elsewhere.
"""

from egad_workflow.display.messages import start_display
from egad_workflow.display.reasons import explain_reasons

__all__ = ["explain_reasons", "start_display"]
