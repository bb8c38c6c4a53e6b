"""The commands. Each imports what it needs when it is called, so that `--help` is fast."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vibropipe.cli.options import (
    OutputFile,
    ResultsFolder,
    SceneName,
    StudyFile,
    parameter_option,
    parse_shard,
    use_threads,
)
from vibropipe.cli.run import new, run
from vibropipe.words.methods import METHODS
from vibropipe.words.parameters import DEFAULTS

PLOT_SUFFIXES = (".svg", ".pdf", ".png")

app = typer.Typer(
    help="Simulate vibro-impact exciters and map their steady states over parameter ranges.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.command()(new)
app.command()(run)


def _print_version(is_requested: bool) -> None:
    if is_requested:
        from vibropipe import __version__

        typer.echo(f"vibropipe {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    from vibropipe.compiler.client import on_compiling

    # a worker comes here with each command
    on_compiling[:] = [
        lambda kernel: typer.echo(f"compiling {kernel}, once for this version", err=True)
    ]


@app.command()
def plan(
    file: StudyFile,
    rough: Annotated[
        bool, typer.Option("--rough", help="Use machine-independent estimates; solve no samples.")
    ] = False,
) -> None:
    """Validate a study and list what each scene computes, with estimated run time and disk space."""
    from vibropipe.jobs.terminal_tables import plan_text
    from vibropipe.study import load_study

    study, estimates = load_study(file), None
    if not rough:
        from vibropipe.jobs.estimates import estimate_study
        from vibropipe.scenes.costs import compiled_kernels

        if compiled_kernels() == 0:
            typer.echo("compiling the kernels, once, to measure run times", err=True)
        estimates = estimate_study(study)
    typer.echo(plan_text(study, estimates))


@app.command()
def simulate(
    l: Annotated[float, parameter_option("l")],  # noqa: E741
    nu: Annotated[float, parameter_option("nu")] = DEFAULTS["nu"],
    f: Annotated[float, parameter_option("f")] = DEFAULTS["f"],
    h: Annotated[float, parameter_option("h")] = DEFAULTS["h"],
    delta: Annotated[float, parameter_option("delta")] = DEFAULTS["delta"],
    R1: Annotated[float, parameter_option("R1")] = DEFAULTS["R1"],
    R2: Annotated[float, parameter_option("R2")] = DEFAULTS["R2"],
    k1: Annotated[float, parameter_option("k1")] = DEFAULTS["k1"],
    k2: Annotated[float, parameter_option("k2")] = DEFAULTS["k2"],
    h1: Annotated[float, parameter_option("h1")] = DEFAULTS["h1"],
    h2: Annotated[float, parameter_option("h2")] = DEFAULTS["h2"],
    load: Annotated[float, parameter_option("load")] = DEFAULTS["load"],
    friction: Annotated[float, parameter_option("friction")] = DEFAULTS["friction"],
    f2: Annotated[float, parameter_option("f2")] = DEFAULTS["f2"],
    phi2: Annotated[float, parameter_option("phi2")] = DEFAULTS["phi2"],
    x0: Annotated[float, typer.Option("--x0", help="Displacement at tau = 0.")] = 0.0,
    v0: Annotated[float, typer.Option("--v0", help="Velocity at tau = 0.")] = 0.0,
    tau_end: Annotated[float, typer.Option("--tau-end", help="End of the motion.")] = 60.0,
    method: Annotated[str, typer.Option("--method", help=f"{' or '.join(METHODS)}.")] = METHODS[0],
    steps_per_period: Annotated[
        int | None,
        typer.Option("--steps-per-period", help="Steps per forcing period; newmark only."),
    ] = None,
    accuracy: Annotated[
        float | None,
        typer.Option("--accuracy", help="Maximum error; selects method and step."),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="F", help="Write a figure: .svg, .pdf or .png.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="F", help="Write the dataset: .nc.")
    ] = None,
) -> None:
    """Simulate one motion and print its impacts, rests and end state as a table."""
    from vibropipe.jobs.terminal_tables import motion_text
    from vibropipe.physics.exciter import Exciter
    from vibropipe.solve.motion import simulate as solve_motion

    if plot is not None and plot.suffix not in PLOT_SUFFIXES:
        allowed = ", ".join(PLOT_SUFFIXES)
        raise typer.BadParameter(f"must end in {allowed}, got {plot.name}", param_hint="--plot")
    exciter = Exciter(
        l=l, nu=nu, f=f, h=h, delta=delta, R1=R1, R2=R2, k1=k1, k2=k2, h1=h1, h2=h2, load=load,
        friction=friction, f2=f2, phi2=phi2,
    )  # fmt: skip
    motion = solve_motion(
        exciter,
        tau_end=tau_end,
        x0=x0,
        v0=v0,
        method=method,
        steps_per_period=steps_per_period,
        accuracy=accuracy,
        samples_per_period=0 if plot is None and output is None else 256,
    )
    typer.echo(motion_text(motion))
    if plot is not None:
        from vibropipe.figures.style import house_style, save_as
        from vibropipe.scenes.motion.panels import draw_motion

        with house_style():
            save_as(draw_motion(motion), plot)
    if output is not None:
        from vibropipe.store import write

        write(motion, output)


@app.command()
def solve(
    file: StudyFile,
    scene: SceneName,
    output: OutputFile,
    shard: Annotated[
        str | None,
        typer.Option(metavar="I/N", help="Solve the I-th of N shards of a sweep, from 1 to N."),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, metavar="T", help="Number of threads (default: all available)."),
    ] = None,
) -> None:
    """Solve one scene of a study, or one shard of it, into a dataset."""
    from vibropipe.jobs.sharding import check_cut
    from vibropipe.study import load_study

    study = load_study(file)
    part = None if shard is None else parse_shard(shard)
    check_cut(study.scene(scene), part)

    # slow imports come after the checks, so that a mistake is reported at once
    from vibropipe.jobs.progress import show_progress
    from vibropipe.jobs.solving import solve_to_file
    from vibropipe.scenes.registry import kind_of

    title = scene if shard is None else f"{scene}, shard {shard}"
    with show_progress(title, kind_of(study.scene(scene)).unit) as progress:
        solve_to_file(study, scene, output, part, use_threads(threads), progress)


@app.command()
def join(
    file: StudyFile,
    shards: Annotated[list[Path], typer.Argument(metavar="SHARDS...", help="All shards.")],
    scene: SceneName,
    output: OutputFile,
) -> None:
    """Join all shards of a sweep, in any order, into its dataset."""
    from vibropipe.jobs.sharding import as_cut
    from vibropipe.study import load_study

    study = load_study(file)
    as_cut(study.scene(scene))

    from vibropipe.jobs.progress import show_progress
    from vibropipe.jobs.solving import join_to_file

    with show_progress(f"{scene}, joined", "rows") as progress:
        join_to_file(study, scene, shards, output, progress)


@app.command()
def figure(
    file: StudyFile,
    results: ResultsFolder = Path("results"),
    only: Annotated[
        str | None, typer.Option(metavar="NAME", help="Draw only the figure of this name.")
    ] = None,
) -> None:
    """Draw the figures of a study from its datasets."""
    from vibropipe.jobs.drawing import draw_study, figure_names
    from vibropipe.study import load_study

    study = load_study(file)
    names = [name for scene in study.scenes.values() for name in figure_names(scene)]
    if only is not None and only not in names:
        allowed = f"must be a figure of the study ({', '.join(names)})"
        raise typer.BadParameter(f"{allowed}, got {only!r}", param_hint="--only")
    for path in draw_study(study, results, () if only is None else (only,)):
        typer.echo(path)


@app.command()
def report(file: StudyFile, output: OutputFile, results: ResultsFolder = Path("results")) -> None:
    """Typeset the report of a study from its datasets and figures."""
    from vibropipe.jobs.reporting import build_report
    from vibropipe.study import load_study

    typer.echo(build_report(load_study(file), results, output))


@app.command()
def show(
    dataset: Annotated[
        Path, typer.Argument(metavar="DATASET", help="A .nc file, or a study's folder.")
    ],
) -> None:
    """Summarise a dataset: parameters, dimensions, quantities and provenance."""
    from vibropipe.store import load, open_study, summary

    if dataset.is_dir():
        tree = open_study(dataset)
        texts = [f"{name}\n{summary(node.to_dataset())}" for name, node in tree.children.items()]
    else:
        texts = [summary(load(dataset))]
    typer.echo("\n".join(texts))


@app.command()
def table(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="A .nc file.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="F", help="Write to this file.")
    ] = None,
    impacts: Annotated[
        bool, typer.Option("--impacts", help="A row for each impact, not for each point.")
    ] = False,
) -> None:
    """Print a dataset as CSV that spreadsheets open: a row for each point, names for codes, units in the head."""
    from vibropipe.store import atomic_file, table
    from vibropipe.store.table import with_units

    text = with_units(table(dataset, impacts)).to_csv(index=False)
    if output is None:
        typer.echo(text, nl=False)
        return
    with atomic_file(output) as temporary:
        temporary.write_text(text, encoding="utf-8")


@app.command()
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
    """Recompute a random sample of each dataset and compare it bit for bit."""
    from vibropipe.jobs.verify import new_seed, verify

    sample_seed = new_seed() if seed is None else seed
    verdicts = []
    for verdict in verify(results, rows, sample_seed):
        typer.echo(verdict)
        verdicts.append(verdict)
    typer.echo(f"sample: --rows {rows} --seed {sample_seed}")
    if not all(verdict.good for verdict in verdicts):
        raise typer.Exit(1)


@app.command()
def view(
    results: Annotated[
        Path,
        typer.Argument(metavar="RESULTS", help="A study's folder, a .nc file of it, or a study."),
    ],
    folder: ResultsFolder = Path("results"),
    scene: Annotated[
        str | None, typer.Option("--scene", metavar="S", help="Scene to begin with.")
    ] = None,
    save: Annotated[
        Path | None,
        typer.Option("--save", metavar="F", help="Write a sweep as one page, F.html, and end."),
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="Port; 0 is a free one.")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Explore a study on a page: point at its maps and see the motion there. Ends with Ctrl-C."""
    from vibropipe.view.missing import check_installed

    check_installed()
    from vibropipe.view.results import open_results

    opened = open_results(results, folder, scene)
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


@app.command()
def bench(
    whole: Annotated[
        bool, typer.Option("--whole", help="Solve all 160,000 points of the sweep.")
    ] = False,
    rounds: Annotated[int, typer.Option(min=1, metavar="N", help="Number of timing rounds.")] = 7,
    json: Annotated[bool, typer.Option("--json", help="Print all measured times as JSON.")] = False,
) -> None:
    """Benchmark against the installed reference packages."""
    from vibropipe.bench.cases import items
    from vibropipe.bench.formatting import as_json, as_text
    from vibropipe.bench.measurement import measure

    measured = items(whole=whole)
    measure(measured, rounds)
    typer.echo(as_json(measured) if json else as_text(measured))
