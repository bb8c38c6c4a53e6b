"""A motion with a ramp in a study: dataset, what it ends in, picture, finding, and what is refused."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from drawing import picture_of
from figures.figure_text import words

import vibropipe as vp
from vibropipe.jobs.solving import solve_to_file
from vibropipe.scenes.motion.findings import answers
from vibropipe.scenes.motion.ramp_picture import NAME_SHARE, widest
from vibropipe.scenes.registry import kinds
from vibropipe.study import Study, StudyError, study_of_text
from vibropipe.words.regimes import Regime

NUMBERS = {"l": 2.0, "h": 0.1, "f": 1.0, "R1": 0.8, "R2": 0.8}
SHORT = "ramp: {nu: {from: 0.6, to: 1.6, within: 20}}"
M, C = 1.0, 1e4
UNITS = (
    "physical: {m: 1 kg, C: 1e4 N/m, l: 2 mm, H: 10 N s/m, F: 10 N}\nexciter: {R1: 0.8, R2: 0.8}\n"
)


def text_of(keys: str, exciter: str = "", top: str = "") -> str:
    numbers = exciter or ", ".join(f"{name}: {value}" for name, value in NUMBERS.items())
    top = top or f"exciter: {{{numbers}}}\n"
    return f"title: T\n{top}scenes:\n  up: {{kind: motion, {keys}}}\n"


def study(keys: str, exciter: str = "", top: str = "") -> Study:
    return study_of_text(text_of(keys, exciter, top), "mine")


def solved(made: Study) -> xr.Dataset:
    return kinds()["motion"].solve(made.scenes["up"])


def ramp_study(to: float, start: float = 0.6, **exciter: float) -> Study:
    numbers = ", ".join(f"{name}: {value}" for name, value in {**NUMBERS, **exciter}.items())
    keys = f"ramp: {{nu: {{from: {start}, to: {to}, within: 600}}}}, samples_per_period: 16"
    return study(keys, numbers)


@pytest.fixture(scope="module")
def kept() -> xr.Dataset:
    """Return a ramp that ends in another motion than a start from rest."""
    return solved(ramp_study(1.6))


@pytest.fixture(scope="module")
def same() -> xr.Dataset:
    """Return a ramp that ends in the motion of a start from rest."""
    return solved(ramp_study(1.3))


def held(e: vp.Exciter, state: tuple[float, float], turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the supports struck in the last 12 of 400 periods from a state at a phase, and the state at the end."""
    ds = vp.simulate(e, 400 * e.period, *state, tau_start=turn * e.period, samples_per_period=0)
    late = ds.impact_tau.values > 388 * e.period
    return ds.impact_support.values[late], np.array([ds.displacement_end, ds.velocity_end])


@pytest.mark.parametrize("settle", [0, 3])
def test_a_study_has_the_motion_of_simulate(settle: int) -> None:
    ds = solved(study(f"{SHORT}, settle_periods: {settle}"))
    e = vp.Exciter(nu=0.6, **NUMBERS)
    begin, state = settle * e.period, (0.0, 0.0)
    if settle:
        before = vp.simulate(e, begin, samples_per_period=0)
        state = float(before.displacement_end), float(before.velocity_end)
    by_hand = vp.simulate(e, begin + 20.0, *state, tau_start=begin, nu_end=1.6)
    for name, values in by_hand.variables.items():
        xr.testing.assert_identical(ds[name].variable, values)


def test_a_study_with_units_has_the_same_motion_in_si() -> None:
    with_units = solved(
        study("ramp: {omega: {from: 60 rad/s, to: 160 rad/s, within: 0.2 s}}", top=UNITS)
    )
    e = vp.Exciter(nu=0.6, **{**NUMBERS, "l": 0.002, "f": 0.001})
    by_hand = vp.to_physical(vp.simulate(e, 20.0, nu_end=1.6), M, C)
    for name, values in by_hand.variables.items():
        xr.testing.assert_identical(with_units[name].variable, values)
    assert float(with_units.frequency[-1]) == float(with_units.omega_end) == 160.0
    assert with_units.settled_velocity_strobe.attrs["units"] == "m s-1"


