"""Datasets of every kind, made here without the solvers: by a slow march and by closed forms."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibropipe.scenes.keys.parts import FigureOptions
from vibropipe.scenes.registry import kinds
from vibropipe.words.measurements import Outcome, Passed
from vibropipe.words.quantities import REGIMES
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import describe


@dataclass
class Scene:
    kind: str
    name: str = "scene"
    title: str = "A scene"
    caption: str = ""
    figure: FigureOptions | None = None
    mass_and_stiffness: None = None

    def __post_init__(self):
        field = kinds()[self.kind].keys.model_fields["figure"]
        self.figure = self.figure or field.get_default(call_default_factory=True)

    def data_keys(self):
        return {"kind": self.kind}

    def warning(self) -> str:
        """Return nothing: its study has no units."""
        return ""


def march(exciter, x=0.0, v=0.0, tau_end=40.0, keep=10):
    """March with a small step and the crude impact at its end: good enough to be looked at."""
    nu, f, h = exciter["nu"], exciter["f"], exciter["h"]
    upper, lower = exciter["l"] + exciter["delta"], exciter["delta"] - exciter["l"]
    R1, R2 = exciter["R1"], exciter["R2"]
    step = 2e-3
    taus, xs, vs, impacts = [], [], [], []
    for n in range(int(tau_end / step) + 1):
        tau = n * step
        if n % keep == 0:
            taus.append(tau), xs.append(x), vs.append(v)
        v += step * (f * np.sin(nu * tau) - h * v - x)
        x += step * v
        for support, out, R in ((1, x > upper and v > 0, R1), (2, x < lower and v < 0, R2)):
            if out:
                x = upper if support == 1 else lower
                impacts.append((tau + step, support, v, -R * v))
                v = -R * v
    found = np.array(impacts).reshape(-1, 4)
    return np.array(taus), np.array(xs), np.array(vs), found


def motion(exact=False, rest=False, grazing=False, **given) -> xr.Dataset:
    exciter = {"nu": 1.0, "f": -1.0, "h": 0.2, "l": 0.5, "delta": 0.0, "R1": 0.7, "R2": 0.7}
    start = {k: given.pop(k) for k in ("x", "v", "tau_end") if k in given}
    exciter |= given
    tau, x, v, impacts = march(exciter, **start)
    data = {
        "displacement": ("tau", x),
        "velocity": ("tau", v),
        "force": ("tau", exciter["f"] * np.sin(exciter["nu"] * tau)),
        "impact_tau": ("impact", impacts[:, 0]),
        "impact_support": ("impact", impacts[:, 1].astype(np.int8)),
        "impact_velocity": ("impact", impacts[:, 2]),
        "impact_velocity_after": ("impact", impacts[:, 3]),
        "rest_start": ("rest", np.array([10.0] if rest else [])),
        "rest_end": ("rest", np.array([12.5] if rest else [])),
        "rest_support": ("rest", np.array([1] if rest else [], np.int8)),
        "grazing_tau": ("grazing", np.array([4.71, 10.2] if grazing else [])),
        "grazing_support": ("grazing", np.array([1, 1] if grazing else [], np.int8)),
        "displacement_end": x[-1],
        "velocity_end": v[-1],
        "status": np.int8(Status.OK),
    }
    if exact:
        data |= {"displacement_exact": ("tau", x + 1e-3), "velocity_exact": ("tau", v + 1e-3)}
    attrs = {"method": "newmark"} if exact else {"method": "exact"}
    return describe(xr.Dataset(data, {"tau": tau, **exciter}, attrs))


def steady(bias=0.0, **given) -> xr.Dataset:
    """Return a motion that carries its steady state; ``bias`` makes it unsymmetric."""
    dataset = motion(exact=True, **given)
    amplitude = np.array([0.32, abs(bias), 0.12])
    extra = {
        "regime": np.int8(REGIMES["two_sided"]),
        "period_multiple": np.int32(1),
        "impacts_per_orbit": ("support", np.array([1.0, 1.0])),
        "rests_per_orbit": ("support", np.array([0.0, 0.0])),
        "base_frequency": 1.0,
        "residual": 1e-15,
        "displacement_mean": -bias,
        "velocity_mean": 0.0,
        "displacement_amplitude": ("harmonic", amplitude),
        "velocity_amplitude": ("harmonic", amplitude * [1, 2, 3]),
        "orbit_impact_phase": ("orbit_impact", np.array([0.26, 0.76])),
        "orbit_impact_support": ("orbit_impact", np.array([2, 1], np.int8)),
        "orbit_impact_velocity": ("orbit_impact", np.array([-0.89 - bias, 0.89 - bias])),
        "floquet_multiplier": ("multiplier", np.array([0.35 + 0.01j, 0.195 - 0.01j])),
        "stable": np.int8(1),
    }
    return describe(dataset.assign(extra).assign_coords(support=[1, 2], harmonic=[1, 2, 3]))


def backbone() -> xr.Dataset:
    ratio = np.array([0.0, 0.1, 0.2, 0.3])
    tau_bar = np.linspace(1.0, 2 * np.pi, 200)

    def law(d, period):
        return (1 - d + (1 + d) * np.cos(period / 2)) / np.sin(period / 2)

    velocity = law(ratio[:, None], tau_bar[None, :])
    velocity[velocity < 0] = np.nan
    points = np.tile(np.linspace(1.2, 4.0, 6), (4, 1))
    return describe(
        xr.Dataset(
            {
                "velocity_over_l": (("delta_over_l", "tau_bar"), velocity),
                "omega_bar": ("tau_bar", 2 * np.pi / tau_bar),
                "simulated_tau_bar": (("delta_over_l", "point"), points),
                "simulated_velocity_over_l": (
                    ("delta_over_l", "point"),
                    law(ratio[:, None], points),
                ),
            },
            {"delta_over_l": ratio, "tau_bar": tau_bar},
        )
    )


def amplitude_frequency(delta=0.01) -> xr.Dataset:
    """Return the free motion of any amplitude, its harmonics by sampling one period."""
    upper, lower = 0.5 + delta, 0.5 - delta
    amplitude = np.concatenate([np.linspace(0.02, lower, 30), np.geomspace(lower, 1.0, 400)])
    rows = []
    for A in amplitude:
        top, bottom = min(A, upper), max(-A, -lower)
        half = np.arccos(bottom / A) - np.arccos(top / A)
        angle = np.arccos(top / A) + half * (np.arange(512) + 0.5) / 512
        x = np.concatenate([A * np.cos(angle), A * np.cos(angle[::-1])])
        v = np.concatenate([-A * np.sin(angle), A * np.sin(angle[::-1])])
        X, V = np.abs(np.fft.rfft(x))[:4] / 512, np.abs(np.fft.rfft(v))[:4] / 512
        both, one, none = Regime.TWO_SIDED, Regime.ONE_SIDED_2, Regime.NO_IMPACT
        regime = both if upper < A else one if lower < A else none
        rows.append((np.pi / half, x.mean(), X, V, regime))
    frequency, mean, X, V, regime = map(np.array, zip(*rows, strict=True))
    return describe(
        xr.Dataset(
            {
                "eigenfrequency": ("amplitude", frequency),
                "regime": ("amplitude", regime.astype(np.int8)),
                "displacement_mean": ("amplitude", mean),
                "velocity_mean": ("amplitude", np.zeros_like(mean)),
                "displacement_amplitude": (("amplitude", "harmonic"), X[:, 1:]),
                "velocity_amplitude": (("amplitude", "harmonic"), V[:, 1:]),
            },
            {"amplitude": amplitude, "harmonic": [1, 2, 3], "l": 0.5, "delta": delta, "nu": 1.0,
             "f": 0.0, "h": 0.0, "R1": 1.0, "R2": 1.0},
        )
    )  # fmt: skip


def sweep(points=121, all_regimes=False, **over) -> xr.Dataset:
    """Return a made-up sweep over nu and further parameters with bands of every regime."""
    grids = {"nu": np.linspace(0.3, 3.0, points), **{k: np.asarray(v) for k, v in over.items()}}
    coords = dict(grids)
    shape = tuple(g.size for g in grids.values())
    dims = tuple(grids)
    nu, second = np.broadcast_arrays(
        grids["nu"].reshape(-1, *[1] * (len(dims) - 1)),
        np.broadcast_to(grids[dims[-1]] if len(dims) > 1 else np.array(1.0), shape),
    )
    peak = np.clip(second / np.hypot(1 - nu**2, 0.2 * nu), 0, 0.5)
    regime = np.where(peak >= 0.5, int(Regime.TWO_SIDED), int(Regime.NO_IMPACT))
    regime[(peak > 0.45) & (peak < 0.5)] = Regime.ONE_SIDED_2
    regime[(peak > 0.40) & (peak < 0.45)] = Regime.ONE_SIDED_1
    regime[(nu > 2.6)] = Regime.APERIODIC
    if all_regimes:
        regime[nu < 0.45] = Regime.WITH_REST
        regime[(nu > 2.2) & (nu < 2.4)] = Regime.UNBOUNDED
        regime[(nu > 2.4) & (nu < 2.6)] = Regime.UNRESOLVED
    multiple = np.where((nu > 1.9) & (nu < 2.1), 2, 1)
    multiple[regime >= Regime.APERIODIC] = 0
    amplitude = np.stack([peak, 0.2 * peak**2, 0.35 * peak], axis=-1)
    amplitude[regime == Regime.UNBOUNDED] = np.nan
    velocity = np.stack([2 * peak * nu, 2.2 * peak * nu], axis=-1)
    velocity[..., 0][np.isin(regime, [Regime.NO_IMPACT, Regime.ONE_SIDED_2])] = np.nan
    velocity[..., 1][np.isin(regime, [Regime.NO_IMPACT, Regime.ONE_SIDED_1])] = np.nan
    fixed = {"nu": 1.0, "f": 1.0, "h": 0.2, "l": 0.5, "delta": 0.0, "R1": 0.7, "R2": 0.7}
    coords |= {k: v for k, v in fixed.items() if k not in dims}
    return describe(
        xr.Dataset(
            {
                "regime": (dims, regime.astype(np.int8)),
                "period_multiple": (dims, multiple.astype(np.int32)),
                "stable": (dims, ((nu < 1.15) | (nu > 1.25)).astype(np.int8)),
                "displacement_mean": (
                    dims,
                    np.where(regime == Regime.UNBOUNDED, np.nan, -0.1 * peak),
                ),
                "displacement_amplitude": ((*dims, "harmonic"), amplitude),
                "impact_velocity_max": ((*dims, "support"), velocity),
                "residual": (dims, np.full(shape, 1e-14)),
            },
            {**coords, "harmonic": [1, 2, 3], "support": [1, 2]},
            {"method": "exact"},
        )
    )


def hard_cases() -> xr.Dataset:
    """Return four cases by three solvers: passed, exactly right, not for all, not passed."""
    grid = ("case", "solver")
    no, yes, not_asked = Passed
    measured = np.array([[2e-15, 0.04, 8e-4], [0, 0, 0], [3e-11, np.nan, np.nan], [0.5, np.inf, 1]])
    bound = np.array([[1e-12, 0.06, 1e-3], [0, 0, 0], [1e-9, np.nan, np.nan], [1e-3, 1.0, 0]])
    data = {
        "asked": ("case", np.array(["chatter, R = 0.5", "a start", "an orbit", "a graze"])),
        "known": ("case", np.array(["its series", "one impact", "its velocity", "wrong of 20"])),
        "measured": (grid, measured),
        "bound": (grid, bound),
        "passed": (
            grid,
            np.array([[yes] * 3, [yes] * 3, [yes, not_asked, not_asked], [no] * 3], np.int8),
        ),
        "worst_status": (
            grid,
            np.array([[Status.OK, Status.SHORT_FLIGHTS, Status.OK]] * 4, np.int8),
        ),
        "motions": (grid, np.full((4, 3), 2)),
        "impacts": (grid, np.full((4, 3), 50)),
        "short_flight_motions": (grid, np.array([[0, 1, 0]] * 4)),
    }
    data |= {
        "case_group": ("case", np.array(["chatter", "contact", "labels", "contact"])),
        "reason": (
            "case",
            np.array(["each flight rounded", "yes or no", "rounding times 10⁴", "yes or no"]),
        ),
        "group_known": ("group", np.array(["its series", "struck or not", "its law"])),
    }
    names = ["chatter_complete", "start_on_support", "slow_drift", "grazing_free"]
    coords = {
        "case": names,
        "solver": ["exact", "newmark 8", "newmark 60"],
        "group": ["chatter", "contact", "labels"],
    }
    attrs = {
        "method": "exact, newmark 8, newmark 60 steps per forcing period",
        "distinct_motions": 12,
        "energy_steps": 60,
        "steps": 1024,
    }
    return describe(xr.Dataset(data, coords, attrs))


def failures() -> xr.Dataset:
    """Return hard cases with the four questions, each at two or three values: where common methods fail."""
    ok, lost, ended, none = (
        Outcome.OK, Outcome.MISSED_IMPACT, Outcome.DID_NOT_END, Outcome.NOT_TRIED,
    )  # fmt: skip
    nan = np.nan
    methods = ["crude", "newmark", "DOP853", "DOP853_loose", "DOP853_short", "exact", "closed"]
    energy = [
        [1e-3, nan, nan], [1e-15, 1e-13, 2e-9], [1e-10, 1e-9, nan], [1e-5, 1e-3, nan], [nan] * 3,
        [1e-15, 1e-14, 4.21e-10], [0.0, 0, 0],
    ]  # fmt: skip
    energy_outcome = [
        [ok, ended, ended], [ok] * 3, [ok, ok, ended], [ok, ok, ended], [none] * 3, [ok] * 3, [ok] * 3,
    ]  # fmt: skip
    grazing = [
        [1e-2, 0.9, nan], [1e-14, 1e-10, 1e-7], [1e-10, nan, nan], [nan] * 3, [1e-14, 1e-10, 1e-7],
        [1e-14, 1e-10, 1e-7], [nan] * 3,
    ]  # fmt: skip
    grazing_outcome = [
        [ok, ok, lost], [ok] * 3, [ok, lost, lost], [none] * 3, [ok] * 3, [ok] * 3, [none] * 3,
    ]  # fmt: skip
    chatter = [
        [1e-2, nan], [3e-6, 3e-6], [0.023, 0.01], [nan] * 2, [nan] * 2, [1e-15, 2.24e-14], [nan] * 2,
    ]  # fmt: skip
    chatter_outcome = [
        [ok, ended], [ok] * 2, [ended] * 2, [none] * 2, [none] * 2, [ok] * 2, [none] * 2,
    ]  # fmt: skip
    steps = np.full((7, 2), nan)
    steps[:3], steps[5, 0] = [[16, 64], [16, 64], [6, 40]], 14
    errors = np.full((7, 2), nan)
    errors[:3], errors[5, 0] = [[0.4, 0.1], [3e-2, 2e-3], [3e-4, 1e-12]], 2e-15
    data = {
        "energy_error": (("method", "impact_count"), np.array(energy)),
        "energy_outcome": (("method", "impact_count"), np.array(energy_outcome, np.int8)),
        "grazing_error": (("method", "depth"), np.array(grazing)),
        "grazing_outcome": (("method", "depth"), np.array(grazing_outcome, np.int8)),
        "chatter_error": (("method", "restitution"), np.array(chatter)),
        "chatter_outcome": (("method", "restitution"), np.array(chatter_outcome, np.int8)),
        "step_count": (("method", "setting"), steps),
        "step_error": (("method", "setting"), errors),
    }
    coords = {
        "method": methods, "impact_count": [1, 10, 1_000_000], "depth": [1e-2, 1e-6, 1e-9],
        "restitution": [0.1, 0.9],
    }  # fmt: skip
    return hard_cases().assign(describe(xr.Dataset(data, coords)).variables)
