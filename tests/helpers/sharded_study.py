"""A sweep in three shards, for the tests that disturb it, and how they run and watch programs."""

import subprocess
import sys

SHARDS = 3
STUDY = """\
title: A sweep in shards
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  response:
    kind: sweep
    over: {f: {start: 0.1, stop: 3, points: 20}, nu: {start: 0.3, stop: 3, points: 30}}
"""
PROGRAM = [sys.executable, "-c", "from vibropipe.cli import main; main()"]


def said_until(words: str, process: subprocess.Popen) -> str:
    """Return what a process says, up to the line with these words; all of it if there is none."""
    said = []
    for line in process.stdout:
        said.append(line)
        if words in line:
            break
    return "".join(said)
