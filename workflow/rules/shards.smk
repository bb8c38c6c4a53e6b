# A shard of a scene that is too long for one job; deleted after the join.
rule solve_shard:
    input:
        stale=outdated(f"{RESULTS}/{{study}}/shards/{{scene}}/{{shard}}.nc"),
    output:
        data=temp(f"{RESULTS}/{{study}}/shards/{{scene}}/{{shard}}.nc"),
        timing=temp(f"{RESULTS}/{{study}}/shards/{{scene}}/{{shard}}.json"),
    log:
        "logs/{study}/{scene}/{shard}.log",
    wildcard_constraints:
        scene=RUN.scenes_regex("shards/"),
    priority: lambda wildcards: RUN.priority(wildcards.study, [wildcards.scene])
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        file=RUN.file,
        results=lambda wildcards: RESULTS,
        cut=RUN.cut,
    message:
        "{wildcards.study}: solving {wildcards.scene}, shard {params.cut}"
    shell:
        "vibropipe solve {params.file:q} --results {params.results:q} --scene {wildcards.scene} --shard {params.cut}"
        " --threads {threads} --output {output.data:q} > {log} 2>&1"


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
        scene=RUN.scenes_regex(),
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
