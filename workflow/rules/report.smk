# Figures, each drawn again only if its own data or options have changed, and the report.
rule figure:
    input:
        lambda wildcards: RUN.figure_data(wildcards),
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
        code=drawing_hash(),
        options=RUN.figure_options,
        file=RUN.file,
        results=lambda wildcards: RESULTS,
    message:
        "{wildcards.study}: drawing {wildcards.figure}"
    shell:
        "vibropipe figure {params.file:q} --results {params.results:q} --only {wildcards.figure}"
        " > {log} 2>&1"


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
