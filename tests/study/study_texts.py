"""A valid study to change, and the messages of an invalid one."""

import re

import pytest

from vibropipe.study import StudyError, load_study

BASE = """\
title: A study
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  forced:
    kind: motion
    tau_end: 20
  response:
    kind: sweep
    over:
      nu: {start: 0.5, stop: 1.5, points: 11}
      delta: [0, 0.01]
  free:
    kind: backbone
    amplitude: [0.1, 0.4, 0.6]
"""


# What must hold and the value found; or a key that is missing, unknown or out of place, which has no value to show.
A_FAULT = re.compile(
    r": (must .*, got \S|must (be left out|not be combined|lie between)|file name must .*, got \S"
    r"|is required \(\S|is an unknown key; must \S|cannot be read \()",
    re.DOTALL,
)


def study_of(text, folder, name="mine"):
    file = folder / f"{name}.yaml"
    file.write_text(text, encoding="utf-8")
    return load_study(file)


def faults(text, folder, name="mine"):
    """Return the messages of an invalid study without the file that they start with."""
    with pytest.raises(StudyError) as caught:
        study_of(text, folder, name)
    lines = str(caught.value).splitlines()
    start = str(folder / f"{name}.yaml") + ": "
    assert len(lines) == len(caught.value.problems)
    assert all(line.startswith(start) for line in lines)
    return [line.removeprefix(start) for line in lines]


def scene_faults(scene, folder, exciter="{l: 0.5, nu: 1}"):
    return faults(f"title: T\nexciter: {exciter}\nscenes:\n  s: {scene}\n", folder)
