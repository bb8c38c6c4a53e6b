"""A shaken frame and an unbalance: a force that grows with the square of the frequency, wherever that varies."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.scenes.motion.curves import acceleration_bound
from vibropipe.scenes.motion.panels import panel_names
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, load_study, study_of_text

TWO_SIDED = vp.Exciter(l=0.5, h=0.1, R1=0.7, R2=0.6, delta=0.05, nu=1.2, f=0.1, shaker=0.5)
SOFT = vp.Exciter(
    l=0.5, h=0.1, k1=50, k2=40, R1=0.7, R2=0.7, friction=0.02, nu=1.2, f=0.1, shaker=0.5
)

STUDY = """
title: An unbalance
physical: {m: 0.35 kg, C: 6 N/mm, H: 4 N s/m, l: 1 mm, m_e: 50 g, e: 2 mm}
exciter: {R1: 0.7, R2: 0.6}
scenes:
  speeds:
    kind: sweep
    physical: {e: 3 mm}
    over: {omega: {start: 18 Hz, stop: 30 Hz, points: 7}}
    outputs: [impacts, power]
  line: {kind: branch, physical: {e: 3 mm}, along: {omega: {from: 24 Hz, to: 30 Hz}}}
"""


def forced(exciter: vp.Exciter, **changed: float) -> vp.Exciter:
    """Return an exciter whose force is the same at its frequency, and does not grow with it."""
    there = replace(exciter, **changed)
    f = float(there.numbers().f) + there.shaker * there.nu**2
    return replace(there, shaker=0.0, f=f)


@pytest.mark.parametrize("exciter", [TWO_SIDED, SOFT])
def test_motion_is_that_of_the_force_at_its_frequency(exciter):
    outputs = ("harmonics", "impacts", "energy", "power")
    there, same = (vp.steady_state(each, outputs=outputs) for each in (exciter, forced(exciter)))
    for name in ("displacement_strobe", "impact_velocity", "power_input", "displacement_amplitude"):
        np.testing.assert_array_equal(there[name], same[name])
    assert float(there["f"]) == 0.1
    assert float(there["shaker"]) == 0.5


@pytest.mark.parametrize(
    "over",
    [
        {"nu": [1.0, 1.2, 1.4], "shaker": [0.1, 0.2]},
        {"nu": [1.0, 1.2, 1.4], "f": [0.0, 0.2]},
        {"nu": [1.4, 1.0], "shaker": [0.1, 0.2], "f": [0.2, 0.0, 0.1]},
    ],
    ids=" ".join,
)
def test_a_sweep_varies_the_frequency_beside_a_force(over):
    """Grids of other lengths than each other's are no rows."""
    base = vp.Exciter(l=0.5, nu=1.1, h=0.1, f=0.05, shaker=0.15, R1=0.7, R2=0.7)
    rows = vp.sweep(base, over)
    for place in np.ndindex(*(len(values) for values in over.values())):
        at = dict(zip(over, place, strict=True))
        own = replace(base, **{name: over[name][n] for name, n in at.items()})
        alone = vp.steady_state(own)
        assert rows.displacement_strobe.isel(at).item() == alone.displacement_strobe.item()
    text = ", ".join(f"{name}: {sorted(each)}" for name, each in over.items())
    study = f"""
title: Over all
exciter: {{l: 0.5, nu: 1.1, h: 0.1, f: 0.05, shaker: 0.15}}
scenes:
  own: {{kind: sweep, over: {{{text}}}}}
"""
    assert study_of_text(study, "own").scenes["own"].over.keys() == over.keys()


def test_amplitude_of_an_unbalance():
    """X = (m_e e / m) nu^2 / |1 - nu^2 + i h nu|, which tends to m_e e / m."""
    m, C, H, m_e, e = 0.35, 6000.0, 4.0, 0.05, 0.003
    given = {"m": m, "C": C, "H": H, "m_e": m_e, "e": e, "l": 0.02, "omega": 100.0}
    exciter = vp.Exciter.from_physical(**given)
    assert exciter.shaker == pytest.approx(m_e * e / m, rel=1e-15)
    p, h = math.sqrt(C / m), H / math.sqrt(m * C)
    omega = np.array([40.0, 120.0, 400.0, 4000.0])
    found = vp.sweep(exciter, {"nu": omega / p}, outputs=["harmonics"])
    nu = omega / p
    expected = m_e * e / m * nu**2 / np.abs(1 - nu**2 + 1j * h * nu)
    np.testing.assert_allclose(
        found["displacement_amplitude"].sel(harmonic=1), expected, rtol=1e-12
    )
    plain = vp.Exciter.from_physical(m=m, C=C, H=H, F=m_e * e * 100.0**2, l=0.02, omega=100.0)
    assert plain.f == pytest.approx(exciter.f, rel=1e-15)
    frame = vp.Exciter.from_physical(m=m, C=C, H=H, shaker="0.2 mm", l=0.02, omega=100.0)
    assert (frame.shaker, float(frame.f)) == (2e-4, pytest.approx(2e-4 * 100.0**2 * m / C))


