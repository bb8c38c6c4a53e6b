"""Places of bifurcations as targets and bounds of designs, and their scatter: against marches and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.designs import DesignResult

STRUCK = vp.Exciter(l=0.5, nu=1.2, f=0.3, h=0.05, delta=0.02, R1=0.7, R2=0.75)
STILL = vp.Exciter(l=0.5, nu=3.0, f=0.4, h=0.2, delta=0.05)
SOFT = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, k1=60.0, h1=1.0, R2=0.75)
PHYSICAL = {"m": "2 kg", "C": "8 N/mm", "H": "40 N s/m", "l": "8 mm", "omega": "10 Hz"}


def jump(exciter: vp.Exciter, low: float, high: float) -> float:
    """Return where the two-sided motion ceases as nu is raised, by marches alone: each from where the last settled."""
    orbit = vp.steady_state(exciter, harmonics=1)
    step = 0.02
    nu = exciter.nu
    while step > 2e-6:
        start = float(orbit.displacement_strobe), float(orbit.velocity_strobe)
        after = vp.steady_state(replace(exciter, nu=nu + step), *start, harmonics=1)
        if (after.impacts_per_orbit == 1.0).all() and int(after.period_multiple) == 1:
            nu, orbit = nu + step, after
        else:
            step /= 2.0
    assert low < nu < high
    return nu


def test_a_design_has_its_jump_where_it_is_wanted_by_marches():
    designs = vp.design(STRUCK, {"f": (0.25, 0.4)}, {"fold_nu_up": 2.6}, samples=16, designs=1)
    best = designs.isel(design=0)
    assert int(best.design_result) == DesignResult.MET
    assert float(best.fold_nu_up) == pytest.approx(2.6, rel=1e-9)
    assert float(best.fold_nu_up_target) == 2.6
    at = jump(replace(STRUCK, f=float(best.f)), 2.0, 3.0)
    assert abs(at - 2.6) < 1e-4


@pytest.mark.slow
def test_a_bound_keeps_the_jump_within_a_range():
    designs = vp.design(
        replace(STRUCK, delta=0.05),
        {"f": (0.2, 0.5), "R1": (0.5, 0.8)},
        subject_to={"fold_nu_up": "> 2.3, < 2.7"},
        minimise="impact_velocity_max_1",
        samples=32,
    )
    for number in range(designs.sizes["design"]):
        row = designs.isel(design=number)
        made = replace(STRUCK, delta=0.05, f=float(row.f), R1=float(row.R1))
        found = vp.branch(made, "nu", 4.0, harmonics=1)
        folds = found.bifurcation_nu.values[found.bifurcation_kind.values == Bifurcation.FOLD]
        assert float(row.fold_nu_up) == pytest.approx(folds[0], rel=1e-9)
        assert 2.3 <= folds[0] <= 2.7
    assert int(designs.design_result[0]) == DesignResult.MET


def test_the_first_touch_is_that_of_its_closed_form():
    """|f| / sqrt((1 - nu^2)^2 + h^2 nu^2) = l - |delta| at the wanted place."""
    wanted = 1.5
    designs = vp.design(STILL, {"f": (0.2, 0.9)}, {"grazing_nu_down": wanted}, samples=16)
    assert float(designs.f[0]) == pytest.approx(
        0.45 * math.hypot(1 - wanted**2, 0.2 * wanted), rel=1e-9
    )


def test_the_scatter_of_a_place_is_that_of_its_closed_form():
    sigma = {"f": 0.004, "l": 0.002}
    spread = vp.tolerance(STILL, sigma, samples=256, subject_to={"grazing_nu_down": "< 1.29"})

    def place(f: float, l: float) -> float:  # noqa: E741
        # (1 - n)^2 + h^2 n = (f / gap)^2 of n = nu^2, the larger root
        half = 1.0 - 0.2**2 / 2.0
        return math.sqrt(half + math.sqrt(half**2 - 1.0 + (f / (l - 0.05)) ** 2))

    assert float(spread.grazing_nu_down) == pytest.approx(place(0.4, 0.5), rel=1e-12)
    step = 1e-5
    slopes = [
        (place(0.4 + step, 0.5) - place(0.4 - step, 0.5)) / (2 * step),
        (place(0.4, 0.5 + step) - place(0.4, 0.5 - step)) / (2 * step),
    ]
    np.testing.assert_allclose(spread.grazing_nu_down_sensitivity, slopes, rtol=1e-6)
    first = math.hypot(slopes[0] * 0.004, slopes[1] * 0.002)
    assert float(spread.grazing_nu_down_std[0]) == pytest.approx(first, rel=1e-6)
    rng = np.random.default_rng(1)
    parts = [place(0.4 + 0.004 * a, 0.5 + 0.002 * b) for a, b in rng.standard_normal((20_000, 2))]
    assert float(spread.grazing_nu_down_std[1]) == pytest.approx(np.std(parts), rel=0.03)
    assert float(spread["yield"]) == pytest.approx(np.mean(np.array(parts) < 1.29), abs=0.03)
    off = [place(0.4, 0.5 + each * 0.006) - place(0.4, 0.5) for each in (-1, 1)]
    np.testing.assert_allclose(spread.grazing_nu_down_deviation.sel(parameter="l"), off, rtol=1e-9)


@pytest.mark.slow
def test_tolerances_of_a_design_keep_its_jump_at_their_ends():
    allowed = 0.02
    designs = vp.design(
        STRUCK, {"f": (0.25, 0.4)}, {"fold_nu_up": 2.6}, allow={"fold_nu_up": allowed},
        tolerance={"f": 0.001, "R1": 0.002}, samples=16, designs=1,
    )  # fmt: skip
    best = designs.isel(design=0)
    off = {name: float(best[f"{name}_tolerance"]) for name in ("f", "R1")}
    base = replace(STRUCK, f=float(best.f))
    for one in (-1, 1):
        for two in (-1, 1):
            moved = replace(base, f=base.f + one * off["f"], R1=base.R1 + two * off["R1"])
            found = vp.branch(moved, "nu", 4.0, harmonics=1)
            folds = found.bifurcation_nu.values[found.bifurcation_kind.values == Bifurcation.FOLD]
            assert abs(folds[0] - 2.6) <= allowed
    # Parts count by the derivatives of the place: against the normal law of its standard deviation.
    std = float(best.fold_nu_up_std.sel(estimate="first_order"))
    share = math.erf(allowed / std / math.sqrt(2.0))
    assert float(best.fold_nu_up_yield) == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(
    ("exciter", "name", "parameter", "step"),
    [
        (STRUCK, "fold_nu_up", "R2", 1e-4),
        (replace(STILL, nu=1.5), "grazing_f_up", "delta", 1e-4),
        (SOFT, "fold_nu_up", "k1", 1e-2),
        (replace(STILL, f=0.3, shaker=0.02), "grazing_nu_down", "shaker", 1e-5),
        (vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7), "pitchfork_nu_up", "h", 1e-4),
    ],
)
def test_derivatives_are_differences_of_branches(exciter, name, parameter, step):
    kind, along, way = name.split("_")
    own = exciter.numbers()._asdict()
    to = own[along] * (4.0 if way == "up" else 0.25)

    def place(value: float) -> float:
        found = vp.branch(vp.Exciter(**{**own, parameter: value}), along, to, harmonics=1)
        of_kind = found.bifurcation_kind.values == Bifurcation[kind.upper()]
        return float(found[f"bifurcation_{along}"].values[of_kind][0])

    spread = vp.tolerance(exciter, {parameter: step}, samples=16, subject_to={name: "> -9"})
    assert float(spread[name]) == pytest.approx(place(own[parameter]), rel=1e-9)
    slope = (place(own[parameter] + step) - place(own[parameter] - step)) / (2 * step)
    assert float(spread[f"{name}_sensitivity"][0]) == pytest.approx(slope, rel=1e-5)


@pytest.mark.slow
def test_units_of_a_place_are_those_of_its_parameter():
    exciter = vp.Exciter.from_physical(**PHYSICAL, F="90 N", delta="1 mm", R1=0.7, R2=0.75)
    designs = vp.design(
        exciter, {"F": ("60 N", "120 N")}, {"fold_omega_up": "25 Hz"},
        allow={"fold_omega_up": "0.2 Hz"}, samples=16, designs=1,
    )  # fmt: skip
    assert designs.fold_omega_up.attrs["units"] == "rad s-1"
    made = vp.Exciter.from_physical(
        **PHYSICAL, F=float(designs.F[0]), delta="1 mm", R1=0.7, R2=0.75
    )
    found = vp.branch(made, "omega", "40 Hz", harmonics=1)
    folds = found.bifurcation_omega.values[found.bifurcation_kind.values == Bifurcation.FOLD]
    assert folds[0] / (2 * np.pi) == pytest.approx(25.0, rel=1e-8)
    assert designs.attrs["target"].startswith("fold_omega_up = 157.07963")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": {"fold_nu_upwards": 1.9}}, "did you mean 'fold_nu_up'"),
        ({"target": {"fold_phi2_up": 1.9}}, "must be a quantity of a steady state"),
        ({"target": {"fold_nu_up_1": 1.9}}, "must have no number after fold_nu_up"),
        ({"target": {"fold_nu_up": "soon"}}, "target.fold_nu_up: must be a finite number"),
        ({"subject_to": {"fold_nu_up": "1.9"}}, "must be a bound such as"),
        (
            {"target": {"fold_nu_up": 1.9}, "ties": {"R1": "0.5 * nu"}},
            "ties: must leave out nu, since fold_nu_up is wanted, along nu alone",
        ),
        ({"target": {"flip_h_up": 1.9}}, "none of 24 samples has"),
    ],
)
def test_wrong_places_are_refused(arguments, message):
    exciter = replace(STRUCK, R1=1.0) if "ties" in arguments else STRUCK
    with pytest.raises(vp.ParameterError, match=message):
        vp.design(exciter, {"f": (0.25, 0.4)}, samples=8, **arguments)


def test_places_are_no_levels_and_no_measurements():
    with pytest.raises(vp.ParameterError, match="must be a quantity of the motion, such as"):
        vp.boundary(STRUCK, {"fold_nu_up": 1.9})
    measured = {"f": [0.3, 0.31, 0.32], "fold_nu_up": [1.9, 1.95, 2.0]}
    with pytest.raises(vp.ParameterError, match="is found along its branch"):
        vp.identify(STRUCK, measured, {"h": (0.01, 0.1)})
