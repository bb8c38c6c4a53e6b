"""The commands that make results, new and run, and those that read them: show, table, verify, view."""

from __future__ import annotations

import json
import os
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vibropipe.cli.options import ComparisonFile, PageFile, ResultsFolder, TableFile
from vibropipe.words.exit_codes import INTERRUPTED

if TYPE_CHECKING:
    from vibropipe.view.results import Results

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
        *(f"{key}={json.dumps(value, ensure_ascii=False)}" for key, value in settings.items()),
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


def show(
    dataset: Annotated[
        Path, typer.Argument(metavar="DATASET", help="A .nc file, or a study's folder.")
    ],
) -> None:
    """Summarise a dataset in the study's units: parameters, dimensions, quantities and provenance."""
    from vibropipe.store import load, open_study, summary
    from vibropipe.store.opening import LEFT_OUT
    from vibropipe.study import shown_now

    if dataset.is_dir():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # the last line says it
            tree = open_study(dataset)
        nodes = {name: node.to_dataset() for name, node in tree.children.items()}
        texts = [f"{name}\n{summary(data)}" for name, data in shown_now(nodes).items()]
        if left_out := tree.attrs.get(LEFT_OUT):
            texts.append(f"not in the study: {left_out}")
    else:
        texts = [summary(shown_now({"": load(dataset)})[""])]
    typer.echo("\n".join(texts))


def table(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="A .nc file.")],
    output: TableFile = None,
    impacts: Annotated[
        bool, typer.Option("--impacts", help="A row for each impact, not for each point.")
    ] = False,
    sections: Annotated[
        bool, typer.Option("--sections", help="A row for each point of a Poincaré section.")
    ] = False,
    varying: Annotated[
        bool, typer.Option("--varying", help="Leave out columns that never change.")
    ] = False,
    units: Annotated[
        str,
        typer.Option("--units", metavar="U", help="Units, 'Hz, mm', or SI (default: the study's)."),
    ] = "",
) -> None:
    """Print a dataset as CSV for spreadsheets: a row for each point, names for codes, the study's units in the head."""
    from vibropipe.solve.physical import in_units
    from vibropipe.store import atomic_file, load, table
    from vibropipe.store.table import with_units, without_constants, write_xlsx
    from vibropipe.study import shown_now

    whole = load(dataset)
    shown = in_units(whole, units) if units else shown_now({"": whole})[""]
    rows = table(shown, impacts, sections)
    rows = with_units(without_constants(rows) if varying else rows)
    if output is None:
        typer.echo(rows.to_csv(index=False), nl=False)
        return
    with atomic_file(output) as temporary:
        if output.suffix == ".xlsx":
            write_xlsx(rows, temporary)
        else:
            temporary.write_text(rows.to_csv(index=False), encoding="utf-8")


def compare(
    one: Annotated[Path, typer.Argument(metavar="A", help="A .nc file.")],
    two: Annotated[Path, typer.Argument(metavar="B", help="Another one of the same scene.")],
    output: ComparisonFile = None,
) -> None:
    """Tell what differs between two datasets: studies, rows, laws of motion, and quantities beyond their errors."""
    from vibropipe.jobs.comparison import compare_datasets
    from vibropipe.jobs.comparison_told import as_lines, as_table, draw
    from vibropipe.store import atomic_file, load
    from vibropipe.study import shown_now

    # Both in the units of the study of the first.
    first, second = shown_now({"A": load(one), "B": load(two)}).values()
    found = compare_datasets(first, second)
    typer.echo("\n".join(as_lines(found)))
    if output is None:
        return
    figure = None if output.suffix == ".csv" else draw(first, second, found)
    with atomic_file(output) as temporary:
        if figure is None:
            temporary.write_text(as_table(found).to_csv(index=False), encoding="utf-8")
        else:
            figure.savefig(temporary, format=output.suffix.removeprefix("."))


def verify(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="A study's folder, or a .nc file of it.")
    ],
    rows: Annotated[
        int, typer.Option(min=1, metavar="N", help="Rows of each sweep to recompute.")
    ] = 100,
    seed: Annotated[
        int | None, typer.Option(min=0, metavar="S", help="Seed of the sample (default: random).")
    ] = None,
) -> None:
    """Recompute each dataset, of sweeps a random sample of rows, and compare it bit for bit."""
    from vibropipe.jobs.verify import new_seed, verify

    sample_seed = new_seed() if seed is None else seed
    verdicts = []
    for verdict in verify(results, rows, sample_seed):
        typer.echo(verdict)
        verdicts.append(verdict)
    typer.echo(f"sample: --rows {rows} --seed {sample_seed}")
    if not all(verdict.good for verdict in verdicts):
        raise typer.Exit(1)


def view(
    results: Annotated[
        Path | None,
        typer.Argument(
            metavar="RESULTS",
            help="A study's folder, a .nc file of it, a study, or a YAML file of an exciter alone (default: an "
            "exciter with three motions).",
        ),
    ] = None,
    exciter: Annotated[
        str | None,
        typer.Option(
            "--exciter", metavar="TEXT", help="One exciter in place of a study: 'l=0.5 nu=2 ...'."
        ),
    ] = None,
    folder: ResultsFolder = Path("results"),
    scene: Annotated[
        str | None, typer.Option("--scene", metavar="S", help="Scene to begin with.")
    ] = None,
    save: PageFile = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="Port; 0 is a free one.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Explore a study, or one exciter, on a page: point at maps and see the motion there. Ends with Ctrl-C."""
    if results is not None and exciter is not None:
        raise typer.BadParameter("must be left out beside RESULTS", param_hint="--exciter")
    from vibropipe.view.results import check_installed

    check_installed()
    opened = _opened(results, exciter, folder, scene, save)
    if opened.note:
        typer.echo(opened.note, err=True)
    if save is not None:
        from vibropipe.view.save import save_page

        save_page(opened, save)
        typer.echo(save)
        return
    from vibropipe.view.server import serve

    serve(
        opened,
        lambda address: typer.echo(f"{opened.title}: {address}\nCtrl-C ends the page"),
        browser,
        port,
    )
    typer.echo("\nended")


def _opened(
    file: Path | None, text: str | None, folder: Path, scene: str | None, save: Path | None
) -> Results:
    """Return what `view` shows: the results of a study, or of one exciter, which are solved now."""
    from vibropipe.jobs.progress import show_progress
    from vibropipe.view import one_exciter
    from vibropipe.view.results import open_results

    if file is None:
        tree = one_exciter.tree_of_text(one_exciter.EXAMPLE if text is None else text)
    elif (found := one_exciter.tree_of_file(file)) is None:
        return open_results(file, folder, scene)
    else:
        tree = found
    for option, value in (("--scene", scene), ("--save", save)):
        if value is not None:
            raise typer.BadParameter("needs the results of a study", param_hint=option)
    with show_progress("exciter", "starts") as progress:
        return one_exciter.exciter_results(tree, str(file or one_exciter.OPTION), progress)
