"""A record over time as a function of the parameters: orbits at the phase and the offsets that fit it best."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.stiffness import lets_go
from vibropipe.solve.fit.curve_fit import OUTPUTS, OrbitCurve, orbit_curve
from vibropipe.solve.fit.fit_model import BLOCK, Measured, Model
from vibropipe.solve.fit.record import Record
from vibropipe.solve.rows.named import Named
from vibropipe.solve.rows.points import solve_points
from vibropipe.words.outputs import OUTPUTS as ALL_OUTPUTS
from vibropipe.words.parameters import MIRRORED
from vibropipe.words.sensors import TAU

# Bins of a forcing period among which the phase is sought; steps of its refinement, and those where samples of the
# ranges are compared; their end in forcing periods, and the width of its differences.
BINS, STEPS, FEW_STEPS, STEP_END, DIFFERENCE = 64, 10, 2, 1e-10, 1e-7
# A velocity below this, relative to the largest, is one of a mass at rest.
REST = 1e-7
# Tied parameters are mirrored within rounding.
ROUNDING = 1e-12


class RowFit(NamedTuple):
    """The best fit of one orbit to a record.

    values : (n, q), what the sensors show; NaN within the blanking of an impact, and everywhere without an orbit
    phase : (n,), of each sample, in forcing periods from the start of the orbit
    offsets, signs : (q,), of the sensors
    """

    values: np.ndarray
    phase: np.ndarray
    offsets: np.ndarray
    signs: np.ndarray


@dataclass(frozen=True)
class RecordModel(Model):
    """The values of sensors as functions of the parameters; phase, offsets and signs are those that fit best.

    blanked : (n,), samples next to an impact; None for those of each orbit
    """

    record: Record
    blanked: np.ndarray | None = None
    # Which samples impacts blank changes from step to step, and with it the misfit in its last digits.
    TOLERANCE: ClassVar[float] = 1e-9

    def _solve(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        fits, laws = self.fits(rows)
        return np.stack([fit.values for fit in fits]), laws

    def costs(self, points: np.ndarray) -> np.ndarray:
        """Return sums of squared misfits (n,) at values (n, k) of the parameters, each with a roughly fitted phase."""
        parts = []
        block = max(1, BLOCK // self.data.values.size)
        for n in range(0, len(points), block):
            fits, _laws = self.fits(self.rows(points[n : n + block]), FEW_STEPS)
            misfits = self.misfits(np.stack([fit.values for fit in fits]))
            parts.append((misfits**2).sum(axis=(1, 2)))
        return np.concatenate(parts)

    def fits(self, rows: np.ndarray, steps: int = STEPS) -> tuple[list[RowFit], np.ndarray]:
        """Return the fit of each row of all parameters (n, p), and the laws of motion (n, 1, 4); none without a tie."""
        is_known = np.isfinite(rows).all(axis=1)
        rows = np.where(is_known[:, None], rows, self.exciter.numbers())
        wanted = tuple(name for name in ALL_OUTPUTS if name in {*OUTPUTS, "stability"})
        solved = solve_points(rows, (self.x0, self.v0), wanted, 1)
        m = solved.variables["period_multiple"][1]
        fits = [
            self._fit(orbit_curve(solved.variables, row, n), steps)
            if is_known[n] and m[n] > 0
            else self._absent()
            for n, row in enumerate(rows)
        ]
        return fits, solved.laws[:, None, :]

    def fit_at(self, point: np.ndarray) -> RowFit:
        """Return the fit at values (k,) of the parameters."""
        return self.fits(self.rows(point[None]))[0][0]

    def misfits(self, values: np.ndarray) -> np.ndarray:
        """Return weighted misfits (n, rows, q): 0 of clipped samples; of blanked ones 1, the misfit of noise alone."""
        record = self.record
        misfits = (values - record.values) * self.data.weights
        is_lost = np.isnan(values).all(axis=(1, 2), keepdims=True)
        misfits = np.where(
            np.isnan(values), np.where(is_lost, self.absent * self.data.weights, 1.0), misfits
        )
        return np.where(record.is_clipped, 0.0, misfits)

    def frozen_at(self, point: np.ndarray) -> RecordModel | None:
        """Return the model in which impacts blank the samples that they do at values (k,) of the parameters.

        The misfit changes by jumps where impacts pass samples, so that a search in the noise ends too soon.
        """
        is_blanked = np.isnan(self.fit_at(point).values)
        is_partly = is_blanked.any() and not is_blanked.all()
        return replace(self, blanked=is_blanked.any(axis=1)) if is_partly else None

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivatives (rows * q, k) of the weighted misfits, where the same samples count."""
        frozen = self.frozen_at(point) if self.blanked is None else None
        return super().jacobian(point) if frozen is None else frozen.jacobian(point)

    def _absent(self) -> RowFit:
        n, q = self.record.values.shape
        lost = np.full((n, q), np.nan)
        return RowFit(lost, lost[:, 0], lost[0], lost[0])

    def _fit(self, curve: OrbitCurve, steps: int) -> RowFit:
        record = self.record
        counted = curve.parameters.nu * (record.tau - record.middle) / (2 * np.pi)
        if record.phase is None:
            shift = self._refined(curve, counted, self._coarse(curve, counted), steps)
        else:
            shift = known = min(
                (record.phase + turn for turn in range(curve.m)),
                key=lambda each: self._linear(curve, counted + each)[0],
            )
            if record.phase_slack:
                slack = curve.parameters.nu * record.phase_slack / (2 * np.pi)
                shift = self._refined(curve, counted, known, steps)
                shift = min(max(shift, known - slack), known + slack)
        _cost, values, offsets, signs = self._linear(curve, counted + shift)
        return RowFit(values, (counted + shift) % curve.m, offsets, signs)

    def _sensed(self, curve: OrbitCurve, phase: np.ndarray) -> np.ndarray:
        """Return what sensors without offset show (n, q) at phases; NaN within the blanking of an impact."""
        columns, (x, v) = [], curve.at(phase)
        is_blanked = self.blanked
        if is_blanked is None or is_blanked.size != phase.size:
            is_blanked = _blanked(curve, phase, self.record.blanking)
        for name in self.record.columns:
            if name == "displacement":
                columns.append(x)
                continue
            own = v if name == "velocity" else acceleration(curve, phase, x, v)
            columns.append(np.where(is_blanked, np.nan, own))
        return np.column_stack(columns)

    def _linear(
        self, curve: OrbitCurve, phase: np.ndarray
    ) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
        """Return cost, values (n, q), offsets (q,) and signs (q,) of sensors at phases (n,)."""
        sensed, cost = self._sensed(curve, phase), 0.0
        values, offsets, signs = np.empty_like(sensed), [], []
        for q, own in enumerate(sensed.T):
            kept = np.isfinite(own) & ~self.record.is_clipped[:, q]
            data, model = self.record.values[kept, q], own[kept]
            best = np.inf
            for sign in (1.0,) if self.record.is_signed else (1.0, -1.0):
                left = data - sign * model
                offset = float(left.mean()) if left.size else 0.0
                size = float(((left - offset) ** 2).sum())
                if size < best:
                    best, chosen = size, (sign, offset)
            values[:, q] = chosen[0] * own + chosen[1]
            signs.append(chosen[0])
            offsets.append(chosen[1])
            cost += best * self.data.weights[q] ** 2 + np.count_nonzero(np.isnan(own))
        return cost, values, np.array(offsets), np.array(signs)

    def _coarse(self, curve: OrbitCurve, counted: np.ndarray) -> float:
        """Return the phase, among those of bins, that fits best: correlations of binned samples with the orbit."""
        n_bins = BINS * curve.m
        bins = np.floor(counted % curve.m * BINS).astype(int) % n_bins
        sensed = self._sensed(curve, (np.arange(n_bins) + 0.5) / BINS)
        total = np.zeros(n_bins)
        for q, own in enumerate(sensed.T):
            kept, mask = ~self.record.is_clipped[:, q], np.isfinite(own)
            data = self.record.values[kept, q]
            # About the mean, so that no digits are lost to an offset.
            data = data - data.mean()
            sums = [
                np.fft.rfft(np.bincount(bins[kept], weight, n_bins))
                for weight in (np.ones_like(data), data, data**2)
            ]
            own = np.where(mask, own, 0.0)
            shapes = [np.fft.rfft(each) for each in (mask.astype(float), own, own**2)]

            def over(
                a: int, b: int, sums: list[np.ndarray] = sums, shapes: list[np.ndarray] = shapes
            ) -> np.ndarray:
                return np.fft.irfft(np.conj(sums[a]) * shapes[b], n_bins)

            number = np.maximum(over(0, 0), 1.0)
            both = over(1, 1) - over(1, 0) * over(0, 1) / number
            if not self.record.is_signed:
                both = np.abs(both)
            squares = over(2, 0) - over(1, 0) ** 2 / number + over(0, 2) - over(0, 1) ** 2 / number
            total += (squares - 2 * both) * self.data.weights[q] ** 2 + kept.sum() - number
        return float(total.argmin()) / BINS

    def _refined(self, curve: OrbitCurve, counted: np.ndarray, shift: float, steps: int) -> float:
        """Return the phase that fits best next to one, by the method of Gauss and Newton."""
        weights, best = self.data.weights, (np.inf, shift)
        for _ in range(steps):
            cost, values, offsets, signs = self._linear(curve, counted + shift)
            if cost < best[0]:
                best = cost, shift
            there = self._sensed(curve, counted + (shift + DIFFERENCE)) * signs + offsets
            slope = (there - values) / DIFFERENCE * weights
            left = (self.record.values - values) * weights
            is_kept = np.isfinite(slope) & ~self.record.is_clipped
            n_kept = np.maximum(is_kept.sum(axis=0), 1)
            slope, left = np.where(is_kept, slope, 0.0), np.where(is_kept, left, 0.0)
            slope = np.where(is_kept, slope - slope.sum(axis=0) / n_kept, 0.0)
            size = float((slope**2).sum())
            step = float((slope * left).sum()) / size if size > 0.0 else 0.0
            shift += float(np.clip(step, -1.0 / BINS, 1.0 / BINS))
            if abs(step) < STEP_END:
                return shift
        return shift if self._linear(curve, counted + shift)[0] <= best[0] else best[1]


