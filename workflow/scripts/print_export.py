"""print-export: STL files and 3MF plates of the evaluation set, in millimetres."""

from egad.evalset import write_print_files as run
from egad_workflow.job import run_job

if __name__ == "__main__":
    run_job(run)
