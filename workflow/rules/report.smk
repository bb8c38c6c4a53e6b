# Figures and report. One job draws all figures of a study: starting matplotlib takes longer than a figure.
for name in RUN.studies:

    rule:
        name:
            f"figures_{name}"
        input:
            RUN.datasets(name),
        output:
            svg=figures_for_report(name),
            pdf=RUN.figures(name, "pdf"),
        log:
            f"logs/{name}/figures.log",
        benchmark:
            f"benchmarks/{name}/figures.tsv"
        priority: FIRST
        threads: 1
        resources:
            mem_mb=2000,
            runtime=10,
        params:
            code=drawing_hash(),
            words=RUN.wording(name),
            file=str(RUN.files[name]),
            results=lambda wildcards: RESULTS,
        message:
            f"{name}: drawing the figures"
        shell:
            "vibropipe figure {params.file:q} --results {params.results:q} > {log} 2>&1"


rule study_report:
    input:
        lambda wildcards: RUN.datasets(wildcards.study),
        lambda wildcards: RUN.figures(wildcards.study, "pdf"),
    output:
        report(
            f"{RESULTS}/{{study}}/report.pdf",
            caption="../report/study.rst",
            category=lambda wildcards: RUN.studies[wildcards.study].title,
            labels={"scene": "all", "title": "the whole study", "picture": "PDF"},
        ),
    log:
        "logs/{study}/report.log",
    benchmark:
        "benchmarks/{study}/report.tsv"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        code=drawing_hash(),
        words=lambda wildcards: RUN.wording(wildcards.study),
        file=RUN.file,
        results=lambda wildcards: RESULTS,
    message:
        "{wildcards.study}: typesetting the report"
    shell:
        "vibropipe report {params.file:q} --results {params.results:q} --output {output:q}"
        " > {log} 2>&1"
