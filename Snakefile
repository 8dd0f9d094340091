"""The entry of the workflow: `snakemake --cores 2` makes everything up to the report."""


include: "workflow/Snakefile"


# an included rule cannot be the default target of the file that includes it
workflow.default_target = "all"
