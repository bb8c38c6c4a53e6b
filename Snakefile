# Lets `snakemake` find the workflow from the root, where the standard layout has it in workflow/.
include: "workflow/Snakefile"


rule everything:
    default_target: True
    input:
        rules.all.input,
    message:
        "everything is made"
