"""Branches with a motor in a study: data as of `vp.motor`, picture, answers, tables, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from drawing import draw
from figures.figure_text import words
from numpy.polynomial import Polynomial

import vibropipe as vp
from vibropipe.figures.line_names import NAME
from vibropipe.jobs.solving import solve_to_file
from vibropipe.scenes.branch.answers import branch_answers
from vibropipe.scenes.branch.motor import title_motor
from vibropipe.scenes.branch.pictures import PICTURES
from vibropipe.scenes.branch.report import tables
from vibropipe.scenes.branch.solve import with_motor
from vibropipe.scenes.registry import kinds
from vibropipe.study import Study, StudyError, study_of_text

OUTPUTS = ("harmonics", "impacts", "stability", "energy", "power", "sensitivity")
# A motion that strikes no support, whose speeds and jumps are roots of a polynomial (tests/solve/test_motor.py).
LINEAR = vp.Exciter(nu=0.6, h=0.1, f=0.3, l=50.0)
OF_CROSSINGS = ("motor_torque", "speed_is_stable", "crossing_point")
OF_JUMPS = ("jump_torque", "jump_way", "jump_nu", "jump_to_nu")
EXCITER, LINE = "{h: 0.1, f: 0.3, l: 50}", "{no_load: 2.2, stall: 0.55}"
ALONG = "along: {nu: {from: 0.6, to: [0.2, 2.9]}}"
M, C = 0.4, 6000.0
UNITS = (
    f"physical: {{m: {M} kg, C: {C} N/m, l: 50 m, H: {0.1 * (M * C) ** 0.5!r} N s/m, F: 1800 N}}\n"
)


def text_of(keys: str, top: str = f"exciter: {EXCITER}\n") -> str:
    return f"title: T\n{top}scenes:\n  run: {{kind: branch, {keys}}}\n"


def study(keys: str, top: str = f"exciter: {EXCITER}\n") -> Study:
    return study_of_text(text_of(keys, top), "mine")


def solved(made: Study) -> xr.Dataset:
    return kinds()["branch"].solve(made.scenes["run"])


@pytest.fixture(scope="module")
def branch() -> xr.Dataset:
    return vp.branch(LINEAR, "nu", (0.2, 2.9), outputs=OUTPUTS)


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return solved(study(f"{ALONG}, motor: {LINE}"))


def test_a_study_has_the_speeds_and_jumps_of_the_call(
    dataset: xr.Dataset, branch: xr.Dataset
) -> None:
    found = vp.motor(branch, {"no_load": 2.2, "stall": 0.55})
    np.testing.assert_array_equal(dataset.crossing_nu, found.nu)
    for name in (*OF_CROSSINGS, *OF_JUMPS):
        np.testing.assert_array_equal(dataset[name], found[name], err_msg=name)
    nu = dataset.nu.values
    np.testing.assert_allclose(dataset.available_torque, 0.55 * (1 - nu / 2.2), atol=1e-15)
    response = 0.1 * nu * 0.3**2 / 2 / ((1 - nu**2) ** 2 + (0.1 * nu) ** 2)
    np.testing.assert_allclose(dataset.load_torque, response, rtol=1e-12)
    before = nu[dataset.crossing_point.values]
    assert (np.sign(dataset.crossing_nu - before) * np.sign(np.diff(nu)[0]) >= 0).all()
    assert not [name for name in dataset.variables if str(name).endswith("_sensitivity")]
    assert "parameter" not in dataset.dims


def test_a_torque_of_points_is_that_of_the_call(branch: xr.Dataset) -> None:
    points = [(0.3, 0.4), (1.0, 0.3), (2.5, 0.1)]
    own = solved(study(f"{ALONG}, motor: {{speed: [0.3, 1, 2.5], torque: [0.4, 0.3, 0.1]}}"))
    found = vp.motor(branch, points)
    np.testing.assert_array_equal(own.crossing_nu, found.nu)
    is_given = (own.nu >= 0.3) & (own.nu <= 2.5)
    np.testing.assert_array_equal(np.isfinite(own.available_torque), is_given)


def test_units_are_those_of_speeds_and_torques(branch: xr.Dataset, tmp_path) -> None:
    p, stall = (C / M) ** 0.5, 0.55 * C
    along = (
        f"along: {{omega: {{from: {0.6 * p!r} rad/s, to: [{0.2 * p!r} rad/s, {2.9 * p!r} rad/s]}}}}"
    )
    line = f"{{no_load: {2.2 * p * 30 / np.pi!r} rpm, stall: {stall!r} N m}}"
    made = study(f"{along}, motor: {line}", UNITS + "units: {frequency: Hz}\n")
    solve_to_file(made, "run", tmp_path / "run.nc", None, 1)
    own, found = vp.load(tmp_path / "run.nc"), vp.motor(branch, {"no_load": 2.2, "stall": 0.55})
    np.testing.assert_allclose(own.crossing_omega, found.nu * p, rtol=1e-9)
    np.testing.assert_allclose(own.motor_torque, found.motor_torque * C, rtol=1e-9)
    np.testing.assert_allclose(own.jump_torque, found.jump_torque * C, rtol=1e-7)
    for name in ("motor_torque", "load_torque", "available_torque", "jump_torque"):
        assert own[name].attrs["units"] == "N m"
    assert own.crossing_omega.attrs["units"] == "rad s-1"


def test_picture_answers_and_tables_say_what_is_kept(dataset: xr.Dataset) -> None:
    assert title_motor(dataset) == (
        "The motor keeps two of three speeds at which its torque is that of the load"
    )
    figure = draw("branch", dataset)
    shown = words(figure)
    assert "motor" in shown
    assert "speed that is kept" in shown
    arrows = [each for each in figure.axes[0].texts if getattr(each, "arrow_patch", None)]
    assert len(arrows) == 2  # both jumps lead to a known speed
    answer = branch_answers(dataset)[0]
    kept = dataset.crossing_nu.values[[0, 2]]
    ends = " or ".join(f"{value:.4g}" for value in kept)
    assert answer.lead.startswith("Of the motions followed here the motor keeps those at ")
    assert answer.lead.endswith(f" = {ends}.")
    n = int(np.abs(dataset.jump_torque.values).argmin())
    assert f"for {float(dataset.jump_to_nu[n]):.4g}." in answer.rest
    speeds, jumps = tables({"run": dataset})[:2]
    assert [row[-1] for row in speeds.rows] == ["yes", "no", "yes"]
    assert [row[2] for row in jumps.rows] == [f"{float(v):.5g}" for v in dataset.jump_nu]
    assert [row[1] for row in jumps.rows] == ["lowered", "raised"]
    assert not any("–" in row for row in jumps.rows)


def test_what_is_not_known_is_told(branch: xr.Dataset) -> None:
    none = with_motor(branch, [(0.2, -1.0), (3.0, -1.0)])
    assert title_motor(none) == (
        "The torque of the motor is that of the load at no speed followed here"
    )
    assert branch_answers(none)[0].lead == (
        "The motor keeps the speed of none of the motions followed here."
    )
    assert branch_answers(none)[0].rest == ""
    assert "At which speeds" not in [table.title for table in tables({"run": none})]
    one = with_motor(vp.branch(LINEAR, "nu", 0.8, outputs=OUTPUTS), {"no_load": 2.2, "stall": 0.01})
    assert title_motor(one).startswith("The motor ")


@pytest.mark.slow
def test_several_exciters_have_the_speeds_of_each() -> None:
    made = study(
        f"{ALONG}, over: {{h: [0.1, 0.2, 0.4]}}, motor: {LINE}", "exciter: {f: 0.3, l: 50}\n"
    )
    own = solved(made)
    line, nu = 0.55 * (1 - Polynomial([0, 1 / 2.2])), Polynomial([0, 1])
    for h in (0.1, 0.2, 0.4):
        # As of one exciter, the speeds are roots of a polynomial.
        roots = (line * ((1 - nu**2) ** 2 + h**2 * nu**2) - h * 0.3**2 / 2 * nu).roots()
        exact = sorted(z.real for z in roots if abs(z.imag) < 1e-9 and 0.2 < z.real < 2.9)
        at = own.crossing_h.values == h
        np.testing.assert_allclose(own.crossing_nu.values[at], exact, atol=1e-10)
        alone = vp.branch(replace(LINEAR, h=h), "nu", (0.2, 2.9), outputs=OUTPUTS)
        found = vp.motor(alone, {"no_load": 2.2, "stall": 0.55})
        lost = own.jump_h.values == h
        for name in OF_JUMPS:
            np.testing.assert_array_equal(own[name].values[lost], found[name].values)
        points = own.crossing_point.values[at]
        np.testing.assert_array_equal(own.h.values[points], h)
        assert (np.diff(own.crossing_nu.values[at]) > 0).all()
    kept = own.speed_is_stable.values == 1
    assert title_motor(own) == "At each of three values of h the motor keeps a speed followed here"
    lost_all = own.assign(speed_is_stable=0 * own.speed_is_stable)
    none = "At none of three values of h does the motor keep a speed followed here"
    assert title_motor(lost_all) == none
    low, high = (
        f"{end:.4g}"
        for end in (own.crossing_nu.values[kept].min(), own.crossing_nu.values[kept].max())
    )
    assert branch_answers(own)[0].rest.startswith(f"They lie at ν = {low} to {high}.")
    speeds, jumps = tables({"run": own})[:2]
    assert [row[0] for row in speeds.rows] == [f"{h:g}" for h in own.crossing_h.values]
    assert [row[0] for row in jumps.rows] == [f"{h:g}" for h in own.jump_h.values]
    figure = draw("branch", own)
    names = {text.get_text(): text for text in figure.axes[0].texts if text.get_gid() == NAME}
    assert set(names) == {"motor", "$h$ = 0.1", "$h$ = 0.2", "$h$ = 0.4"}
    torques = zip(own.crossing_nu.values, own.motor_torque.values, strict=True)
    places = figure.axes[0].transData.transform(list(torques))
    for box in (text.get_window_extent() for text in names.values()):
        assert not ((places > box.min) & (places < box.max)).all(axis=1).any()
    with pytest.raises(vp.ParameterError, match="must be of one exciter: select the points"):
        vp.motor(own.assign(power_input_sensitivity=own.power_input), {"no_load": 2, "stall": 1})


def test_one_speed_of_all_values_is_written_once() -> None:
    # what is not struck does not move the speed
    own = solved(study(f"{ALONG}, over: {{R1: [0.5, 0.6]}}, motor: {{no_load: 2.2, stall: 2}}"))
    kept = own.crossing_nu.values[own.speed_is_stable.values == 1]
    assert kept.size == 2
    assert np.ptp(kept) <= 1e-12
    assert branch_answers(own)[0].rest.startswith(f"They lie at ν = {kept[0]:.4g}.")


@pytest.mark.slow
def test_what_is_swept_has_units_or_a_name_of_ones_own_at_speeds_and_jumps() -> None:
    p = (C / M) ** 0.5
    along = (
        f"along: {{omega: {{from: {0.6 * p!r} rad/s, to: [{0.2 * p!r} rad/s, {2.9 * p!r} rad/s]}}}}"
    )
    line = f"{{no_load: {2.2 * p!r} rad/s, stall: {0.55 * C!r} N m}}"
    made = study(f"{along}, over: {{delta: [0 m, 0.5 m]}}, motor: {line}", UNITS)
    own = solved(made)
    assert set(own.crossing_delta.values.tolist()) == {0.0, 0.5}
    assert own.crossing_delta.attrs["units"] == own.jump_delta.attrs["units"] == "m"
    tied = "exciter: {f: 0.3, l: 50}\nties: {h: 2 * zeta}\n"
    named = solved(study(f"{ALONG}, over: {{zeta: [0.05, 0.1]}}, motor: {LINE}", tied))
    plain = solved(
        study(f"{ALONG}, over: {{h: [0.1, 0.2]}}, motor: {LINE}", "exciter: {f: 0.3, l: 50}\n")
    )
    np.testing.assert_allclose(named.crossing_nu, plain.crossing_nu, rtol=1e-12)
    np.testing.assert_array_equal(named.crossing_zeta, plain.crossing_h / 2)
    assert named.jump_zeta.attrs["long_name"] == "zeta before the jump"


def test_a_law_has_speeds_and_what_follows_its_end_is_not_known() -> None:
    top = "exciter: {h: 0.1, f: 0.5, l: 1, delta: 0.2, R1: 0.6, R2: 0.6}\n"
    line = "{no_load: 3, stall: 0.4}"
    own = solved(
        study(f"along: {{nu: {{within: [1.2, 2.2]}}}}, law: [1, 1, 1], motor: {line}", top)
    )
    exciter = vp.Exciter(nu=1.5, h=0.1, f=0.5, l=1.0, delta=0.2, R1=0.6, R2=0.6)
    followed = vp.branch(exciter, "nu", (1.2, 2.2), v0=2.0, outputs=OUTPUTS)
    found = vp.motor(followed, {"no_load": 3.0, "stall": 0.4})
    np.testing.assert_allclose(own.crossing_nu, found.nu, rtol=1e-9)
    np.testing.assert_array_equal(own.speed_is_stable, found.speed_is_stable)
    np.testing.assert_allclose(own.jump_nu, found.jump_nu, rtol=1e-7)
    assert np.isnan(own.jump_to_nu.values).all()
    for speed in own.crossing_nu.values[own.speed_is_stable.values == 1]:
        orbit = vp.steady_state(replace(exciter, nu=float(speed)), v0=2.0, outputs=["power"])
        assert float(orbit.power_input) / speed == pytest.approx(0.4 * (1 - speed / 3), rel=1e-9)
    assert branch_answers(own)[1].rest.endswith(
        ", unless a motion that is not followed here keeps it."
    )
    (jumps,) = (
        each for each in tables({"run": own}) if "or motions followed here end" in each.title
    )
    assert "and may keep the speed" in jumps.note


def test_orbits_that_begin_at_a_pitchfork_may_keep_the_speed() -> None:
    top = "exciter: {h: 0.2, f: 1.0, l: 0.5, R1: 0.7, R2: 0.7}\n"
    along = "along: {nu: {from: 1.2, to: [1.16, 1.6]}}"
    motor = "motor: {no_load: 1.5, stall: 0.8}"
    alone = solved(study(f"{along}, {motor}", top))
    (answer,) = (each for each in branch_answers(alone) if "the motor keeps" in each.lead)
    assert answer.rest.endswith(", unless a motion that is not followed here keeps it.")
    (jumps,) = (
        each for each in tables({"run": alone}) if each.title.startswith("Where the speed jumps")
    )
    assert jumps.title.endswith(", or motions followed here end")
    assert jumps.note.endswith("not among the motions followed here, and may keep the speed.")
    assert not solved(study(f"{along}, switch: [pitchfork], {motor}", top)).sizes["jump"]


@pytest.mark.slow
def test_jumps_along_the_orbits_of_a_law_are_known(branch: xr.Dataset) -> None:
    torque = {"no_load": 2.2, "stall": 0.55}
    of_law = vp.branch(LINEAR, "nu", (0.2, 2.9), law=(1, 0, 0), outputs=OUTPUTS)
    found, known = vp.motor(of_law, torque), vp.motor(branch, torque)
    assert np.isfinite(known.jump_to_nu).all()
    for name in OF_JUMPS:
        np.testing.assert_allclose(found[name], known[name], rtol=1e-7)


def test_without_a_motor_branches_are_drawn(branch: xr.Dataset) -> None:
    assert [each.name for each in PICTURES if each.fits(branch)] == ["branches"]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (f"{ALONG}, motor: {{}}", "motor: is required (no_load and stall, or speed and torque)"),
        (f"{ALONG}, motor: {{no_load: 2}}", "motor.stall: is required"),
        (f"{ALONG}, motor: {{no_load: 2, stall: 1, speed: [1, 2]}}", "motor.speed: must be left out beside no_load"),
        (f"{ALONG}, motor: {{no_load: 2, stall: -1}}", "motor.stall: must be a finite number > 0, got -1"),
        (f"{ALONG}, motor: {{speed: [1, 2], torque: [1, 2, 3]}}", "motor.torque: must be 2, one for each speed"),
        (f"{ALONG}, motor: {{speed: [2, 1], torque: [1, 2]}}", "motor.speed: must be increasing numbers"),
        ("along: {f: {from: 0.3, to: 0.4}}, exciter: {nu: 1}, motor: " + LINE,
         "motor: must be left out unless the frequency"),
        (f"{ALONG}, tolerance: {{f: 0.01}}, motor: {LINE}", "tolerance: must be left out beside motor"),
        (f"{ALONG}, figure: {{pictures: [motor]}}", "figure.pictures: must leave out motor unless"),
    ],
)  # fmt: skip
def test_a_motor_that_cannot_be_meant_is_refused(keys: str, message: str) -> None:
    top = f"exciter: {EXCITER}\n" if "along: {nu" in keys else "exciter: {h: 0.1, l: 50}\n"
    with pytest.raises(StudyError) as raised:
        study(keys, top)
    assert message in str(raised.value)
