# Joins the shards of a scene into its dataset, so that each file has one writer.
rule join:
    input:
        shards=RUN.shards,
        timing=RUN.shard_sidecars,
        stale=outdated(f"{RESULTS}/{{study}}/{{scene}}.nc"),
    output:
        data=f"{RESULTS}/{{study}}/{{scene}}.nc",
        timing=f"{RESULTS}/{{study}}/{{scene}}.json",
    log:
        "logs/{study}/{scene}.log",
    wildcard_constraints:
        scene=RUN.scenes_regex(lambda plan: plan.shards > 1),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=60,
    params:
        file=RUN.file,
    message:
        "{wildcards.study}: joining the shards of {wildcards.scene}"
    shell:
        "vibropipe join {params.file:q} --scene {wildcards.scene} --threads {threads}"
        " --output {output.data:q} {input.shards:q}"
        " > {log} 2>&1"
