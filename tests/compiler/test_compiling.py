"""Functions called from Python and from compiled code, their cache, and equal bits in every process."""

import os
import shutil
import subprocess
import sys
from typing import NamedTuple

import pytest
from numba import types
from numba.core.errors import TypingError

from vibropipe.compiler import jit
from vibropipe.compiler.sources import PACKAGE, source_hash

PRINTS_NAMES = """
import sys
from vibropipe.compiler.cache import on_compiling
on_compiling.append(lambda name, took: print("compiled" if took else "compiling", name, file=sys.stderr))
"""
FIRST_CALL = """
from vibropipe.physics.load import force_at
from vibropipe.physics.exciter import Parameters
assert force_at(Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0), 1.0, 0.25)[0] == 2.0
print(sum(force_at.stats.cache_hits.values()), sum(force_at.stats.cache_misses.values()))
"""
SIDE_BY_SIDE = """
from vibropipe.lab.timing import compile_side_by_side
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load import force_at
p = Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0)
calls = [lambda: force_at(p, 1.0, 0.25), lambda: free_flow(0.2, 1.0), lambda: 1 / 0]
compile_side_by_side([calls[:1], [calls[2], calls[1]]], 2)
calls[0](), calls[1]()
print(*(sum(each.stats.cache_hits.values()) for each in (force_at, free_flow)))
"""
# a sweep with chaotic rows, a chaotic motion, and a branch
NUMBERS = """
import hashlib
from dataclasses import replace
import numpy as np
import vibropipe as vp
from vibropipe.words.regimes import Regime
exciter = vp.Exciter(l=0.5, nu=1.0, f=0.2, h=0.2, R1=0.7, R2=0.7)
rows = vp.sweep(exciter, {"nu": np.linspace(0.4, 1.4, 100)})
is_chaotic = rows.regime == Regime.APERIODIC
chaotic = replace(exciter, nu=rows.nu[is_chaotic].values[0])
motion = vp.simulate(chaotic, 3000.0, samples_per_period=0)
branch = vp.branch(replace(exciter, f=1.0), "nu", (0.8, 1.2))
print(is_chaotic.sum().item())
for values in (rows.displacement_strobe, motion.impact_velocity, branch.displacement_strobe):
    print(hashlib.sha256(np.ascontiguousarray(values)).hexdigest())
"""


def command(script, cache, **more):
    environment = os.environ | {"VIBROPIPE_CACHE_DIR": str(cache)} | more
    return {"args": [sys.executable, "-c", script], "env": environment, "text": True}


def run(script, cache, **more):
    completed = subprocess.run(**command(script, cache, **more), capture_output=True, check=True)
    return completed.stdout.split()


@jit
def halved(x):
    return 0.5 * x


@jit
def quarter(x):
    return halved(halved(x))


@jit
def checked(x):
    if x < 0.0:
        raise ValueError("x must not be negative")
    return quarter(x)


@jit
def eighth(x):
    return checked(0.5 * x)


def test_a_function_may_be_called_from_compiled_code_first_and_from_python_later():
    assert eighth(8.0) == 1.0
    assert quarter(8.0) == 2.0
    assert halved(8.0) == 4.0
    assert eighth(8) == 1.0  # another type


def test_a_function_may_be_called_from_python_first_and_from_compiled_code_later():
    assert halved(8.0 + 0.0j) == 4.0
    assert quarter(8.0 + 0.0j) == 2.0


@jit
def moved(x, places):
    return x + places


@jit
def moved_often(x, places):
    return moved(moved(moved(x, 7), 8), places)


def test_a_function_that_is_called_with_constants_is_compiled_once_for_all_integers():
    assert moved_often(0.5, 3) == 18.5
    called = types.float64, types.literal(7)
    template, *_rest = moved.get_call_template(called, {})
    assert [each.args for each in template.cases] == [(types.float64, types.int64)]


class Effects(NamedTuple):
    friction: int | None
    housing: int | None


class Grid(NamedTuple):
    effects: Effects


@jit
def beyond_compiling(x):
    return x.no_number_has_this


@jit
def of_present(effects, grid, x):
    if effects.housing is not None:
        x = beyond_compiling(x)
    if grid.effects.housing is None and grid.effects.friction is not None:
        return halved(x)
    return beyond_compiling(x)


