"""Scenes that sweep starts: shards, SI, verification and pictures, also of Lyapunov exponents."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import vibropipe as vp
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.cut import join, recompute, store
from vibropipe.scenes.sweep.maps import draw_quantity_maps
from vibropipe.store import load
from vibropipe.study import study_of_text

PLAIN = """\
title: T
exciter: {l: 0.5, nu: 3.48, f: 0.7, h: 0.1, R1: 0.8, R2: 0.8}
scenes:
  s:
    kind: sweep
    over: {x0: {start: -0.4, stop: 0.4, points: 4}, v0: [-1, 0, 1.5]}
    outputs: [stability, impacts, lyapunov]
"""
UNITS = """\
title: T
physical: {m: 2 kg, C: 8 N/mm, H: 12 N s/m, l: 8 mm, F: 60 N, omega: 220 rad/s}
exciter: {R1: 0.8, R2: 0.8}
scenes:
  s:
    kind: sweep
    over: {x0: {start: -8 mm, stop: 8 mm, points: 4}, v0: [-1 m/s, 0 m/s, 1.5 m/s]}
    outputs: [stability, impacts, lyapunov]
"""


@pytest.mark.parametrize("text", [PLAIN, pytest.param(UNITS, marks=pytest.mark.slow)])
def test_shards_of_starts_join_to_the_whole_and_verify(tmp_path: Path, text: str) -> None:
    scene = study_of_text(text, "t").scenes["s"]
    attrs = {"fingerprint": scene.fingerprint()}
    store(scene, tmp_path / "whole.nc", attrs)
    parts = [tmp_path / f"{n}.nc" for n in (1, 2)]
    for n, part in enumerate(parts, 1):
        store(scene, part, attrs, (n, 2))
    join(scene, parts[::-1], tmp_path / "joined.nc", attrs)
    whole = load(tmp_path / "whole.nc")
    assert whole.equals(load(tmp_path / "joined.nc"))
    assert not recompute(tmp_path / "whole.nc", scene, 12, np.random.default_rng(1)).differences
    assert whole.attrs["start"] == "x0 swept, v0 swept"
    x0, v0 = ([-0.4, 0.4], [-1.0, 0.0, 1.5]) if text == PLAIN else ([-8e-3, 8e-3], [-1, 0, 1.5])
    assert [whole.x0.values[0], whole.x0.values[-1]] == x0
    assert whole.v0.values.tolist() == v0
    assert whole.v0.attrs["units"] == ("1" if text == PLAIN else "m s-1")
    assert {"x0", "v0", "lyapunov_exponent"} <= set(vp.table(whole).columns)


def test_the_zero_of_exponents_is_marked_and_in_view() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.05, R1=0.8, R2=0.8)
    sweep = vp.sweep(exciter, {"nu": np.linspace(1, 1.3, 31)}, outputs=("stability", "lyapunov"))
    figure = draw_sweep(sweep, ["lyapunov_exponent"])
    ax = figure.axes[0]
    assert any(np.array_equal(line.get_ydata(), [0.0, 0.0]) for line in ax.lines)
    low, high = ax.get_ylim()
    assert low < float(sweep.lyapunov_exponent.min()) < 0 < float(sweep.lyapunov_exponent.max())
    assert float(sweep.lyapunov_exponent.max()) < high
    plt.close(figure)


def test_a_map_over_starts_names_them() -> None:
    over = {"x0": np.linspace(-0.4, 0.4, 5), "v0": np.linspace(-2, 2, 4)}
    rows = vp.sweep(
        vp.Exciter(l=0.5, f=0.7, h=0.1, nu=0.5, R1=0.7, R2=0.7), over, outputs=("lyapunov",)
    )
    figure = draw_quantity_maps(rows, ["lyapunov_exponent"])
    labels = {ax.get_xlabel() for ax in figure.axes} | {ax.get_ylabel() for ax in figure.axes}
    assert {"displacement at the start $x(0)$", r"velocity at the start $\dot{x}(0)$"} <= labels
    plt.close(figure)
