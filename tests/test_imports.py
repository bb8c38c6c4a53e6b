"""What an import costs: next to nothing, and never a compilation."""

from __future__ import annotations

import os
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest
from command_line import printed

import vibropipe

# Seconds that may be spent beyond the lightest thing that is needed.
MAX_SECONDS = 0.3
TRIES = 5


def seconds_of(code: str) -> float:
    """Least of several times that a python of its own works; waiting for a core is not counted."""
    taken = []
    for _ in range(TRIES):
        before = os.times()
        subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
        after = os.times()
        worked = (after.children_user, after.children_system)
        taken.append(sum(worked) - before.children_user - before.children_system)
    return min(taken)


def test_importing_loads_nothing_else():
    """Beyond what Python itself brings."""
    code = f"import sys; sys.path = {sys.path!r}; import vibropipe; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], check=True, capture_output=True, text=True
    )
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert loaded - sys.stdlib_module_names == {"__main__", "vibropipe"}


@pytest.mark.benchmark
def test_importing_costs_next_to_nothing():
    assert seconds_of("import vibropipe") - seconds_of("pass") < MAX_SECONDS


@pytest.mark.benchmark
def test_help_costs_little_more_than_its_library():
    asked = "from vibropipe.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    assert seconds_of(asked) - seconds_of("import typer") < MAX_SECONDS


def test_imports_never_go_round():
    """Between no two modules of the package, imports inside functions included."""
    graph = grimp.build_graph("vibropipe", exclude_type_checking_imports=True, cache_dir=None)
    imported = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    assert "vibropipe.solve.accuracy.request" in imported["vibropipe.solve.motion.simulate"]
    TopologicalSorter(imported).prepare()


def test_no_import_compiles(tmp_path):
    """Every module: no kernel has a signature afterwards, and the cache holds no kernel."""
    root = Path(vibropipe.__file__).parent
    parts = [path.relative_to(root.parent).with_suffix("").parts for path in root.rglob("*.py")]
    names = sorted({".".join(p[:-1] if p[-1] == "__init__" else p) for p in parts})
    code = f"""
import importlib, sys
from numba.core.dispatcher import Dispatcher
for name in {[name for name in names if not name.endswith("__main__")]!r}:
    importlib.import_module(name)
kernels = [value for module in list(sys.modules.values())
           if getattr(module, "__name__", "").startswith("vibropipe")
           for value in vars(module).values() if isinstance(value, Dispatcher)]
assert len(kernels) > 50
assert not [kernel for kernel in kernels if kernel.signatures]
"""
    printed(code, VIBROPIPE_CACHE_DIR=str(tmp_path))
    assert not [path for path in tmp_path.rglob("*") if path.suffix in (".nbi", ".nbc")]
