"""A bad start or argument is rejected by a message with its name, its value and the valid values."""

from __future__ import annotations

import inspect
import math
import pickle
from typing import Any

import pytest
import yaml

import vibropipe as vp
from vibropipe.study import StudyError, parse_study


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("x0", 0.6),
        ("x0", -0.5000001),
        ("x0", math.nan),
        ("v0", math.inf),
        ("tau_end", math.nan),
        ("tau_end", -1.0),
        ("tau_end", math.inf),
        ("method", "euler"),
        ("steps_per_period", 0),
        ("samples_per_period", -1),
    ],
)
def test_a_bad_argument_is_named_with_its_value(name: str, value: Any) -> None:
    settings = {"method": "newmark", "steps_per_period": 100, name: value}
    with pytest.raises(ValueError, match=name) as error:
        vp.simulate(vp.Exciter(l=0.5), **settings)
    assert str(value) in str(error.value)


# A step whose force is computed counts as four, and many steps of a period have no table.
@pytest.mark.parametrize(
    ("solver", "most"),
    [({}, r"6e\+08"), ({"method": "newmark", "steps_per_period": 10**6}, r"1\.5e\+08")],
)
def test_a_march_that_would_take_days_is_refused(solver: dict[str, Any], most: str) -> None:
    exciter = vp.Exciter(l=0.5, nu=1e4, f=2.0, h=0.1)
    with pytest.raises(
        vp.ParameterError,
        match=f"tau_end: must be reached in at most {most} steps of the march, got 1000000000.0 with "
        r"\S+ steps",
    ):
        vp.simulate(exciter, tau_end=1e9, v0=2.0, samples_per_period=0, **solver)


def test_newmark_without_a_step_says_so() -> None:
    told = (
        r"steps_per_period: is required \(a whole number from 1 to 1e8\), since method is newmark$"
    )
    with pytest.raises(vp.ParameterError, match=told):
        vp.simulate(vp.Exciter(l=0.5), method="newmark")


@pytest.mark.parametrize("follow", ["nu", ("nu",), ("nu", "up", "down"), 1])
def test_follow_is_a_pair(follow: Any) -> None:
    with pytest.raises(
        vp.ParameterError, match=r"follow: must be a pair of a swept parameter and a .*, got "
    ):
        vp.sweep(vp.Exciter(l=0.5, h=0.1), {"nu": [0.8, 0.9]}, follow=follow)


@pytest.mark.parametrize("accuracy", [9e-16, 0.11])
def test_python_and_studies_have_the_same_limits(accuracy: float) -> None:
    """... of which there is one place."""
    with pytest.raises(
        vp.ParameterError, match=r"accuracy: must be a number from 1e-15 to 0.1, got "
    ):
        vp.simulate(vp.Exciter(l=0.5), accuracy=accuracy)
    with pytest.raises(vp.ParameterError, match="from 1 to 1e8"):
        vp.simulate(vp.Exciter(l=0.5), method="newmark", steps_per_period=10**9)
    scene = f"s: {{kind: motion, solver: {{accuracy: {accuracy!r}}}}}"
    steps = "t: {kind: motion, solver: {method: newmark, steps_per_period: 1000000000}}"
    tree = yaml.safe_load(f"title: t\nexciter: {{l: 0.5}}\nscenes:\n  {scene}\n  {steps}\n")
    with pytest.raises(StudyError) as error:
        parse_study(tree)
    assert "a number from 1e-15 to 0.1" in str(error.value)
    assert "a whole number from 1 to 1e8" in str(error.value)


def test_a_start_outside_the_supports_is_refused_for_steady_states_too() -> None:
    with pytest.raises(vp.ParameterError, match="x0"):
        vp.steady_state(vp.Exciter(l=0.5, delta=0.7), x0=0.0)


@pytest.mark.parametrize(
    ("call", "name", "hint"),
    [
        (vp.sweep, "zeta", ""),
        (vp.branch, "lyapunv", ""),
        (vp.steady_state, "harmonic", " (did you mean 'harmonics'?)"),
        (vp.simulate, "tau_ende", " (did you mean 'tau_end'?)"),
        (vp.load, "folder", ""),
    ],
)
def test_an_unknown_keyword_of_a_call_is_told_with_what_may_be_meant(call, name, hint) -> None:
    with pytest.raises(vp.ParameterError) as error:
        call(vp.Exciter(l=0.5), **{name: 1})
    text = str(error.value)
    assert text.startswith(f"{name}: is an unknown argument; must be one of ")
    assert text.endswith(hint)
    # the face keeps signatures, and finds itself in other processes
    assert name not in inspect.signature(call).parameters
    assert pickle.loads(pickle.dumps(call)) is call


