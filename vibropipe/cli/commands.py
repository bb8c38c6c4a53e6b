"""The commands. Each imports what it needs when it is called, so that `--help` is fast."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer

from vibropipe.cli.options import (
    NUMBER,
    Accuracy,
    DatasetFile,
    PlotFile,
    ReportFile,
    ResultFile,
    ResultsFolder,
    SceneName,
    SceneNames,
    StartDisplacement,
    StepsPerPeriod,
    StudyFile,
    Threads,
    parse_shard,
    takes_parameters,
)
from vibropipe.cli.results import compare, new, run, show, table, verify, view
from vibropipe.words.methods import METHODS

# Seconds from which on the end of a compilation is told.
LONG_COMPILATION = 2.0

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
    from vibropipe.compiler.cache import on_compiling

    # in place of that of an earlier command of this process
    on_compiling[:] = [_tell_compiling]


def _tell_compiling(kernel: str, seconds: float | None) -> None:
    if seconds is None:
        typer.echo(f"compiling {kernel}, once for this version", err=True)
    elif seconds >= LONG_COMPILATION:
        typer.echo(f"compiled {kernel} in {seconds:.0f} s", err=True)


@app.command()
def plan(
    file: StudyFile,
    rough: Annotated[
        bool, typer.Option("--rough", help="Use machine-independent estimates.")
    ] = False,
) -> None:
    """Validate a study and list what each scene computes, with estimated run time and disk space."""
    from vibropipe.jobs.terminal_tables import plan_text
    from vibropipe.study import load_study

    study, estimates = load_study(file), None
    if not rough:
        from vibropipe.jobs.plan import estimate_study

        estimates = estimate_study(study)
    typer.echo(plan_text(study, estimates))


@app.command()
@takes_parameters
def simulate(
    x0: StartDisplacement = None,
    v0: Annotated[float, typer.Option("--v0", help="Velocity at tau = 0.", **NUMBER)] = 0.0,
    tau_end: Annotated[
        float, typer.Option("--tau-end", help="End of the motion.", **NUMBER)
    ] = 60.0,
    method: Annotated[str, typer.Option("--method", help=f"{' or '.join(METHODS)}.")] = METHODS[0],
    steps_per_period: StepsPerPeriod = None,
    accuracy: Accuracy = None,
    plot: PlotFile = None,
    output: DatasetFile = None,
    **parameters: Any,
) -> None:
    """Simulate one motion and print its impacts, rests and end state as a table."""
    from vibropipe.jobs.terminal_tables import motion_text
    from vibropipe.physics.exciter import Exciter
    from vibropipe.solve.motion.simulate import simulate as solve_motion

    given = {name: value for name, value in parameters.items() if value is not None}
    exciter = Exciter(**given)
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
        from vibropipe.store import save

        save(motion, output)


@app.command()
def solve(
    file: StudyFile,
    scene: SceneNames = None,
    output: DatasetFile = None,
    shard: Annotated[
        str | None, typer.Option(metavar="I/N", help="Solve the I-th of N shards, from 1 to N.")
    ] = None,
    results: ResultsFolder = Path("results"),
    logs: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write a log for each scene, DIR/S.log.")
    ] = None,
    threads: Threads = None,
) -> None:
    """Solve the scenes of a study whose datasets are not up to date; with --output one scene, or one shard of it."""
    from vibropipe.jobs.plan import check_cut
    from vibropipe.study import load_study

    study = load_study(file)
    scenes = scene or list(study.scenes)
    part = None if shard is None else parse_shard(shard)
    if (output is None and shard) or (output is not None and len(scenes) != 1):
        raise typer.BadParameter("needs one scene and one --output", param_hint="--scene")
    for name in scenes:
        check_cut(study.scene(name), part)

    # slow imports come after the checks, so that a mistake is reported at once
    from vibropipe.jobs.earlier import earlier_file
    from vibropipe.jobs.progress import show_progress
    from vibropipe.jobs.solving import solve_stale, solve_to_file, use_threads
    from vibropipe.scenes.registry import kind_of

    if output is None:
        folder, cores = results / study.name, threads or os.cpu_count() or 1
        if failed := solve_stale(study, scenes, folder, logs, cores):
            typer.echo(f"not solved: {', '.join(failed)}", err=True)
            raise typer.Exit(1)
        return
    title = scenes[0] if shard is None else f"{scenes[0]}, shard {shard}"
    # of a run that makes a dataset again; it replaces that of no other output
    kept = earlier_file(results / study.name / f"{scenes[0]}.nc")
    earlier = kept if part is not None and kept.is_file() else None
    with show_progress(title, kind_of(study.scene(scenes[0])).unit) as progress:
        solve_to_file(study, scenes[0], output, part, use_threads(threads), progress, earlier)


@app.command()
def join(
    file: StudyFile,
    shards: Annotated[list[Path], typer.Argument(metavar="SHARDS...", help="All shards.")],
    scene: SceneName,
    output: ResultFile,
    threads: Threads = None,
) -> None:
    """Join all shards of a scene, in any order, into its dataset."""
    from vibropipe.jobs.plan import as_cut
    from vibropipe.study import load_study

    study = load_study(file)
    as_cut(study.scene(scene))

    from vibropipe.jobs.progress import show_progress
    from vibropipe.jobs.solving import join_to_file, use_threads
    from vibropipe.scenes.registry import kind_of

    use_threads(threads)
    with show_progress(f"{scene}, joined", kind_of(study.scene(scene)).unit) as progress:
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
    from vibropipe.jobs.drawing import draw_study, figures_of
    from vibropipe.study import load_study

    study = load_study(file)
    names = [*figures_of(study)]
    if only is not None and only not in names:
        allowed = f"must be a figure of the study ({', '.join(names)})"
        raise typer.BadParameter(f"{allowed}, got {only!r}", param_hint="--only")
    for path in draw_study(study, results, () if only is None else (only,)):
        typer.echo(path)


@app.command()
def report(
    file: StudyFile,
    output: ReportFile,
    results: ResultsFolder = Path("results"),
    partial: Annotated[
        bool, typer.Option("--partial", help="Leave out scenes that failed, with a line on each.")
    ] = False,
    threads: Threads = None,
) -> None:
    """Draw the figures of a study that are not up to date, and typeset its report."""
    from vibropipe.jobs.reporting import make_report
    from vibropipe.study import load_study

    failed = make_report(load_study(file), results, output, partial, threads)
    typer.echo(f"{output}, without {', '.join(failed)}" if failed else output)


for on_results in (show, table, compare, verify, view):
    app.command()(on_results)


@app.command()
def bench(
    whole: Annotated[
        bool, typer.Option("--whole", help="Solve all 160,000 points of the sweep.")
    ] = False,
    rounds: Annotated[int, typer.Option(min=1, metavar="N", help="Number of timing rounds.")] = 7,
    json: Annotated[bool, typer.Option("--json", help="Print all measured times as JSON.")] = False,
) -> None:
    """Benchmark against the installed reference packages."""
    from vibropipe.lab.bench import as_json, as_text, measure
    from vibropipe.lab.bench_items import items

    measured = items(whole=whole)
    measure(measured, rounds)
    typer.echo(as_json(measured) if json else as_text(measured))
