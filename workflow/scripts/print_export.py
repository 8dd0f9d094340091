"""print-export: STL files and 3MF plates of the evaluation set, in millimetres."""

from egad.workflow.job import run_job
from egad.workflow.print_files import write_print_files as run

if __name__ == "__main__":
    run_job(run)
