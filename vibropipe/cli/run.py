"""The commands for a study of one's own: `new` writes a template, `run` makes all results."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from vibropipe.cli.options import ResultsFolder
from vibropipe.words.exit_codes import INTERRUPTED

# Folders that contain the workflow: in an installed package, and in a clone.
INSTALLED = Path(__file__).parents[1] / "_workflow"
CLONE = Path(__file__).parents[2]


def run(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Studies, YAML files anywhere.")
    ],
    cores: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Number of cores (default: all).")
    ] = None,
    results: ResultsFolder = Path("results"),
    dry_run: Annotated[
        bool, typer.Option("--dry-run", "-n", help="List the jobs that would run, and run none.")
    ] = False,
) -> None:
    """Run studies: datasets, figures and a report each; completed files that are up to date are kept."""
    from vibropipe.jobs.preparation import check_working_folder
    from vibropipe.jobs.run import read_run

    check_files(files)
    # a mistake is reported at once, before the workflow is loaded
    settings = {"studies": [os.path.relpath(file) for file in files], "results": str(results)}
    read = read_run(None, settings)
    check_working_folder()

    folder = INSTALLED if INSTALLED.is_dir() else CLONE
    command = [
        *("--snakefile", str(folder / "workflow" / "Snakefile")),
        *("--workflow-profile", str(folder / "profiles" / "default")),
        *("--cores", str(cores or os.cpu_count() or 1)),
        *(["--dry-run"] if dry_run else []),
        # snakemake reads these values as YAML, which includes JSON
        "--config",
        *(f"{key}={json.dumps(value)}" for key, value in settings.items()),
    ]
    from snakemake.cli import main

    sys.argv = ["snakemake", *command]
    try:
        main()
    except SystemExit as stop:
        if stop.code == INTERRUPTED:
            # the workflow has said that it was interrupted
            os._exit(INTERRUPTED)
        if stop.code or dry_run:
            raise
    from vibropipe.jobs.summary import PRINTED, summarise

    if PRINTED:  # by the workflow, which calls nothing where nothing is to be done
        return
    summary = summarise(read)
    typer.echo("\n".join(summary.lines), err=True)
    if summary.missing:
        raise typer.Exit(1)


def check_files(files: list[Path]) -> None:
    """Refuse a folder where a study is expected, and name the YAML files in it."""
    for file in files:
        # a name without suffix may be one of a study in the folder of the workflow
        if file.is_dir() and not Path("config", f"{file.name}.yaml").is_file():
            inside = sorted(str(path) for path in file.glob("*.yaml"))
            there = f" (there is {', '.join(inside)})" if inside else ""
            raise typer.BadParameter(
                f"must be a YAML file, got the folder {file}{there}", param_hint="FILE"
            )


def new(
    name: Annotated[
        Path, typer.Argument(metavar="NAME", help="Name of the study, or its file: NAME.yaml.")
    ],
    units: Annotated[
        bool, typer.Option("--units", help="Write a study whose parameters have units.")
    ] = False,
) -> None:
    """Write a template study, and beside it the schema by which editors check it."""
    from importlib.resources import files

    from vibropipe.scenes.keys.values import NAME, NameRule
    from vibropipe.store import atomic_file
    from vibropipe.study.schema import schema_text

    file = name.with_suffix(".yaml")
    if not NAME.fullmatch(file.stem):
        raise typer.BadParameter(
            f"must be {NameRule().allowed}, got {file.stem!r}", param_hint="NAME"
        )
    if file.exists():
        raise typer.BadParameter(f"{file}: exists already: choose another name", param_hint="NAME")
    schema = file.with_name("study.schema.json")
    if not schema.exists():
        with atomic_file(schema) as temporary:
            temporary.write_text(schema_text(), encoding="utf-8")
    with atomic_file(file) as temporary:
        template = "new_study_units.yaml" if units else "new_study.yaml"
        text = files("vibropipe.study").joinpath(template).read_text(encoding="utf-8")
        temporary.write_text(text, encoding="utf-8")
    typer.echo(
        f"{file} is written. Edit it, then:\n"
        f"  vibropipe plan {file}   lists what it computes, with estimated run time\n"
        f"  vibropipe run {file}    makes results/{file.stem}/report.pdf and all datasets"
    )