@pytest.mark.parametrize(
    "further",
    [
        {"k1": 50.0},
        {"friction": 0.1},
        {"shaker": 0.1},
        {"k1": 50.0, "friction": 0.05, "shaker": 0.1},
    ],
)
def test_a_study_ramps_soft_supports_friction_and_a_shaker(further: dict[str, float]) -> None:
    ds = solved(ramp_study(1.6, **further))
    e = vp.Exciter(nu=0.6, **NUMBERS, **further)
    motion = vp.simulate(e, 600.0, samples_per_period=16, nu_end=1.6)
    assert motion.sizes["impact"] > 20
    for name in ("impact_tau", "impact_velocity", "displacement", "force", "frequency"):
        np.testing.assert_array_equal(ds[name], motion[name])
    # what it ends in, held at the last frequency, by a plain march
    last, turn = replace(e, nu=1.6), (0.6 * 600.0 + 0.5 * 600.0) / (2 * np.pi) % 1.0
    state = float(motion.displacement_end), float(motion.velocity_end)
    supports, _end = held(last, state, turn)
    m = int(ds["settled_period_multiple"][0])
    assert 12 % max(m, 1) == 0
    counts = ds["settled_impacts_per_orbit"].values[0] * (12 // max(m, 1))
    assert [(supports == side).sum() for side in (1, 2)] == counts.tolist()
    told = answers({"up": ds})["up"][0]
    assert told.lead.startswith("The ramp ends in")
    assert "largest in a forcing cycle" in words(picture_of("motion", ds).draw(ds, None, {}))


def test_lengths_and_frequencies_of_a_ramp_have_units() -> None:
    scene = study("ramp: {omega: {from: 10 Hz, to: 25 Hz, within: 6}}", top=UNITS).scenes["up"]
    assert scene.tau_end == scene.ramp_ends.within == 600.0
    assert scene.ramp_ends.to == pytest.approx(25 * 2 * math.pi / 100, rel=1e-15)


@pytest.mark.parametrize("name", ["kept", "same"])
def test_what_settles_is_what_a_long_motion_shows(
    name: str, request: pytest.FixtureRequest
) -> None:
    ds = request.getfixturevalue(name)
    e = vp.Exciter(nu=float(ds.nu_end), **NUMBERS)
    turn = (600.0 * (0.6 + e.nu) / 2 / (2 * math.pi)) % 1.0
    ends = (float(ds.displacement_end), float(ds.velocity_end)), turn
    for number, start in enumerate((ends, ((0.0, 0.0), 0.0))):
        supports, state = held(e, *start)
        multiple = int(ds.settled_period_multiple[number])
        for support in (1, 2):
            expected = 12 / multiple * float(ds.settled_impacts_per_orbit[number, support - 1])
            assert (supports == support).sum() == expected
        if multiple == 1:
            strobe = ds.settled_displacement_strobe[number], ds.settled_velocity_strobe[number]
            assert state == pytest.approx(np.array(strobe), abs=1e-8)
    assert int(ds.settled_same) == (name == "same")


def test_the_finding_says_what_the_ramp_ends_in(kept: xr.Dataset, same: xr.Dataset) -> None:
    assert list(kept.settled_regime.values) == [Regime.TWO_SIDED, Regime.NO_IMPACT]
    (first, *_), (second, *_) = (answers({"up": ds})["up"] for ds in (kept, same))
    assert (
        first.lead
        == "The ramp ends in another motion than the one from rest at the same frequency."
    )
    assert first.rest == (
        "Held at 1.6 after the ramp, both supports are struck once in each forcing period; "
        "from rest there, no support is struck."
    )
    assert second.lead == "The ramp ends in the motion that starts from rest at the same frequency."
    assert "from rest there" not in second.rest
    (both, *_) = answers({"up": kept, "low": same})[""]
    assert both.lead == "A ramp ends in another motion than the one from rest in “up”."


@pytest.mark.filterwarnings("ignore:status")
def test_without_an_orbit_nothing_is_compared() -> None:
    ds = solved(ramp_study(1.2, l=0.5))
    assert int(ds.settled_same) == -1
    assert 0 in ds.settled_period_multiple.values
    answer = answers({"up": ds})["up"][0]
    assert answer.lead == "The ramp and the start from rest do not both end in an orbit."
    assert "does not repeat" in answer.rest


def test_a_ramp_is_stored_and_read(tmp_path: Path) -> None:
    made = study(SHORT)
    solve_to_file(made, "up", tmp_path / "up.nc", None, 1)
    expected = solved(made)
    with xr.open_dataset(tmp_path / "up.nc") as stored:
        assert expected.variables.keys() <= stored.variables.keys()
        for name, values in expected.variables.items():
            assert np.array_equal(stored[name].values, values.values), name


@pytest.mark.parametrize("start", [0.6, 1.6])
def test_the_picture_has_the_extremes_of_each_cycle(start: float) -> None:
    end = 2.2 - start
    e = replace(vp.Exciter(nu=start, **NUMBERS), l=1.5)
    ds = vp.simulate(e, 90.0, nu_end=end, samples_per_period=400)
    picture = picture_of("motion", ds)
    assert picture.name == "ramp"
    figure = picture.draw(ds, None, {})
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 2]
    largest, least = (np.asarray(line.get_ydata()) for line in lines)
    nu = np.asarray(lines[0].get_xdata())
    # the times at which the phase is a whole number of turns
    change = (end - start) / 90.0
    n = np.arange(int((start + end) / 2 * 90 / (2 * math.pi)) + 1)
    at = (np.sqrt(start**2 + 4 * math.pi * n * change) - start) / change
    assert len(nu) == len(at) - 1
    for k, (first, last) in enumerate(itertools.pairwise(at)):
        own = ds.displacement.values[(ds.tau.values >= first) & (ds.tau.values < last)]
        hit = (ds.impact_tau.values >= first) & (ds.impact_tau.values < last)
        walls = np.where(ds.impact_support.values[hit] == 1, e.upper, e.lower)
        own = np.append(own, walls)
        assert (largest[k], least[k]) == (own.max(), own.min())
        middle = start + change * (first + last) / 2
        assert nu[k] == pytest.approx(middle, abs=2 * abs(change) * 2 * math.pi / 400 / 0.6)
    text = words(figure)
    assert "largest in a forcing cycle" in text
    assert "support 1" in text
    assert f"time runs to the {'right' if start < end else 'left'}" in text
    assert picture.title(ds, None, {}).startswith("Supports are struck from ")


