"""The command line: one command for each step, called by the rules of the workflow and by users alike.

Exit codes: 0 done; 1 a failure of the machine (a full disk, no permission); 2 a mistake of the user; 130 Ctrl-C. Errors
of codes 1 and 2 are one message on stderr without a traceback. This module imports nothing slow, so that Ctrl-C during
the imports of a command ends with one line, too.
"""

from __future__ import annotations

import sys
import warnings

from vibropipe.jobs.processes import end_with_parent
from vibropipe.words.exit_codes import INTERRUPTED

STOPPED = "vibropipe: interrupted; completed files are kept, no partial file is left"


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; errors become messages and exit codes here only.

    arguments : default: those of the process
    """
    try:
        if arguments is None:
            end_with_parent()
        _run(arguments)
    except SystemExit as stop:
        if stop.code == INTERRUPTED:  # typer's answer to Ctrl-C
            print(STOPPED, file=sys.stderr)
        raise
    except KeyboardInterrupt:
        print(STOPPED, file=sys.stderr)
        sys.exit(INTERRUPTED)


def _run(arguments: list[str] | None) -> None:
    from vibropipe.cli.commands import app
    from vibropipe.jobs.processes import exit_code
    from vibropipe.words.status import UnsolvedWarning

    try:
        with warnings.catch_warnings():
            # Commands report a status in their own words: in tables, summaries and reports.
            warnings.simplefilter("ignore", UnsolvedWarning)
            app(args=arguments, prog_name="vibropipe")
    except Exception as error:
        code = exit_code(error)
        if code is None:
            raise
        print(f"vibropipe: {error}", file=sys.stderr)
        sys.exit(code)