def test_what_belongs_to_an_absent_effect_is_not_compiled():
    effects = Effects(1, None)
    assert of_present(effects, Grid(effects), 8.0) == 4.0
    present = Effects(1, 1)
    with pytest.raises(TypingError):
        of_present(present, Grid(effects), 8.0)


def test_a_compiled_callee_raises_its_error():
    with pytest.raises(ValueError, match="x must not be negative"):
        eighth(-1.0)
    with pytest.raises(ValueError, match="x must not be negative"):
        checked(-1.0)


def test_a_process_compiles_what_it_calls_and_a_later_one_loads_it(tmp_path):
    assert run(FIRST_CALL, tmp_path) == ["0", "1"]
    files = {path.name.split("-")[0]: path for path in tmp_path.rglob("*.nbc")}
    pieces = {name for name, path in files.items() if "pieces" in path.parts}
    assert pieces == {"load._force_at", "load.force_of_angle", "turns.sincos_turns"}
    holds_code = {name for name, path in files.items() if b"\x7fELF" in path.read_bytes()}
    assert holds_code == {"load.force_at"} == set(files) - pieces
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]


def test_stored_pieces_are_linked_by_a_process_that_compiles(tmp_path):
    run(FIRST_CALL, tmp_path)
    times = {}
    for path in tmp_path.rglob("*.nb?"):
        if "pieces" in path.parts:
            times[path] = path.stat().st_mtime_ns
        else:
            path.unlink()
    assert run(FIRST_CALL, tmp_path) == ["0", "1"]
    assert {path: path.stat().st_mtime_ns for path in times} == times


def test_processes_that_need_one_function_compile_it_once(tmp_path):
    processes = [
        subprocess.Popen(
            **command(PRINTS_NAMES + FIRST_CALL, tmp_path),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for _ in range(3)
    ]
    outputs = [process.communicate() for process in processes]
    assert sorted(out.split() for out, _ in outputs) == [["0", "1"], ["1", "0"], ["1", "0"]]
    assert "".join(err for _, err in outputs) == (
        "compiling physics.load.force_at\ncompiled physics.load.force_at\n"
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs forked processes")
def test_forked_processes_leave_what_they_compile(tmp_path):
    assert run(SIDE_BY_SIDE, tmp_path) == ["1", "1"]


def test_without_a_writable_cache_kernels_are_temporary(tmp_path):
    blocked, scratch = tmp_path / "file", tmp_path / "scratch"
    blocked.touch()
    scratch.mkdir()
    assert run(FIRST_CALL, blocked, TMPDIR=str(scratch)) == ["0", "1"]
    assert not list(scratch.iterdir())


def test_without_locks_a_process_compiles_for_itself(tmp_path):
    """As on Windows."""
    (tmp_path / "sitecustomize.py").write_text("import sys\nsys.modules['fcntl'] = None\n")
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["0", "1"]
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["1", "0"]


def test_without_private_parts_of_numba_a_function_has_no_pieces(tmp_path):
    removal = "import numba.core.codegen\ndel numba.core.codegen.JITCodeLibrary\n"
    (tmp_path / "sitecustomize.py").write_text(removal)
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["0", "1"]
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["1", "0"]
    assert not list((tmp_path / "cache").rglob("pieces"))


@pytest.mark.slow
def test_the_first_process_computes_the_same_bits_as_later_ones(tmp_path):
    first, second = run(NUMBERS, tmp_path), run(NUMBERS, tmp_path)
    assert int(first[0]) >= 3
    assert first == second


def test_an_edit_after_an_import_names_no_kernels_of_before(tmp_path):
    """The folder of a module is named by the source that was imported, though its kernels are compiled later."""
    package = tmp_path / "vibropipe"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    edited = package / "physics" / "load.py"
    script = f"""
import sys
sys.path.insert(0, {str(tmp_path)!r})
import vibropipe.physics.load as load
from vibropipe.physics.exciter import Parameters
with open(load.__file__, "a") as file:
    file.write("# edited\\n")
load.force_at(Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0), 1.0, 0.25)
"""
    cache = tmp_path / "cache"
    run(script, cache)
    assert edited.read_text().endswith("# edited\n")
    (kernels,) = cache.glob("vibropipe/physics.load-*")
    assert kernels.name == f"physics.load-{source_hash(['vibropipe.physics.load'])}"