@pytest.mark.parametrize("exciter", [TWO_SIDED, SOFT])
@pytest.mark.parametrize(
    ("along", "to"), [("nu", (0.9, 1.6)), ("shaker", (0.4, 0.8)), ("f", (0.0, 0.4))]
)
def test_branch_has_the_force_of_each_point(exciter, along, to):
    branch = vp.branch(exciter, along, to)
    orbits = branch.isel(point=np.flatnonzero(branch["stable"].values == 1)[::9])
    assert orbits.sizes["point"] > 3
    for n in range(orbits.sizes["point"]):
        point = orbits.isel(point=n)
        start = float(point["displacement_strobe"]), float(point["velocity_strobe"])
        settled = vp.steady_state(forced(exciter, **{along: float(point[along])}), *start)
        np.testing.assert_allclose(settled["displacement_strobe"], start[0], atol=1e-11)
        np.testing.assert_allclose(settled["velocity_strobe"], start[1], atol=1e-11)


@pytest.mark.parametrize("soft", [{}, {"k1": 80.0, "k2": 80.0}])
def test_first_grazing_of_a_shaken_frame(soft):
    """The linear motion touches a support where shaker nu^2 = l |1 - nu^2 + i h nu|."""
    exciter = vp.Exciter(l=0.5, h=0.3, R1=0.7, R2=0.7, shaker=0.1, nu=1.0, **soft)
    found = vp.boundary(exciter, "grazing", ("nu", "shaker"), ((0.7, 1.4), (0.05, 0.6)), lines=4)
    first = found.isel(point=np.flatnonzero(found["impacts_per_orbit"].sum("support").values == 0))
    assert first.sizes["point"] > 10
    nu = first["nu"].values
    expected = 0.5 * np.abs(1 - nu**2 + 0.3j * nu) / nu**2
    np.testing.assert_allclose(first["shaker"], expected, rtol=1e-11)


@pytest.mark.parametrize("exciter", [TWO_SIDED, SOFT])
def test_derivatives_follow_the_force(exciter):
    outputs = ("harmonics", "impacts", "power", "sensitivity")
    names = ("displacement_mean", "displacement_amplitude", "impact_velocity_max", "power_input")
    here = vp.steady_state(exciter, outputs=outputs)
    start = float(here["displacement_strobe"]), float(here["velocity_strobe"])
    for parameter in ("nu", "f", "h"):
        own, step = float(getattr(exciter.numbers(), parameter)), 1e-5
        ends = [
            vp.steady_state(
                replace(exciter, **{parameter: own + sign * step}), *start, outputs=outputs
            )
            for sign in (1, -1)
        ]
        for name in names:
            slope = (ends[0][name] - ends[1][name]) / (2 * step)
            stored = here[f"{name}_sensitivity"].sel(parameter=parameter)
            np.testing.assert_allclose(stored, slope, rtol=2e-6, atol=1e-8)


def test_deviation_of_an_unbalance():
    """Its share in a spread is that of the force, times nu^2."""
    wanted = {"shaker": 1e-4}
    found = vp.tolerance(TWO_SIDED, wanted)
    same = vp.tolerance(forced(TWO_SIDED), {"f": 1e-4 * TWO_SIDED.nu**2})
    for name in ("displacement_mean_std", "impact_velocity_max_std"):
        np.testing.assert_allclose(found[name], same[name], rtol=1e-6)


def test_a_design_varies_it():
    wanted = {"impact_velocity_max_1": 0.7}
    found = vp.design(
        TWO_SIDED,
        vary={"shaker": (0.1, 0.6), "nu": (1.0, 1.4)},
        target=wanted,
        samples=64,
        designs=2,
    )
    first = found.isel(design=0)
    exciter = forced(TWO_SIDED, nu=float(first["nu"]), shaker=float(first["shaker"]))
    settled = vp.steady_state(exciter)
    assert float(settled["impact_velocity_max"][0]) == pytest.approx(0.7, abs=1e-6)


