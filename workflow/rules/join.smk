# One writer per file: all shards of a sweep become its dataset.
rule join:
    input:
        shards=shards_of,
        taken=sidecars_of,
    output:
        data=f"{RESULTS}/{{study}}/{{scene}}.nc",
        taken=f"{RESULTS}/{{study}}/{{scene}}.json",
    log:
        "logs/{study}/{scene}.log",
    benchmark:
        "benchmarks/{study}/{scene}.tsv"
    wildcard_constraints:
        scene=scenes_regex(lambda study, plan: plan.shards > 1),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=60,
    params:
        code=kernel_hash(),
        scene=fingerprint,
        file=study_file,
    message:
        "{wildcards.study}: joining the shards of {wildcards.scene}"
    shell:
        "vibropipe join {params.file:q} --scene {wildcards.scene} --output {output.data:q} {input.shards:q}"
        " > {log} 2>&1"
