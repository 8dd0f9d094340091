"""Print-export: STL files and 3MF plates of the evaluation set, in millimetres.

Inputs: results/D/eval49.parquet, results/D/rescaled/G; results/D/grasps/G.parquet for engraving.
Outputs: results/D/print/G, a folder with manifest.parquet.
"""


rule print_export:
    """Write files for printers, for one gripper."""
    input:
        again_if_incomplete("results/{dataset}/print/{gripper}/manifest.parquet"),
        evaluation="results/{dataset}/eval49.parquet",
        scales="results/{dataset}/rescaled/{gripper}/scales.parquet",
        grasps=touched_surface,
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
        settings=settings_of("print_export"),
        meshes=subpath(input.scales, parent=True),
        grasps=each("--grasps", "grasps"),
        folder=subpath(output.manifest, parent=True),
        code=code_of("print_export"),
    message:
        "Writing print files of {wildcards.dataset} for {wildcards.gripper}"
    shell:
        "egad print-export --settings {params.settings:q} --eval {input.evaluation:q}"
        " --meshes {params.meshes:q} --scales {input.scales:q} --gripper {wildcards.gripper:q}"
        " --out {params.folder:q} {params.grasps:q}"
        " > {log:q} 2>&1"
