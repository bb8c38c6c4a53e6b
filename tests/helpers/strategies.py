"""Strategies for exciters and motions from the whole space of parameters, and motions that once failed.

Corners are favoured. Motions last few crossings between the supports, so that each example is cheap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from hypothesis import strategies as st

import vibropipe as vp


class Case(NamedTuple):
    exciter: Any
    tau_end: float
    x0: float
    v0: float
    method: dict[str, Any]

    def run(self, **changed: Any) -> Any:
        start = {"tau_end": self.tau_end, "x0": self.x0, "v0": self.v0, "samples_per_period": 16}
        return vp.simulate(self.exciter, **{**start, **self.method, **changed})

    @property
    def rooms(self) -> tuple[float, float]:
        return -(self.exciter.l - self.exciter.delta), self.exciter.l + self.exciter.delta


def log(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def signed(magnitudes: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    return st.tuples(st.sampled_from([-1.0, 1.0]), magnitudes).map(math.prod)


@st.composite
def exciters(draw: Callable[..., Any]) -> Any:
    length = draw(st.one_of(st.just(0.5), log(-9, 9)))
    offsets = st.one_of(
        st.sampled_from([0.0, 1.0, -1.0, 1.5, -1.5]), st.floats(-2, 2), signed(log(-12, 2))
    )
    f = draw(st.one_of(st.sampled_from([0.0, 1.0, -1.0, 1e-300]), signed(log(-9, 6))))
    delta = draw(offsets) * length

    def restitution(bound: float) -> float:
        # A mass that is pressed on a support strikes it 1/(1 - R) times; R = 1 has its own test.
        R = draw(st.one_of(st.sampled_from([0.0, 1.0, 0.5]), st.floats(0, 1), log(-12, 0)))
        return min(R, 0.999) if bound <= abs(f) else R

    return vp.Exciter(
        l=length,
        nu=draw(st.one_of(st.sampled_from([1.0, 1 + 1e-9, 1 - 1e-12, 2.0]), log(-4, 4))),
        f=f,
        h=draw(st.one_of(st.sampled_from([0.0, 2.0, 2 + 1e-12, 2 - 1e-12]), log(-12, 4))),
        delta=delta,
        R1=restitution(length + delta),
        R2=restitution(length - delta),
    )


@st.composite
def cases(draw: Callable[..., Any]) -> Case:
    exciter = draw(exciters())
    lower, upper = -(exciter.l - exciter.delta), exciter.l + exciter.delta
    within = st.floats(0, 1).map(lambda share: lower + share * (upper - lower))
    x0 = draw(st.one_of(st.sampled_from([lower, upper]), within))
    v0 = draw(st.one_of(st.just(0.0), signed(log(-12, 3))))
    # up to ten crossings at the speed that the forces can give, or two periods
    pull = abs(exciter.f) + max(abs(lower), abs(upper))
    crossing = min(math.sqrt(4 * exciter.l / pull), 2 * exciter.l / max(abs(v0), 1e-300))
    tau_end = draw(st.floats(0.01, 10)) * min(crossing, 4 * math.pi / exciter.nu, 10.0)
    steps = st.integers(8, 200).map(lambda n: {"method": "newmark", "steps_per_period": n})
    method = draw(st.one_of(st.just({}), steps))
    x0 = min(max(x0, lower), upper)
    # a start whose squared distance from a support underflows lies on it
    on = [bound for bound in (lower, upper) if abs(x0 - bound) < 1e-150]
    return Case(exciter, tau_end, on[0] if on else x0, v0, method)


def coarse(steps: int) -> dict[str, Any]:
    return {"method": "newmark", "steps_per_period": steps}


# Motions that once failed a check.
PINNED = [
    # the search for an impact did not get off the support after a release
    Case(vp.Exciter(l=0.5, nu=1.0, f=1.0, h=1.0, R1=0, R2=0), 5.773502691896257, -0.5, 0.0, {}),
    Case(vp.Exciter(l=1e-6, nu=1e3, f=1.0, R1=0, R2=0), 0.0039999980000015, -1e-6, 0.0, {}),
    # a start so slow that its hops are a chatter at once: the energy of its impacts was not logged
    Case(
        vp.Exciter(l=0.01, delta=0.0316227766016838, R1=0, R2=0),
        1.0,
        0.021622776601683796,
        1e-7,
        {},
    ),
    # a start above the support by less than an ulp of l
    Case(
        vp.Exciter(l=0.5, nu=1.0, f=-1.0, delta=0.5, R1=0, R2=0),
        1.0,
        6.60937402473889e-214,
        0.0,
        {},
    ),
    Case(vp.Exciter(l=0.5, nu=1.0, f=-1.0, delta=0.5, R1=0.5, R2=0.5), 1.0, 1e-17, 0.0, {}),
    # a start so close to a support that the search for the impact stalled within the rounding of the gap
    Case(
        vp.Exciter(l=0.5, nu=2.0, delta=0.75, R1=0, R2=0),
        1.2649110640673518,
        0.2500000001589691,
        -1e-05,
        {},
    ),
    # put to rest in flight, where the gap acceleration was constant for an instant
    Case(
        vp.Exciter(l=0.5, nu=1.0, f=-1.0, delta=-1.0, R1=0, R2=0),
        0.8944271909999159,
        -0.5,
        -1.0,
        {},
    ),
    # classified as a grazing where the later force is large, not the one that acts
    Case(
        vp.Exciter(l=0.5, nu=1.0, f=1000.0, delta=1.0, R1=0, R2=0.999),
        0.04468785621687518,
        0.5,
        -1e-7,
        {},
    ),
    # an impact at the instant at which the gap acceleration touches zero: only its second derivative acts
    Case(vp.Exciter(l=0.5, nu=1.0, f=-1.0, delta=-0.5, R1=0.5, R2=0), 2.0, 0.0, 1.0, {}),
    # a creep of 1e5 times 1/h, each rounded
    Case(
        vp.Exciter(l=0.5, nu=1.7782794100389228, h=1e4, delta=0.5, R1=0, R2=0),
        9.899494936611665,
        0.5,
        0.0,
        {},
    ),
    # beyond the support within one coarse step, and millions of hops within one
    Case(vp.Exciter(l=0.5, nu=0.1, delta=0.5, R1=0, R2=0), 2.8284271247461903, 1.0, 0.0, coarse(8)),
    Case(vp.Exciter(l=0.1, nu=1.0, f=1.0, R2=0), 0.6030226891555273, 0.1, -1e-8, coarse(8)),
    # a table of the force over a period of 6e8 steps
    Case(vp.Exciter(l=0.5, nu=1e-4, h=1e4, R1=0, R2=0), 2.0, -0.5, 0.0, {}),
    # free motions: not mirrored to the last bit, an ulp beyond the support
    Case(vp.Exciter(l=0.5), 2.0, -0.5, 0.0, {}),
    Case(vp.Exciter(l=0.5, nu=1.000000001, R1=0, R2=0), 14.0, 0.5, 0.0, {}),
    # shorter than the distance of two samples
    Case(vp.Exciter(l=1e-7, R1=0, R2=0), 2e-7, -1e-7, -1.0, {}),
    # a rebound of 1e-5 of the speed scale
    Case(vp.Exciter(l=0.5, R1=0, R2=0.0625), 8.0, -0.5, 0.0, coarse(8)),
    # hundreds of hops that lose next to nothing: where its states were recorded it was another motion than before
    Case(
        vp.Exciter(l=1.0, nu=10.0, f=1.0, h=1.0, delta=1.984375, R1=0.0, R2=0.999),
        6.011753194417436,
        0.984375,
        0.0,
        coarse(66),
    ),
    # beyond both supports within a step: the one met first was sought no further than the other
    Case(
        vp.Exciter(l=0.5, nu=1.0, f=-100.0, h=0.0, delta=0.0, R1=0.0, R2=0.0),
        0.5642764926868786,
        0.4375,
        1.0,
        {},
    ),
]