def test_a_ramp_without_two_whole_cycles_has_curves_over_time() -> None:
    short = vp.simulate(vp.Exciter(nu=3.0, **NUMBERS), 1.0, nu_end=0.1)
    assert picture_of("motion", short).name == "panels"
    figure = picture_of("motion", short, "ramp").draw(short, None, {})
    assert "The ramp has no two whole forcing cycles" in words(figure)
    assert "in a forcing cycle" not in words(figure)


def test_title_and_caption_have_the_units_of_the_study(kept: xr.Dataset) -> None:
    ds = vp.to_physical(kept, M, C, units={"frequency": "Hz"})
    picture = picture_of("motion", ds)
    assert picture.title(ds, None, {}) == answers({"up": kept})["up"][0].lead.removesuffix(".")
    figure = vp.plot(ds)
    assert "(Hz)" in figure.axes[0].get_xlabel()
    caption = picture.describe(ds, None, {})
    assert "The frequency changes linearly, ω = 60 to 160 rad/s within 6 s" in caption
    assert "Held at 160 rad/s after the ramp" in caption


@pytest.mark.parametrize("falls", [False, True])
def test_names_of_lines_stay_within_the_frame(falls: bool) -> None:
    nu = np.sqrt(np.linspace(0.01, 4.0, 101))  # cycles of a linear ramp: most lie at its fast end
    largest = 1.0 + nu  # where there is most room
    if falls:
        nu, largest = nu[::-1], largest[::-1]
    x, top, bottom = widest(nu, -np.ones(101), largest)
    half = 0.5 * NAME_SHARE * 1.9  # of the range of frequencies
    assert 2.0 - 2.0 * half < x < 2.0 - 0.97 * half
    assert top == pytest.approx(1.0 + x - half, abs=0.02)
    assert bottom == -1.0


