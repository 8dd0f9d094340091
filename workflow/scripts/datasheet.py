"""datasheet: a readable description of an evaluation set."""

from egad.report.datasheet import write_datasheet as run
from egad_workflow.job import run_job

if __name__ == "__main__":
    run_job(run)