def _blanked(curve: OrbitCurve, phase: np.ndarray, blanking: float) -> np.ndarray:
    """Return which phases (n,) lie within a time of an impact on a rigid support."""
    impacts = np.sort(curve.rigid_impacts)
    if not impacts.size:
        return np.zeros(phase.size, bool)
    around = np.concatenate([[impacts[-1] - curve.m], impacts, [impacts[0] + curve.m]])
    place = phase % curve.m
    after = np.searchsorted(around, place)
    nearest = np.minimum(
        place - around[np.maximum(after - 1, 0)], around[np.minimum(after, around.size - 1)] - place
    )
    return np.asarray(nearest * 2 * np.pi / curve.parameters.nu <= blanking)


def acceleration(curve: OrbitCurve, phase: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return x'' (n,) by eq. (5) with soft supports, load and friction; 0 at rest."""
    p = curve.parameters
    upper, lower = p.delta + p.l, p.delta - p.l
    turns = 2 * np.pi * phase
    net = p.f * np.sin(turns) + p.f2 * np.sin(2 * turns + p.phi2) + p.load - p.h * v - x
    for support, way, k, h, bound in ((1, 1.0, p.k1, p.h1, upper), (2, -1.0, p.k2, p.h2, lower)):
        if k > 0.0:
            push = way * (k * (x - bound) + h * v)
            if lets_go(p, support):
                push = np.maximum(push, 0.0)
            net -= np.where(way * (x - bound) > 0.0, way * push, 0.0)
    is_still = np.abs(v) <= REST * np.abs(v).max()
    held = np.sign(net) * np.maximum(np.abs(net) - p.friction * p.friction_ratio, 0.0)
    is_pressed = ((x >= upper) & (p.k1 == 0.0) & (net > 0)) | (
        (x <= lower) & (p.k2 == 0.0) & (net < 0)
    )
    held = np.where(is_pressed, 0.0, held)
    return np.asarray(np.where(is_still, held, net - p.friction * np.sign(v)))


def measured_of(record: Record) -> Measured:
    """Return a record as what a model is compared with."""
    names = [Named(name, name) for name in record.columns]
    return Measured({TAU: record.tau}, record.values, names, 1 / record.noise, record.has_noise)


def mirror_image(model: Model, point: np.ndarray) -> np.ndarray | None:
    """Return the values (k,) of the mirrored exciter, with the force half a period later; None if they are not free.

    x(tau) of the one is -x(tau + T/2) of the other, so that both fit sensors whose direction is not known, and
    responses without a sign.
    """
    record = model.record if isinstance(model, RecordModel) else None
    if record is not None and (record.is_signed or record.phase is not None):
        return None
    own = Parameters(*model.rows(point[None])[0].tolist())._asdict()
    image = {name: sign * own[of] for name, (of, sign) in MIRRORED.items()}
    # Half a period later the first harmonic of the force has its sign again.
    for name in ("f", "shaker"):
        image[name] = own[name]
    # A name of one's own keeps its value: what is tied to it is then mirrored, or there is no such image.
    moved = np.array([image.get(n, v) for n, v in zip(model.found, point.tolist(), strict=True)])
    wanted = np.array([image[name] for name in own])
    return moved if np.allclose(model.rows(moved[None])[0], wanted, ROUNDING, ROUNDING) else None
