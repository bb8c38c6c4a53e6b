"""The commands that read results: show, table, verify, view."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import typer

from vibropipe.cli.options import PageFile, ResultsFolder, TableFile


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
) -> None:
    """Print a dataset as CSV for spreadsheets: a row for each point, names for codes, the study's units in the head."""
    from vibropipe.store import atomic_file, load, table
    from vibropipe.store.table import with_units
    from vibropipe.study import shown_now

    shown = shown_now({"": load(dataset)})[""]
    text = with_units(table(shown, impacts)).to_csv(index=False)
    if output is None:
        typer.echo(text, nl=False)
        return
    with atomic_file(output) as temporary:
        temporary.write_text(text, encoding="utf-8")


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
        Path,
        typer.Argument(metavar="RESULTS", help="A study's folder, a .nc file of it, or a study."),
    ],
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
    """Explore a study on a page: point at its maps and see the motion there. Ends with Ctrl-C."""
    from vibropipe.view.results import check_installed

    check_installed()
    from vibropipe.view.results import open_results

    opened = open_results(results, folder, scene)
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
