# A scene that one job solves. The first job that needs a kernel compiles it; others wait for it.
rule solve:
    input:
        stale=outdated(f"{RESULTS}/{{study}}/{{scene}}.nc"),
    output:
        data=f"{RESULTS}/{{study}}/{{scene}}.nc",
        timing=f"{RESULTS}/{{study}}/{{scene}}.json",
    log:
        "logs/{study}/{scene}.log",
    wildcard_constraints:
        scene=RUN.scenes_regex(lambda plan: plan.shards == 1),
    priority: lambda wildcards: RUN.priority(wildcards)
    threads: lambda wildcards: RUN.threads(wildcards, workflow.cores)
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        file=RUN.file,
    message:
        "{wildcards.study}: solving {wildcards.scene}"
    shell:
        "vibropipe solve {params.file:q} --scene {wildcards.scene} --threads {threads}"
        " --output {output.data:q} > {log} 2>&1"


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
        scene=RUN.scenes_regex(lambda plan: plan.shards > 1, folder="shards/"),
    priority: lambda wildcards: RUN.priority(wildcards)
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        file=RUN.file,
        cut=RUN.cut,
    message:
        "{wildcards.study}: solving {wildcards.scene}, shard {params.cut}"
    shell:
        "vibropipe solve {params.file:q} --scene {wildcards.scene} --shard {params.cut}"
        " --threads {threads} --output {output.data:q} > {log} 2>&1"
