"""A sweep in three shards for the tests that disturb it, and functions that run and watch programs."""

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


def read_until(text: str, process: subprocess.Popen) -> str:
    """Return the output of a process up to the line that contains a text; all of it if no line does."""
    lines = []
    for line in process.stdout:
        lines.append(line)
        if text in line:
            break
    return "".join(lines)


def parts_of(job: str) -> list[str]:
    """Return what a job makes, each scene and figure with its verb."""
    if ", shard " in job:
        return [job]
    return [
        f"{verb} {name}" if verb in ("solving", "drawing") else half
        for half in job.split(" and ")
        for verb, _, names in [half.partition(" ")]
        for name in names.split(", ")
    ]
