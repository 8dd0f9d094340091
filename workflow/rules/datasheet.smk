"""Datasheet: a readable description of an evaluation set.

Inputs: results/D/eval49.parquet; for every target gripper results/D/print/G and results/D/grasps/G.parquet.
Outputs: results/D/eval49/README.md, contact-sheet.pdf and trials.csv.
"""

from egad.evalset import DataSheets


rule datasheet:
    """Write the datasheet, a contact sheet, and an empty table for attempts."""
    input:
        evaluation="results/{dataset}/eval49.parquet",
        manifests=lambda wildcards: expand(
            "results/{dataset}/print/{gripper}/manifest.parquet",
            gripper=SETTINGS.targets.grippers,
            **wildcards,
        ),
        grasps=lambda wildcards: expand(
            "results/{dataset}/grasps/{gripper}.parquet",
            gripper=SETTINGS.targets.grippers,
            **wildcards,
        ),
    output:
        page=ensure("results/{dataset}/eval49/README.md", non_empty=True),
        sheet=report(
            ensure("results/{dataset}/eval49/contact-sheet.pdf", non_empty=True),
            caption="../report/contact_sheet.rst",
            category="Evaluation set",
            labels={"dataset": "{dataset}"},
        ),
        trials=ensure("results/{dataset}/eval49/trials.csv", non_empty=True),
    log:
        "logs/{dataset}/datasheet.log",
    benchmark:
        "benchmarks/{dataset}/datasheet.tsv"
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1000, minutes=10),
    params:
        settings=settings_of(DataSheets),
        grippers=SETTINGS.targets.grippers,
        out=subpath(output.page, parent=True),
        introduction="",
        code=code_of("datasheet"),
    message:
        "Writing the datasheet of {wildcards.dataset}"
    script:
        "../scripts/datasheet.py"