def test_ends_of_a_short_ramp_are_told_apart() -> None:
    ds = solved(study("ramp: {nu: {from: 1, to: 1.00002, within: 200}}"))
    picture = picture_of("motion", ds, "ramp")
    caption = picture.describe(ds, None, {})
    assert "The frequency changes linearly, ν = 1 to 1.00002 within τ = 200" in caption
    struck = np.interp(ds["impact_tau"], ds["tau"], ds["frequency"])
    ds = ds.drop_vars("settled_same")  # what the ramp ends in would be the title
    several, one = (picture.title(part, None, {}) for part in (ds, ds.isel(impact=slice(1))))
    ends = [float(text) for text in several.partition(" from ν = ")[2].split(" to ")]
    assert ends == pytest.approx(struck[[0, -1]], abs=5e-6)
    assert ends[0] < ends[1]
    assert one.startswith("A support is struck once, at ν = 1")


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("ramp: {nu: {to: 1, within: 20}}", "ramp.nu.from: is required (the frequency at the start"),
        ("ramp: {nu: {from: 1, to: 1, within: 20}}", "ramp.nu.to: must differ from the frequency"),
        ("ramp: {nu: {from: 1, to: 2, within: 0}}", "ramp.nu.within: must be a number above 0"),
        ("ramp: {nu: {from: 1, to: -2, within: 1}}", "ramp.nu.to: must be a number above 0"),
        ("ramp: {nu: {from: 1, within: 1}}", "ramp.nu.to: is required (a number above 0"),
        ("ramp: {nu: 3}", "ramp.nu: must be a mapping with from, to, within"),
        ("ramp: {f: {from: 1, to: 2, within: 1}}", "ramp: must name the frequency"),
        ("ramp: {nu: {from: 1, to: 2, within: 1e9}}", "ramp.nu.within: must give at most 6e+06 steps"),
        (f"{SHORT}, tau_end: 3", "tau_end: must be left out beside ramp"),
        (f"{SHORT}, solver: {{accuracy: 1e-6}}", "solver: must be left out beside ramp"),
        (f"{SHORT}, effects: [forcing]", "effects: must"),
        (f"{SHORT}, prove: {{}}", "prove: must be left out beside ramp"),
        (f"{SHORT}, outputs: [motion, sensitivity]", "outputs: must leave out sensitivity beside ramp"),
        (f"{SHORT}, figure: {{periods: 2}}", "figure.periods: must be left out beside ramp"),
        (f"{SHORT}, figure: {{pictures: [section]}}", "figure.pictures: must leave out section"),
        (f"{SHORT}, figure: {{show: [force]}}", "figure.show: must be left out unless pictures"),
        (f"{SHORT}, samples_per_period: 0, figure: {{pictures: [ramp]}}", "must leave out ramp unless outputs"),
        ("exciter: {nu: 1}, figure: {pictures: [ramp]}", "must leave out ramp unless the scene has"),
        (f"{SHORT}, ties: {{f: 0.5 * nu**2}}", "ties: must not follow nu beside ramp"),
        (f"{SHORT}, exciter: {{mass_ratio: 0.2}}", "ramp: must be left out: the mass_ratio of the"),
    ],
)  # fmt: skip
def test_what_has_no_meaning_beside_a_ramp_is_refused(keys: str, told: str) -> None:
    with pytest.raises(StudyError) as caught:
        study(keys, "l: 2, h: 0.1, nu: 1" if "ties" in keys else "")
    assert told in str(caught.value)
    # no fault that only follows from another
    if "ramp.nu." in told:
        assert "exciter.nu" not in str(caught.value)


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        ("from: 10 Hz, to: 25 Hz, within: 6 Hz", "within: must be a number in s or a time > 0"),
        ("from: 10 Hz, to: 25, within: 6 s", "to: must be a frequency > 0 with its unit"),
        ("from: 10 Hz, to: 10 Hz, within: 6 s", "to: must differ from the frequency at the start"),
    ],
)
def test_quantities_of_a_ramp_are_refused_under_their_keys(ends: str, told: str) -> None:
    with pytest.raises(StudyError) as caught:
        study(f"ramp: {{omega: {{{ends}}}}}", top=UNITS)
    (line,) = str(caught.value).splitlines()
    assert f"scenes.up.ramp.omega.{told}" in line


def test_motions_before_there_were_ramps_keep_their_identity() -> None:
    plain = study("tau_end: 20, exciter: {nu: 1}").scenes["up"]
    assert "ramp" not in plain.data_keys()
    one, other = (
        study(f"ramp: {{nu: {{from: 0.6, to: {to}, within: 20}}}}").scenes["up"] for to in (1, 2)
    )
    assert one.fingerprint() != other.fingerprint()
