"""Findings of backbones, and what a study asked for, in sentences with numbers from the data."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr
from figures.sample_datasets import amplitude_frequency, backbone, sweep

from vibropipe.report.data import asked_text
from vibropipe.scenes.backbone.report import findings


def test_findings_of_a_backbone_over_the_period():
    (finding,) = findings({"law": backbone()})
    text = finding.texts[0]
    # (1 - d) + (1 + d) cos(period / 2) is positive up to period = 2 arccos(-(1 - d) / (1 + d))
    ends = [2 * np.arccos(-(1 - d) / (1 + d)) for d in (0.1, 0.2, 0.3)]
    assert text.startswith("Free motions strike both supports at τ̄ = 1 … ")
    found = re.findall(r"… ([\d.]+) \(δ/l = ([\d.]+)\)", text.replace("\u2060", ""))
    assert [offset for _, offset in found] == ["0", "0.1", "0.2", "0.3"]
    for end, (last, _) in zip(ends, found[1:], strict=True):
        assert end - 0.03 < float(last) <= end + 1e-3


def test_findings_of_a_backbone_over_amplitude():
    (finding,) = findings({"free": amplitude_frequency(0.01)})
    assert finding.scene == "free"
    text = finding.texts[0]
    assert text.startswith(
        "With increasing amplitude the eigenfrequency is 1 up to amplitude 0.49 (no impact), from "
    )
    assert text.endswith("up to amplitude 1 (two-sided).")


def test_scenes_of_a_kind_and_grid_are_counted_together():
    line = sweep(11).assign_attrs(follow="nu up")
    both = xr.concat([line, line], xr.DataArray(["up", "down"], dims="direction", name="direction"))
    both = both.assign_attrs(follow="nu both")
    kinds = {"a": "sweep", "b": "sweep", "c": "sweep", "law": "backbone"}
    datasets = {"a": line, "b": line.assign_attrs(follow="nu down"), "c": both, "law": backbone()}
    text = asked_text(kinds, datasets)
    assert (
        "2 sweep scenes over ν = 0.3 … 3 (11 values), followed along ν upwards and ν downwards; "
        in text
    )
    assert (
        "one sweep scene over ν = 0.3 … 3 (11 values), followed along ν upwards and downwards; "
        in text
    )
    assert text.endswith("(200 values).")
