"""Part of the report on sweeps: rows by regime, and largest impact velocities."""

from __future__ import annotations

from figures.sample_datasets import sweep

from vibropipe.figures.text import format_number
from vibropipe.scenes.sweep.report import sections


def test_regimes_of_sweeps_are_counted():
    dataset = sweep(f=[0.1, 0.2, 0.5], all_regimes=True)
    regime = dataset["regime"].values
    (section,) = sections({"response": dataset})
    (table,) = (part.as_data() for part in section.tables)
    rows = {row[0]: row[1] for row in table["rows"]}
    assert rows["rows"] == str(regime.size)
    for code, name in ((3, "two-sided"), (4, "with rest"), (6, "unbounded"), (7, "unresolved")):
        amount = int((regime == code).sum())
        assert rows[name] == f"{amount} ({format_number(100 * amount / regime.size, 3)} %)"
    largest = format_number(float(dataset["impact_velocity_max"].sel(support=1).max()))
    text = section.items[0]["text"]
    assert f"The largest impact velocity on support 1 is {largest}, at" in text
