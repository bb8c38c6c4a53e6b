"""Commands of the program, each an argument, in one process that knows the records of this folder."""

import shlex
import sys

from toys import effect, parameter, quantity  # noqa: F401  (before the program makes lists of records)
from vibropipe.cli import main

for command in sys.argv[1:]:
    try:
        main(shlex.split(command))
    except SystemExit as end:
        if end.code:
            raise
