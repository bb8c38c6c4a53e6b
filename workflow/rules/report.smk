# What is drawn from the datasets, by one job per study: starting matplotlib costs more than a figure.
for name in STUDIES:

    rule:
        name:
            f"figures_{name}"
        input:
            datasets(name),
        output:
            svg=pictures_for_report(name),
            pdf=pictures(name, "pdf"),
        log:
            f"logs/{name}/figures.log",
        benchmark:
            f"benchmarks/{name}/figures.tsv"
        # the more figures, the longer it takes and the sooner it begins
        priority: min(len(STUDIES[name].scenes), 15)
        threads: 1
        resources:
            mem_mb=2000,
            runtime=10,
        params:
            code=drawing_hash(),
            words=words_hash(name),
            file=str(SETTINGS.study_file(name)),
            results=lambda wildcards: RESULTS,
        message:
            f"{name}: drawing the figures"
        shell:
            "vibropipe figure {params.file:q} --results {params.results:q} > {log} 2>&1"


rule study_report:
    input:
        lambda wildcards: datasets(wildcards.study),
        lambda wildcards: pictures(wildcards.study, "pdf"),
    output:
        report(
            f"{RESULTS}/{{study}}/report.pdf",
            caption="../report/study.rst",
            category=lambda wildcards: STUDIES[wildcards.study].title,
            labels={"scene": "all", "title": "report"},
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
        words=lambda wildcards: words_hash(wildcards.study),
        file=study_file,
        results=lambda wildcards: RESULTS,
    message:
        "{wildcards.study}: typesetting the report"
    shell:
        "vibropipe report {params.file:q} --results {params.results:q} --output {output:q}"
        " > {log} 2>&1"