def test_proof_encloses_what_the_frequency_does():
    pytest.importorskip("flint")
    proof = vp.prove(TWO_SIDED, within={"nu": 1e-3, "shaker": 1e-3})
    assert int(proof["proved"]) == 1
    for nu in (1.199, 1.201):
        for shaker in (0.499, 0.501):
            there = vp.steady_state(forced(TWO_SIDED, nu=nu, shaker=shaker), outputs=("harmonics",))
            mean = float(there["displacement_mean"])
            assert (
                float(proof["displacement_mean_low"])
                <= mean
                <= float(proof["displacement_mean_high"])
            )
    missed = vp.prove(forced(TWO_SIDED), within={"nu": 1e-3})
    there = vp.prove(TWO_SIDED, within={"nu": 1e-3})
    assert float(missed["displacement_mean_high"]) != float(there["displacement_mean_high"])


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"m_e": "50 g"}, "m_e: must be left out unless e stands beside it"),
        ({"e": "3 mm"}, "e: must be left out unless m_e stands beside it"),
        ({"m_e": "2 kg", "e": "3 mm", "omega": "20 Hz"}, "m_e: must not exceed m"),
        ({"m_e": "50 g", "e": "3 mm"}, "omega: is required beside m_e"),
        ({"shaker": "0.2 mm"}, "omega: is required beside shaker"),
    ],
)
def test_what_is_missing_beside_an_unbalance(given, told):
    with pytest.raises(vp.ParameterError, match=told):
        vp.steady_state(vp.Exciter.from_physical(m="0.35 kg", C="6 N/mm", l="4 mm", **given))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("m_e: 50 g, ", ""), "physical.e: must be left out unless m_e stands beside it"),
        (("50 g", "400 g"), "physical.m_e: must not exceed m, of which it is a part, got '400 g'"),
        (
            ("l: 1 mm", "l: 1 mm, M: 1 kg, D1: 1 N, D2: 1 N"),
            "scenes.speeds.physical.shaker: must be 0 where",
        ),
        (
            ("{e: 3 mm}\n    over: {", "{e: 3 mm}\n    over: {shaker: [1 mm], "),
            "e: must be left out, since shaker is swept",
        ),
    ],
)
def test_what_a_study_says_of_an_unbalance_that_cannot_be(tmp_path, change, told):
    tmp_path.joinpath("unbalance.yaml").write_text(STUDY.replace(*change))
    with pytest.raises(StudyError) as error:
        load_study(tmp_path / "unbalance.yaml")
    assert told in str(error.value)


def test_what_reaches_the_frame_is_not_told_of_a_shaken_one():
    """On a shaken frame acts -(x'' + y''), on that of an exciter with the same f: -x''."""
    row = vp.steady_state(TWO_SIDED, outputs=("harmonics", "impacts", "frame", "sensitivity"))
    same = vp.steady_state(forced(TWO_SIDED), outputs=("harmonics", "impacts", "frame"))
    for name in ("rms", "max", "amplitude", "phase", "amplitude_sensitivity"):
        assert np.isnan(row[f"frame_force_{name}"]).all()
    for name in ("frame_force_mean", "impulse_per_period", "impact_impulse"):
        np.testing.assert_array_equal(row[name], same[name])
    with pytest.raises(vp.ParameterError, match="shaker: must be 0 where mass_ratio > 0"):
        replace(TWO_SIDED, mass_ratio=0.5, housing_friction_1=0.1, housing_friction_2=0.1)


def test_a_study_has_an_unbalance_in_all_of_its_scenes(tmp_path):
    """The force of each row is m_e e omega^2, also where m_e stands in the study and another e in the scene."""
    tmp_path.joinpath("unbalance.yaml").write_text(STUDY)
    scenes = load_study(tmp_path / "unbalance.yaml").scenes
    speeds, line = (kind_of(scene).solve(scene) for scene in scenes.values())
    for found, n in ((speeds, 3), (line, -1)):
        row = found.isel(omega=n) if "omega" in found.dims else found.isel(point=n)
        omega = float(row["omega"])
        given = {"m": 0.35, "C": 6000.0, "H": 4.0, "l": 0.001, "R1": 0.7, "R2": 0.6}
        plain = vp.Exciter.from_physical(**given, F=0.05 * 0.003 * omega**2, omega=omega)
        settled = vp.to_physical(vp.steady_state(plain), 0.35, 6000.0)
        np.testing.assert_allclose(
            row["impact_velocity_max"], settled["impact_velocity_max"], rtol=1e-9
        )
        assert float(row["shaker"]) == pytest.approx(0.05 * 0.003 / 0.35, rel=1e-12)
    assert speeds["power_input"].attrs["units"] == "W"


