# One compilation per version of the kernels: every solving job waits for it and none repeats it. That
# the stamp is `ancient` lets a new kind of scene be compiled without solving the others again.
rule warm:
    output:
        f"{RESULTS}/.kernels/{kernel_hash()}",
    log:
        "logs/warm.log",
    benchmark:
        "benchmarks/warm.tsv"
    threads: 2
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        work=works(),
        files=study_files(),
    message:
        "compiling the kernels"
    shell:
        "vibropipe warm {params.files:q} --threads {threads} --stamp {output:q} > {log} 2>&1"


# A scene that is one job's work.
rule solve:
    input:
        kernels=ancient(rules.warm.output),
    output:
        data=f"{RESULTS}/{{study}}/{{scene}}.nc",
        taken=f"{RESULTS}/{{study}}/{{scene}}.json",
    log:
        "logs/{study}/{scene}.log",
    benchmark:
        "benchmarks/{study}/{scene}.tsv"
    wildcard_constraints:
        scene=scenes_regex(
            lambda study, plan: plan.shards == 1
            and not (is_wide(plan) or is_early(study, plan))
        ),
    # before anything is drawn, but for the longest figures
    priority: 5
    threads: threads_of
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        code=kernel_hash(),
        scene=fingerprint,
        file=study_file,
    message:
        "{wildcards.study}: solving {wildcards.scene}"
    shell:
        "vibropipe solve {params.file:q} --scene {wildcards.scene} --threads {threads}"
        " --output {output.data:q} > {log} 2>&1"


# What wants several cores begins first: later it would wait for them until all others are done, and its figures
# would come last, alone.
use rule solve as solve_wide with:
    wildcard_constraints:
        scene=scenes_regex(lambda study, plan: plan.shards == 1 and is_wide(plan)),
    priority: 20


# What would keep one core at work when there is nothing left for the others.
use rule solve as solve_early with:
    wildcard_constraints:
        scene=scenes_regex(
            lambda study, plan: plan.shards == 1
            and not is_wide(plan)
            and is_early(study, plan)
        ),
    priority: 15


# A part of a sweep that is too long for one job; kept until the join has used it.
rule solve_shard:
    input:
        kernels=ancient(rules.warm.output),
    output:
        data=temp(f"{RESULTS}/{{study}}/shards/{{scene}}/{{shard}}.nc"),
        taken=temp(f"{RESULTS}/{{study}}/shards/{{scene}}/{{shard}}.json"),
    log:
        "logs/{study}/{scene}/{shard}.log",
    benchmark:
        "benchmarks/{study}/{scene}/{shard}.tsv"
    wildcard_constraints:
        scene=scenes_regex(lambda study, plan: plan.shards > 1, folder="shards/"),
    # the longest work of a study begins first, so that no core waits for it in the end
    priority: 10
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        code=kernel_hash(),
        scene=fingerprint,
        file=study_file,
        cut=cut,
    message:
        "{wildcards.study}: solving {wildcards.scene}, shard {params.cut}"
    shell:
        "vibropipe solve {params.file:q} --scene {wildcards.scene} --shard {params.cut}"
        " --threads {threads} --output {output.data:q} > {log} 2>&1"
