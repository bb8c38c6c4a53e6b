"""The command line of the program, called in this process or in one of its own, and code in one of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from sharded_study import PROGRAM

from vibropipe import cli


def run(*arguments: object) -> int:
    """Run a command and return its exit code."""
    with pytest.raises(SystemExit) as stopped:
        cli.main([str(argument) for argument in arguments])
    return int(stopped.value.code or 0)


def printed(code: str, *arguments: object, cwd: Path | None = None, **environment: str) -> str:
    """Return what code prints in a process of its own, which must succeed."""
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=cwd,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


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
