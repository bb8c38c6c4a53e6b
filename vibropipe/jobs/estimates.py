"""Run time and disk space of a study on this machine, estimated by solving samples of its scenes.

The samples are solved in a process of their own, which is killed when the time is up, and which compiles nothing.
Estimates are stored by fingerprint beside the compiled kernels. The job that later solves a scene records its estimate
beside the time that it took.
"""

from __future__ import annotations

import json
import os
import select
import signal
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NoReturn

from vibropipe.compiler.cache import cache_folder, on_compiling
from vibropipe.jobs.plan import plan_scene
from vibropipe.scenes.costs import MIN_LOAD_SECONDS, Estimate, sampling
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, atomic_file, write
from vibropipe.study import Study, fingerprint

FILE_NAME = "expected.json"
# Seconds of one core for the samples of a whole study, shared evenly by its scenes; and the least share of a scene.
BUDGET, MIN_BUDGET = 1.0, 0.05
# Seconds after which all samples end, and the share of what is left that a scene has before the next one is sampled.
DEADLINE, SHARE = 9.0, 0.6
# Least seconds of a scene, and seconds that are left for the last answer.
MIN_SLICE, ANSWER_SECONDS = 0.1, 0.5
# Most seconds of one core in which a process loads libraries and kernels: what samples take beyond is work.
MAX_LOAD_SECONDS = 2.0
# The answer for a scene whose kernels have to be compiled first.
UNCOMPILED = "uncompiled"


@dataclass(frozen=True)
class Estimates:
    """Estimates of the scenes of a study.

    Attributes
    ----------
    by_scene : dict of str to Estimate
        Estimates by scene; of a scene without samples those of its plan, or the time that its samples took.
    rough : tuple of str
        Scenes without samples: their kernels are missing, or the time was up.
    uncompiled : tuple of str
        Scenes whose kernels are missing.
    long : tuple of str
        Scenes that take at least their estimate, since their samples did.
    """

    by_scene: dict[str, Estimate]
    rough: tuple[str, ...] = ()
    uncompiled: tuple[str, ...] = ()
    long: tuple[str, ...] = ()


class _KernelIsMissing(BaseException):
    """A kernel would have to be compiled."""


class _TimeIsUp(BaseException):
    """The samples of a scene take too long."""


def estimate_study(study: Study, seconds: float = DEADLINE) -> Estimates:
    """Estimate the scenes of a study, and store what was sampled for the jobs that solve them.

    Parameters
    ----------
    study : Study
        The study.
    seconds : float
        Time for all samples.
    """
    sampled = dict(_from_child(study, seconds))
    found = {name: Estimate(**value) for name, value in sampled.items() if isinstance(value, dict)}
    save_estimates({fingerprint(study, name): value for name, value in found.items()})
    by_scene, long = {}, []
    for name, scene in study.scenes.items():
        plan, took = plan_scene(scene), sampled.get(name)
        least = took - MAX_LOAD_SECONDS if isinstance(took, float) else 0.0
        if least > plan.seconds:
            long.append(name)
        by_scene[name] = found.get(name) or Estimate(
            max(plan.seconds, least), MIN_LOAD_SECONDS, plan.bytes, plan.is_parallel, plan.method
        )
    uncompiled = tuple(name for name, value in sampled.items() if value == UNCOMPILED)
    rough = tuple(name for name in study.scenes if name not in found)
    return Estimates(by_scene, rough, uncompiled, tuple(long))


def _from_child(study: Study, seconds: float) -> Iterator[tuple[str, Any]]:
    """Yield scenes with what a child process says of them until the time is up, and kill it.

    It is the dict of an estimate, UNCOMPILED, the seconds of one core after which its samples were given up, or None
    if they cannot be solved.
    """
    end = time.monotonic() + seconds
    if not hasattr(os, "fork"):
        return
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _estimate_in_child(study, end, writer)
    os.close(writer)
    with os.fdopen(reader, "rb", buffering=0) as answers:
        text = b""
        while select.select([answers], [], [], max(0.0, end - time.monotonic()))[0]:
            more = answers.read(1 << 16)
            if not more:
                break
            *lines, text = (text + more).split(b"\n")
            for line in lines:
                name, value = json.loads(line)
                yield name, value
    with suppress(ProcessLookupError):
        os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def _estimate_in_child(study: Study, end: float, writer: int) -> NoReturn:
    """Write a line of JSON for each scene of a study, and end this process."""
    on_compiling[:] = [_refuse_to_compile]
    signal.signal(signal.SIGALRM, _give_up)
    with suppress(BaseException), sampling(_solve_to_file) as sampler:
        sampler.budget = max(MIN_BUDGET, BUDGET / len(study.scenes))
        *_, last = study.scenes.values()
        for name, scene in study.scenes.items():
            _ = kind_of(scene).solve  # imports its module
            begin = time.process_time()
            left = max(0.0, end - time.monotonic() - ANSWER_SECONDS)
            share = SHARE if scene is not last else 1.0
            signal.setitimer(signal.ITIMER_REAL, share * left + MIN_SLICE)
            value: Any
            try:
                value = asdict(kind_of(scene).estimate(scene, sampler))
            except _KernelIsMissing:
                value = UNCOMPILED
            except _TimeIsUp:
                value = time.process_time() - begin
            except Exception:  # the job that solves the scene says it
                value = None
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
            os.write(writer, json.dumps([name, value]).encode() + b"\n")
    os._exit(0)


def _refuse_to_compile(kernel: str) -> None:
    raise _KernelIsMissing(kernel)


def _give_up(*_: Any) -> None:
    raise _TimeIsUp


def _solve_to_file(scene: BaseScene, path: Path) -> None:
    write(kind_of(scene).solve(scene), path)


def save_estimates(estimates: dict[str, Estimate]) -> None:
    """Add estimates by fingerprint to those stored on this machine; do nothing if the cache cannot be written."""
    cached = {**_load_all(), **{name: asdict(value) for name, value in estimates.items()}}
    try:
        with atomic_file(cache_folder() / FILE_NAME) as temporary:
            temporary.write_text(json.dumps(cached, indent=1) + "\n", encoding="utf-8")
    except (OSError, StoreError):
        return


def load_estimate(scene_fingerprint: str) -> Estimate | None:
    """Return the estimate of a scene that is stored on this machine, None if there is none."""
    entry = _load_all().get(scene_fingerprint)
    try:
        return None if entry is None else Estimate(**entry)
    except TypeError:
        return None


def _load_all() -> dict[str, Any]:
    """Return the entries of the file by fingerprint; none if it is missing or unreadable."""
    try:
        cached = json.loads((cache_folder() / FILE_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return cached if isinstance(cached, dict) else {}
