"""Print-export: STL files and 3MF plates of the evaluation set, in millimetres.

Inputs: results/D/eval49.parquet, results/D/rescaled/G; results/D/grasps/G.parquet for engraving.
Outputs: results/D/print/G, a folder with manifest.parquet.
"""

from egad.evalset import PrintFiles


rule print_export:
    """Write files for printers, for one gripper."""
    input:
        again_if_incomplete("results/{dataset}/print/{gripper}/manifest.parquet"),
        evaluation="results/{dataset}/eval49.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        # engraved labels avoid them
        grasps=only_if(
            SETTINGS.print_export.engraving, "results/{dataset}/grasps/{gripper}.parquet"
        ),
    output:
        manifest=ensure("results/{dataset}/print/{gripper}/manifest.parquet", non_empty=True),
    log:
        "logs/{dataset}/print_export/{gripper}.log",
    benchmark:
        "benchmarks/{dataset}/print_export/{gripper}.tsv"
    # A long job on one core; the datasheet needs it.
    priority: 1
    conda:
        ENVIRONMENT
    threads: 1
    resources:
        **needs(mb=1500, minutes=10),
    params:
        settings=settings_of(PrintFiles),
        meshes=subpath(input.scales, parent=True),
        out=subpath(output.manifest, parent=True),
        code=code_of("print_export"),
    message:
        "Writing print files of {wildcards.dataset} for {wildcards.gripper}"
    script:
        "../scripts/print_export.py"
