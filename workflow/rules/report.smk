# The figures of a study and its report. The job draws only those figures whose own data or options have changed.
for study in RUN.studies:

    rule:
        name:
            f"report.{study}"
        input:
            data=RUN.datasets(study),
            stale=outdated(*RUN.drawn(study)),
        output:
            svg=[
                report(
                    kept(study, f"figures/{figure}.svg"),
                    caption=CAPTIONS.get((study, figure)),
                    category=RUN.studies[study].title,
                    labels=labels,
                )
                for figure, labels in figure_labels(RUN.studies[study]).items()
            ],
            pdf=[kept(study, f"figures/{n}.pdf") for n in RUN.drawn_scenes(study)],
            report=report(
                kept(study, "report.pdf"),
                caption="../report/study.rst",
                category=RUN.studies[study].title,
                labels={"scene": "all", "title": "the whole study", "picture": "PDF"},
            ),
        log:
            "logs/{study}/report.log",
        wildcard_constraints:
            study=study,
        threads: lambda wildcards: RUN.drawing_threads(wildcards.study, CORES)
        resources:
            mem_mb=2000,
            runtime=10,
        params:
            file=RUN.file,
            results=lambda wildcards: RESULTS,
            makes=RUN.drawing(study),
        message:
            "{wildcards.study}: {params.makes}"
        shell:
            "vibropipe report {params.file:q} --results {params.results:q} --threads {threads}"
            " --output {output.report:q} > {log} 2>&1"
