"""Where the system offers no fcntl, no resource and no fork, motions come out the same, if later."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import printed

import vibropipe

# Taken away from every interpreter that finds this as its sitecustomize, those started by another one too.
BARE = """
import os, signal, sys

for name in ("fcntl", "grp", "pwd", "resource", "termios"):
    sys.modules[name] = None
for name in ("fork", "forkpty", "getpgid", "getsid", "killpg", "posix_fallocate", "register_at_fork", "setsid"):
    if hasattr(os, name):
        delattr(os, name)
"""
FACE = """
import sys
import numpy as np
import vibropipe as vp

exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
found = {
    "motion": vp.simulate(exciter, tau_end=20.0),
    "orbit": vp.steady_state(exciter),
    "rows": vp.sweep(exciter, over={"nu": np.linspace(0.8, 1.2, 5)}),
}
np.savez(sys.argv[1], **{f"{one}.{name}": ds[name] for one, ds in found.items() for name in ds.variables})
"""


@pytest.fixture
def bare(tmp_path) -> dict[str, str]:
    """Environment of an interpreter on such a system."""
    (tmp_path / "sitecustomize.py").write_text(BARE, encoding="utf-8")
    return {"PYTHONPATH": str(tmp_path)}


@pytest.fixture
def known(tmp_path) -> Path:
    """What the face answers here; its kernels are compiled from then on."""
    printed(FACE, tmp_path / "here.npz")
    return tmp_path / "here.npz"


def check_same(one: Path, other: Path) -> None:
    with np.load(one) as first, np.load(other) as second:
        assert set(first) == set(second)
        for name in first:
            np.testing.assert_array_equal(first[name], second[name], err_msg=name)


@pytest.mark.slow
def test_every_module_can_be_imported(bare):
    root = Path(vibropipe.__file__).parents[1]
    names = (path.relative_to(root).with_suffix("") for path in (root / "vibropipe").rglob("*.py"))
    modules = {".".join(name.parts).removesuffix(".__init__") for name in names}
    modules = {name for name in modules if not name.endswith("__main__")}
    code = "import importlib, os, sys\nassert not hasattr(os, 'fork')\n"
    printed(code + f"for name in {sorted(modules)!r}: importlib.import_module(name)", **bare)


def test_compiled_kernels_give_the_same_numbers(bare, known, tmp_path):
    printed(FACE, tmp_path / "bare.npz", **bare)
    check_same(known, tmp_path / "bare.npz")


@pytest.mark.slow
def test_kernels_compiled_there_give_the_same_numbers(bare, known, tmp_path):
    printed(FACE, tmp_path / "bare.npz", VIBROPIPE_CACHE_DIR=str(tmp_path / "cache"), **bare)
    check_same(known, tmp_path / "bare.npz")
