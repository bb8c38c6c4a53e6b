"""The command line: one verb per step, the same functions a workflow rule and a person call.

Exit codes: 0 done, 1 a failure of the machine (a disk that is full or may not be written), 2 a mistake in
what was asked (each one message on stderr, no traceback), 130 Ctrl-C. Nothing is imported here that takes
time: Ctrl-C ends the imports of the verbs, too, in one line.
"""

from __future__ import annotations

import sys

INTERRUPTED = 130
STOPPED = "vibropipe: interrupted; completed files are kept, no partial file is left"
# The verbs that open a study lazily, in arrays of dask.
LAZY = ["show"]


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; the only place where an error becomes a message and an exit code."""
    if arguments is None and sys.argv[1:2] != LAZY:
        _block_dask_import()
    try:
        _run(arguments)
    except SystemExit as stop:
        if stop.code == INTERRUPTED:  # typer's answer to Ctrl-C
            print(STOPPED, file=sys.stderr)
        raise
    except KeyboardInterrupt:
        print(STOPPED, file=sys.stderr)
        sys.exit(INTERRUPTED)


def _block_dask_import() -> None:
    """Keep xarray from importing dask's arrays to ask of a value whether it is one: 0.3 s of each job."""
    sys.modules.setdefault("dask.array", None)  # type: ignore[arg-type]


def _run(arguments: list[str] | None) -> None:
    from vibropipe.cli.commands import app

    try:
        app(args=arguments, prog_name="vibropipe")
    except Exception as error:
        code = exit_code(error)
        if code is None:
            raise
        print(f"vibropipe: {error}", file=sys.stderr)
        sys.exit(code)


def exit_code(error: Exception) -> int | None:
    """2 for a mistake of the user, 1 for a failure of the machine, None for a fault of ours."""
    from vibropipe.physics.exciter import ParameterError
    from vibropipe.scenes.costs import PlanError
    from vibropipe.store import NotWrittenError, StoreError
    from vibropipe.study import StudyError

    if isinstance(error, NotWrittenError):
        return 1
    if isinstance(error, StudyError | StoreError | ParameterError | PlanError):
        return 2
    return 1 if isinstance(error, OSError) else None