@pytest.mark.parametrize("other", [{"shaker": 2.0}, {"f2": 3.0, "f": 0.1}, {"load": 0.2, "f": 1.0}])
def test_acceleration_is_within_the_bound_by_which_jumps_are_told(other):
    motion = vp.simulate(vp.Exciter(l=0.5, nu=1.5, h=0.1, R1=0.7, R2=0.6, **other), 30.0)
    p = motion.coords
    first = float(p["f"]) + float(p.get("shaker", 0.0)) * 1.5**2
    force = first * np.sin(1.5 * motion["tau"])
    force = (
        force
        + float(p.get("f2", 0.0)) * np.sin(2 * 1.5 * motion["tau"])
        + float(p.get("load", 0.0))
    )
    largest = float(np.abs(force - 0.1 * motion["velocity"] - motion["displacement"]).max())
    assert 0.5 * acceleration_bound(motion) < largest <= acceleration_bound(motion)
    assert "force" in panel_names(motion)


def test_the_mirrored_exciter_has_the_opposite_force():
    mirrored = TWO_SIDED.mirrored()
    assert (mirrored.numbers().f, mirrored.shaker, float(mirrored.f)) == (
        -0.1,
        -0.5,
        -float(TWO_SIDED.f),
    )
    assert mirrored.mirrored() == TWO_SIDED
    one_sided = vp.Exciter(l=0.5, h=0.1, R2=0.6, delta=0.3, nu=1.0, f=0.1, shaker=0.15)
    here, same = (vp.one_sided_orbit(each, 2, 1) for each in (one_sided, forced(one_sided)))
    for name in ("impact_velocity", "impact_phase"):
        np.testing.assert_allclose(here[name], same[name], rtol=1e-13)


@pytest.mark.parametrize("exciter", [TWO_SIDED, SOFT])
def test_errors_of_a_motion_are_those_under_the_same_force(exciter):
    here, same = (vp.simulate(each, 60.0, accuracy=1e-6) for each in (exciter, forced(exciter)))
    assert here.attrs["method"] == same.attrs["method"]
    np.testing.assert_array_equal(here["displacement"], same["displacement"])
    found, expected = (each["displacement_error"].max() for each in (here, same))
    assert float(expected) / 3 < float(found) < 3 * float(expected)


def test_attractors_are_followed_along_the_force():
    """Over f the numbers of attractors are those of the whole force, without a jump between them."""
    exciter = replace(TWO_SIDED, f=0.0)
    starts = {"x0": [-0.3, 0.0, 0.3], "v0": [-0.5, 0.5]}
    here = vp.basins(exciter, **starts, over={"f": [0.0, 0.02, 0.04]})
    same = vp.basins(forced(exciter), **starts, over={"f": [0.72, 0.74, 0.76]})
    np.testing.assert_array_equal(here["attractor"], same["attractor"])


def test_a_representation_is_what_was_given():
    given = vp.Exciter(l=0.5, nu=1.3, f=0.8, h=0.15, R1=0.7, shaker=0.1)
    assert "f=0.8," in repr(given)
    soft = vp.Exciter(l=0.5, k1=100.0, R1=0.7, shaker=0.1)  # nu and h1 are left out
    tied = vp.Exciter(l=0.5, nu=1.3, shaker=0.1, ties={"f": "2 * nu"})
    for exciter in (given, soft, tied):
        again = eval(f"vp.{exciter!r}")
        assert again == exciter
        assert again.numbers() == exciter.numbers()
        assert [again.states(name) for name in ("nu", "h1")] == [
            exciter.states(name) for name in ("nu", "h1")
        ]


def test_a_force_without_frequency_is_refused():
    with pytest.raises(vp.ParameterError, match="nu: is required beside"):
        vp.steady_state(vp.Exciter(l=0.5, shaker=0.1))
    with pytest.raises(vp.ParameterError, match="shaker: must be 0"):
        vp.symmetric_orbit_boundaries(vp.Exciter(l=0.5, nu=1.0, shaker=0.1), [1.0, 1.2])