@pytest.mark.parametrize(
    ("call", "given", "told"),
    [
        (vp.steady_state, {"nu": 1.2, "f": 0.8}, "nu: must be given to the exciter, as vp.Exciter(nu=..., f=...)"),
        (vp.simulate, {"x0": 0.1, "nu": 1.2}, "nu: must be given to the exciter, as vp.Exciter(nu=...)"),
        (vp.boundary, {"l": "8 mm", "C": 5.0},
         "l: must be given to the exciter, as vp.Exciter.from_physical(l=..., C=...)"),
        (vp.simulate, {"ties": {"R2": "R1"}}, "ties: must be given to the exciter, as vp.Exciter(ties=...)"),
        (vp.load, {"nu": 1.2}, "nu: is an unknown argument; must be one of "),
    ],
)  # fmt: skip
def test_parameters_in_place_of_an_exciter_are_told_where_they_belong(call, given, told) -> None:
    with pytest.raises(vp.ParameterError) as error:
        call(**given)
    assert str(error.value).startswith(told)


E, X, MEASURED = vp.Exciter(l=0.5, h=0.1), [0.1, 0.2], {"nu": [1.0], "displacement_mean": [0.1]}
A_MAPPING = "must be a mapping of names to values, as {name: value}"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vp.steady_state({"l": 0.5}), "exciter: must be an exciter, as vp.Exciter(l=0.5), got {'l': 0.5}"),
        (lambda: vp.simulate(None), "exciter: must be an exciter, as vp.Exciter(l=0.5), got None"),
        (lambda: vp.one_sided_orbit(3), "exciter: must be an exciter, as vp.Exciter(l=0.5), got 3"),
        (lambda: vp.identify(3, MEASURED, {"f": (0, 1)}), "exciter: must be an exciter, as vp.Exciter(l=0.5), got 3"),
        (lambda: vp.sweep(E, ["nu"]), f"over: {A_MAPPING}, got ['nu']"),
        (lambda: vp.tolerance(E, ["f"]), f"tolerances: {A_MAPPING}, got ['f']"),
        (lambda: vp.tolerance(E, {"f": 0}), "tolerances.f: must be a finite number > 0, got 0.0"),
        (lambda: vp.tolerance(E, {}), "tolerances: must have at least one parameter, got {}"),
        (lambda: vp.design(E, {"f": (0, 1)}, "displacement_mean"), f"target: {A_MAPPING}, got 'displacement_mean'"),
        (lambda: vp.design(E, {"l": (1, 2)}, minimise={"f": 1}), "minimise: must be text or a list, got {'f': 1}"),
        (lambda: vp.design(E, {"l": (1, 2)}, minimise=["velocity_mean"] * 2),
         "minimise: must be quantities that differ from each other, got ['velocity_mean', 'velocity_mean']"),
        (lambda: vp.identify(E, MEASURED, {"f": (0, 1)}, noise=0.1), f"noise: {A_MAPPING}, got 0.1"),
        (lambda: vp.identify(E, {**MEASURED, "nu": ["8 Hz"]}, {"f": (0, 1)}),
         "measured: must have numbers in its columns, and units in their heads, as 'displacement (mm)', "
         "got '8 Hz' in nu"),
        (lambda: vp.prove(E, within=0.1), f"within: {A_MAPPING}, got 0.1"),
        (lambda: vp.sweep(E, {"nu": [1.0]}, ties=3), f"ties: {A_MAPPING}, got 3"),
        (lambda: vp.basins(E, X, X, over=["nu"]), f"over: {A_MAPPING}, got ['nu']"),
        (lambda: vp.branch(E, "nu", 1.5, at=1.4), "at: must be a list, got 1.4"),
        (lambda: vp.branch(E, "nu", 1.5, at="1.4"), "at: must be a list, got '1.4'"),
        (lambda: vp.simulate(E, effects="damping"), "effects: must be a list, got 'damping'"),
        (lambda: vp.sweep(E, {"nu": [1.0]}, outputs=None), "outputs: must be a list, got None"),
        (lambda: vp.simulate(E, energy="yes"), "energy: must be True or False, got 'yes'"),
        (lambda: vp.table(E), "dataset: must be a dataset, a tree of datasets, text or a path, got Exciter"),
        (lambda: vp.to_physical(E, E), "dataset: must be a dataset or a tree of datasets, got Exciter"),
        (lambda: vp.load(3), "path: must be text or a path, got 3"),
        (lambda: vp.boundary(E, "fold", 3, [X, X]), "along: must be two of nu, "),
    ],
)  # fmt: skip
def test_an_argument_of_another_type_is_told(call, message):
    with pytest.raises(vp.ParameterError) as error:
        call()
    assert str(error.value).startswith(message)


@pytest.mark.parametrize("force", ["f", "f2"])
def test_a_force_that_only_scatters_needs_a_frequency(force: str) -> None:
    still, told = vp.Exciter(l=0.5, h=0.1), f"^nu: is required beside {force} "
    with pytest.raises(vp.ParameterError, match=told):
        vp.tolerance(still, {force: 0.01})
    with pytest.raises(vp.ParameterError, match=told):
        vp.design(still, {"h": (0.1, 0.2)}, minimise="displacement_mean", tolerance={force: 0.01})
    scene = f"kind: design, vary: {{h: [0.1, 0.2]}}, minimise: displacement_mean, tolerance: {{{force}: 0.01}}"
    with pytest.raises(StudyError, match=r"exciter\.nu: is required"):
        parse_study(yaml.safe_load(f"title: t\nexciter: {{l: 0.5}}\nscenes: {{s: {{{scene}}}}}"))
