"""Texts of motions without an orbit, and of chatter: no multipliers, no stability, no number of impacts."""

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.figures.motion_words import (
    aperiodic_text,
    has_orbit,
    is_unstable,
    orbit_texts,
    stability_text,
    window_text,
)
from vibropipe.figures.text import format_number
from vibropipe.report.parts import DASH
from vibropipe.scenes.motion.report import steady_columns
from vibropipe.scenes.motion.steady_text import multiplier_text, orbit_text, struck_text
from vibropipe.scenes.sweep.sweep_rows import with_impacts_per_period
from vibropipe.view.row_numbers import law_text, lines_of
from vibropipe.words.regimes import Chaos, Regime


def row_of(regime: Regime, m: int) -> xr.Dataset:
    """A row as `steady_state` stores it."""
    multipliers = np.full(2, 0.5 + 0j if m else np.nan)
    per_orbit = [19.0, 1.0]
    return xr.Dataset(
        {
            "regime": int(regime),
            "status": 0 if m else 2,
            "period_multiple": m,
            "window_periods": 0 if m else 128,
            "chaos": int(Chaos.NONE if m else Chaos.IN_WINDOW),
            "stable": int(m > 0),
            "floquet_multiplier": ("multiplier", multipliers),
            "impacts_per_orbit": ("support", per_orbit),
            "impacts_per_period": ("support", per_orbit),
            "rests_per_orbit": ("support", [float(regime == Regime.WITH_REST), 0.0]),
            "displacement_mean": 0.0,
            "displacement_amplitude": ("harmonic", np.ones(3)),
            "orbit_impact_velocity": ("impact", np.r_[np.full(19, 0.1), -0.3]),
            "orbit_impact_support": ("impact", np.r_[np.ones(19, int), 2]),
        },
        coords={"support": [1, 2], "harmonic": [1, 2, 3], "multiplier": [1, 2]},
    )


def test_a_motion_without_an_orbit_has_no_multipliers_and_no_stability() -> None:
    row = row_of(Regime.APERIODIC, 0)
    assert multiplier_text(row) == DASH
    assert stability_text(row) == ""
    assert not has_orbit(row)
    assert not is_unstable(row)
    columns = steady_columns({"chaos": row})
    assert [columns[name] for name in ("multiple", "multiplier", "stability")] == [[DASH]] * 3


def test_a_motion_without_an_orbit_is_known_in_a_window() -> None:
    row = row_of(Regime.APERIODIC, 0)
    assert window_text(row) == "in a window of 128 forcing periods"
    assert orbit_text(row) == "The motion does not repeat in a window of 128 forcing periods"
    text = law_text(row)
    assert text.startswith("Aperiodic in a window of 128 forcing periods.")
    assert "may be a transient" in text
    rows = row.drop_vars("displacement_amplitude").expand_dims(nu=[1.0])
    assert "window of at least 128 forcing periods" in aperiodic_text(rows)
    orbits = row_of(Regime.TWO_SIDED, 1).drop_vars("displacement_amplitude").expand_dims(nu=[1.0])
    assert aperiodic_text(orbits) == ""


def test_a_chatter_has_no_number_of_impacts() -> None:
    row = row_of(Regime.WITH_REST, 1)
    assert orbit_texts(row.expand_dims(point=[0]), "point") == ["(1; rest, 1)"]
    assert struck_text(row, 1) == "0.1, rest"
    assert struck_text(row, 2) == format_number(-0.3)
    rates = with_impacts_per_period(row)["impacts_per_period"].values
    assert np.isnan(rates[0])
    assert rates[1] == 1.0
    shown = [text for _mark, name, text in lines_of(row) if name.startswith("impacts")]
    assert "rest" in shown
    assert not any(text.startswith("19") for text in shown)


@pytest.mark.parametrize("law", [Regime.TWO_SIDED, Regime.ONE_SIDED_1])
def test_other_orbits_keep_their_numbers(law: Regime) -> None:
    row = row_of(law, 1)
    assert orbit_texts(row.expand_dims(point=[0]), "point") == ["(1; 19, 1)"]
    assert stability_text(row) == "stable"
    assert with_impacts_per_period(row)["impacts_per_period"].values.tolist() == [19.0, 1.0]


def test_a_marched_chatter_is_a_rest() -> None:
    exciter = vp.Exciter(l=0.5, nu=0.5, f=0.8, h=0.15, R1=0.7, R2=0.6)
    rows = vp.sweep(exciter, over={"nu": np.linspace(0.3, 0.6, 7)})
    resting = rows.regime.values == Regime.WITH_REST
    assert resting.any()
    for text in np.array(orbit_texts(rows, "nu"))[resting]:
        assert "rest" in text
