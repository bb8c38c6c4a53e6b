"""The function `identify`: the parameters that explain a measured motion, response or record."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import si_value
from vibropipe.physics.si import eigenfrequency
from vibropipe.physics.stated import ties_of_call
from vibropipe.physics.ties import Ties
from vibropipe.solve.checks import check_varied, check_whole
from vibropipe.solve.design.ranges import at_lower_ends, check_vary
from vibropipe.solve.fit.fit_dataset import fit_dataset, nearest_first
from vibropipe.solve.fit.fit_model import Model, Search, search, with_absent
from vibropipe.solve.fit.reading import (
    columns_of,
    has_units,
    plain_arguments,
    plain_table,
    read_table,
)
from vibropipe.solve.fit.record import UNKNOWN, Reading, Record
from vibropipe.solve.fit.record_frequency import (
    frequency_text,
    ranges_with_frequency,
    with_frequency_of,
)
from vibropipe.solve.fit.record_model import RecordModel, measured_of
from vibropipe.solve.physical import to_physical
from vibropipe.solve.with_units import are_with_units
from vibropipe.words.designs import DESIGN_SAMPLES, FitResult

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 128
# How many times as many samples a second search has, where the first explains nothing: laws may have narrow ranges.
MORE_SAMPLES = 4
# Multiples of the largest line of a record that the forcing frequency may be, in the order in which they are tried.
FACTORS = (1.0, 2.0, 3.0, 1 / 2, 1 / 3)


def identify(
    exciter: Exciter,
    measured: Any,
    vary: Mapping[str, tuple[float, float]],
    x0: float | None = None,
    v0: float = 0.0,
    noise: Mapping[str, float] | None = None,
    samples: int = SAMPLES,
    ties: Mapping[str, Any] | None = None,
    steady_from: Any = None,
    blanking: Any = None,
    sign: str = UNKNOWN,
) -> xr.Dataset:
    """Find the parameters nearest to a measured motion, response or record, and how near they are.

    Samples of low discrepancy in the ranges of `vary` come first; the best are refined in weighted least squares [1]_.
    The covariance is that of the linear model at the solution [2]_.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are known. Of one made by `from_physical`, all arguments may have units, bare numbers beside
        them are in SI, and so is the dataset. With a record it may lack its frequency, which is then found as well.
    measured : pandas.DataFrame, xarray.Dataset, mapping of str to array_like, or path of a CSV file
        A motion: `phase`, in forcing periods after a rising zero of sin(nu tau), and `displacement`. Or a response:
        swept parameters (nu) and quantities named as the columns of `table` are. Or a record of at least 32 samples: a
        column `time` (of an exciter without units `tau`), from any instant on, one or several of `displacement`,
        `velocity`, `acceleration`, and at most one that tells the phase: `force`, or a `trigger` that rises where
        sin(nu tau) does. Units stand in the heads, "time (ms)", "displacement (mm)", "acceleration (g)", in the
        attribute `units` of xarray, or are those of pint.
    vary : mapping of str to (float, float)
        Lower and upper end of each parameter to be found, or name that `ties` use.
    x0, v0 : float, optional
        Start of every motion, as for `steady_state`.
    noise : mapping of str to float, optional
        Standard deviation of each measured quantity; needed for several of a response. Otherwise it is estimated from
        the differences of successive misfits, in a record from those of neighbours in phase.
    samples : int
        Number of samples of a round, from 8 to 1e6; four times as many where these explain nothing.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others, swept ones included, or of names of one's own, as of `sweep`.
    steady_from : float, str or pint.Quantity, optional
        Of a record, the time from which its motion is steady (default: found in its first half).
    blanking : float, str or pint.Quantity, optional
        Of a record, the time on each side of an impact on a rigid support in which velocities and accelerations do not
        count (default: 1.5 intervals between samples).
    sign : str
        Of a record, whether it is `known` that sensors count towards support 1, or `unknown`.

    Returns
    -------
    xarray.Dataset
        <parameter>, <parameter>_std
            Each parameter; of the varied ones the value found, and its standard deviation: infinite if the measurements
            do not depend on it, or on a combination of it with others alone.
        parameter_covariance (parameter, other_parameter)
            Covariance of the values found.
        parameter_result (parameter)
            Whether the measurements determine a parameter, it ended at its range, or its deviation is as wide as that.
        singular_value (direction_of_fit), singular_vector (direction_of_fit, parameter)
            Change of the fit along orthogonal directions, over all of the ranges, in deviations of the noise.
        <name>_measured, <name>_fitted (measurement)
            Each quantity, measured and computed.
        <name>_noise
            Standard deviation of each quantity: given, or estimated.
        reduced_chi_square, reduced_chi_square_limit
            Sum of squares of misfits over the noise, over the degrees of freedom; what noise alone exceeds in one of
            1000 cases.
        <name>_twin (twin), twin_kind (twin), twin_excess (twin)
            Other values in the ranges that fit as well, if there are any: the sum of squares over the noise exceeds the
            least one by `twin_excess`, no more than noise alone does in 999 of 1000 cases. twin_kind: mirror_image
            (with sensors reversed and the force half a period later), reversed (another one with them so) or other.
        phase (measurement), <name>_offset, <name>_sign
            Of a record: the phase of each sample in forcing periods, and offset and sign of each sensor. Samples
            before the motion is steady are left out.
        transient_samples, <name>_left_out
            Of a record, the number of samples before the motion is steady, and of those of each sensor that do not
            count, for which <name>_fitted is NaN: at its limit, where three or more in a row have its largest or its
            least value, or within the blanking of an impact.
        fit_result
            explained: the misfit is within that limit. beyond_noise: it is not. constant: a quantity has one value
            only, or none is larger than a given noise or varies by more than an estimated one. absent: the motion
            found lacks a measured quantity. not_judged: too few measurements to estimate their noise.

    Raises
    ------
    ParameterError
        If a name, a unit, a range or a table is wrong, or there are not more numbers than parameters; if times of a
        record do not increase, it has no period or another one than is stated, fewer than 3 forcing periods, fewer
        than 8 samples in one, or a sensor with one value only or with most of them at its limit.

    Notes
    -----
    The frequency of a record is that of the largest line of its spectrum, refined by least squares of a sine and its
    harmonics (of `force` or `trigger` where there is one), and then with the parameters. If no motion explains the
    record, 2, 3, 1/2 and 1/3 of it are tried. The phase is the one of least squares, sought by correlation with each
    orbit; each offset is a mean. Gains of sensors are not found: with all lengths and forces scaled together, the same
    motion is larger.

    References
    ----------
    .. [1] M. A. Branch, T. F. Coleman, Y. Li, A subspace, interior, and conjugate gradient method for large-scale
       bound-constrained minimization problems, SIAM Journal on Scientific Computing 21 (1999) 1.
    .. [2] D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, Wiley 1988.
    """
    given: dict[str, Any] = {"vary": vary, "noise": noise, "x0": x0, "v0": v0}
    given |= {"steady_from": steady_from, "blanking": blanking}
    columns = columns_of(measured)
    is_mapping = all(isinstance(given[name], Mapping | None) for name in ("vary", "noise"))
    with_units = has_units(columns) or (is_mapping and are_with_units(exciter, *given.values()))
    table = plain_table(exciter, columns, with_units)
    if with_units:
        given = plain_arguments(exciter, given)
    untied, tied = ties_of_call(exciter, ties, vary)
    reading = Reading(given.pop("steady_from"), given.pop("blanking"), sign)
    found = _identify(untied, table, samples, tied, reading, **given)
    return to_physical(found, exciter) if with_units else found


def _identify(
    exciter: Exciter,
    table: dict[str, np.ndarray],
    samples: int,
    ties: Ties,
    reading: Reading,
    *,
    vary: Mapping[str, tuple[float, float]],
    noise: Mapping[str, float] | None,
    x0: float | None,
    v0: float,
) -> xr.Dataset:
    """Return the parameters found, without units."""
    over = {n: v for n, v in table.items() if n in Parameters._fields and v.size}
    first = {name: float(values[0]) for name, values in over.items()}
    ranges = check_vary(exciter, vary, ties, first)
    check_whole("samples", samples, DESIGN_SAMPLES)
    if exciter.written:
        p = eigenfrequency(*(si_value(name, exciter.written[name]) for name in ("m", "C")))
        reading = reading._replace(p=p)
    data = read_table(exciter, table, ranges, noise, reading, ties)
    if isinstance(data, Record):
        first = {"nu": data.line.nu}
    start = at_lower_ends(exciter, ranges, ties, first)
    start.check_start(x0, v0)
    lows = {name: ends[0] for name, ends in ranges.items()}
    check_varied("measured", exciter, over, lows | {n: float(v.min()) for n, v in over.items()})
    for line in set(zip(*(values.tolist() for values in over.values()), strict=True)):
        replace(start, **dict(zip(over, line, strict=True))).check_start(x0, v0)
    if isinstance(data, Record):
        found = _searched(_models_of(exciter, data, ranges, x0, v0, ties), samples)
        if found is None:
            nu = frequency_text(data.line.nu, reading.p)
            must = f"must hold the frequency of the record, {nu}"
            raise ParameterError("vary.nu", ranges["nu"], must=must, got="")
        return found
    low, high = np.array(list(ranges.values())).T
    model = Model(start, data, [*ranges], x0, v0, np.zeros(1), high - low, ties)
    model = with_absent(model, low, high)
    found = _searched([(model, low, high)], samples)
    assert found is not None
    return found


def _searched(
    models: Iterable[tuple[Model, np.ndarray, np.ndarray]], samples: int
) -> xr.Dataset | None:
    """Return the fit of the first model that explains, or of the nearest, searched again with more samples.

    models : each with the ends (k,) of its ranges; None without one
    """
    nearest, fitted, least = None, None, np.inf
    for each in models:
        found = _search(*each, samples)
        if found.costs.min() < least:
            nearest, fitted, least = each, _fitted(*each, found), float(found.costs.min())
            if int(fitted.fit_result) == FitResult.EXPLAINED:
                return fitted
    if nearest is None or fitted is None:
        return None
    if int(fitted.fit_result) not in (FitResult.BEYOND_NOISE, FitResult.ABSENT):
        return fitted
    again = _search(*nearest, MORE_SAMPLES * samples)
    if again.costs.min() < least:
        return _fitted(*nearest, again)
    return fitted.assign_attrs(samples=again.samples)


def _search(model: Model, low: np.ndarray, high: np.ndarray, samples: int) -> Search:
    """Return a search, of a record with sensors that are not reversed where that fits as well."""
    found = search(model, low, high, samples)
    return nearest_first(model, found, low, high) if isinstance(model, RecordModel) else found


def _fitted(model: Model, low: np.ndarray, high: np.ndarray, found: Search) -> xr.Dataset:
    """Return the fit of a search, or raise a ParameterError if its best values put a tied parameter out of range."""
    over = {n: values for n, values in model.data.over.items() if n in Parameters._fields}
    best = dict(zip(model.found, found.best.tolist(), strict=True))
    model.ties.checked({**model.exciter.numbers()._asdict(), **over, **best})
    return fit_dataset(model, found, low, high)


def _models_of(
    exciter: Exciter,
    record: Record,
    ranges: Mapping[str, tuple[float, float]],
    x0: float | None,
    v0: float,
    ties: Ties,
) -> Iterator[tuple[Model, np.ndarray, np.ndarray]]:
    """Yield a model, and the ends of its ranges, for each line that the forcing frequency of a record may be."""
    is_sure = record.phase is not None or record.line.std == 0.0
    for factor in (1.0,) if is_sure else FACTORS:
        own = with_frequency_of(record, factor)
        own_ranges = None if own is None else ranges_with_frequency(own, ranges)
        if own is None or own_ranges is None:
            continue
        base = replace(exciter, nu=own.line.nu) if own.line.std else exciter
        base = at_lower_ends(base, own_ranges, ties)
        low, high = np.array(list(own_ranges.values())).T
        model = RecordModel(
            base, measured_of(own), [*own_ranges], x0, v0, np.zeros(1), high - low, ties, own
        )
        yield with_absent(model, low, high), low, high
