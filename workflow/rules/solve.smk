# Scenes that are solved whole: the small ones of a study in one job, each longer one in its own. A job leaves what is up
# to date. The first process that needs a kernel compiles it; others wait for it.
for study, scenes in RUN.batches():

    rule:
        name:
            ".".join(["solve", study, *scenes[:1]])
        input:
            stale=outdated(*(f"{RESULTS}/{study}/{s}.nc" for s in scenes)),
        output:
            data=[kept(study, f"{s}.nc") for s in scenes],
        log:
            f"logs/{{study}}/solve-{scenes[0]}.log",
        wildcard_constraints:
            study=study,
        priority: RUN.priority(study, scenes)
        threads: lambda wildcards, scenes=scenes: RUN.threads(wildcards.study, scenes, CORES)
        resources:
            mem_mb=1000,
            runtime=30,
        params:
            file=RUN.file,
            results=lambda wildcards: RESULTS,
            scenes=[f"--scene={s}" for s in scenes],
            stale=", ".join(RUN.stale_of(study, "{}.nc", scenes))
            or "nothing: all is complete",
        message:
            "{wildcards.study}: solving {params.stale}"
        shell:
            "vibropipe solve {params.file:q} --results {params.results:q} {params.scenes}"
            " --threads {threads} --logs logs/{wildcards.study} > {log} 2>&1"
