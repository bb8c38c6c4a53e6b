# Figures, each drawn again only if its own data or options have changed, and the report.
rule figure:
    input:
        data=RUN.figure_data,
        stale=outdated(
            f"{RESULTS}/{{study}}/figures/{{figure}}.svg",
            f"{RESULTS}/{{study}}/figures/{{figure}}.pdf",
        ),
    output:
        svg=report(
            f"{RESULTS}/{{study}}/figures/{{figure}}.svg",
            caption="../report/figure.rst",
            category=lambda wildcards: RUN.studies[wildcards.study].title,
            labels=figure_labels,
        ),
        pdf=f"{RESULTS}/{{study}}/figures/{{figure}}.pdf",
    log:
        "logs/{study}/figures/{figure}.log",
    wildcard_constraints:
        figure=RUN.figure_regex(),
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        file=RUN.file,
        results=lambda wildcards: RESULTS,
    message:
        "{wildcards.study}: drawing {wildcards.figure}"
    shell:
        "vibropipe figure {params.file:q} --results {params.results:q} --only {wildcards.figure}"
        " > {log} 2>&1"


rule study_report:
    input:
        data=lambda wildcards: RUN.datasets(wildcards.study),
        figures=lambda wildcards: RUN.figures(wildcards.study, "pdf"),
        stale=outdated(f"{RESULTS}/{{study}}/report.pdf"),
    output:
        report(
            f"{RESULTS}/{{study}}/report.pdf",
            caption="../report/study.rst",
            category=lambda wildcards: RUN.studies[wildcards.study].title,
            labels={"scene": "all", "title": "the whole study", "picture": "PDF"},
        ),
    log:
        "logs/{study}/report.log",
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        file=RUN.file,
        results=lambda wildcards: RESULTS,
    message:
        "{wildcards.study}: typesetting the report"
    shell:
        "vibropipe report {params.file:q} --results {params.results:q} --output {output:q}"
        " > {log} 2>&1"
