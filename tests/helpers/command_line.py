"""The command line of the program, called in this process or in one of its own."""

import os
import subprocess
from pathlib import Path

import pytest
from sharded_study import PROGRAM

from vibropipe import cli


def run(*arguments: object) -> int:
    """Run a command and return its exit code."""
    with pytest.raises(SystemExit) as stopped:
        cli.main([str(argument) for argument in arguments])
    return int(stopped.value.code or 0)


def called(folder: Path, *arguments: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Call the program of this repository in a folder and check its exit code."""
    done = subprocess.run(
        [*PROGRAM, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done
