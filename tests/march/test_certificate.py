"""The certificate of free flight: a motion that it accepts, over one step or two, touches no support."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from vibropipe.march.grid import exact_grid, force_at_step, stays_between
from vibropipe.physics.contact import Frame
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE, combine
from vibropipe.physics.load import Force
from vibropipe.physics.turns import TWO_PI

NU, F, H = st.floats(0.1, 5), st.floats(-3, 3), st.floats(0, 4)
SAMPLES = np.linspace(0, 1, 501)


@given(
    nu=NU, f=F, h=H, y=st.floats(-1, 1), w=st.floats(-4, 4), load=st.floats(-1, 1),
    step=st.integers(0, 7), steps=st.sampled_from([1, 2]), sigma=st.sampled_from([-1.0, 1.0]),
    near=st.floats(-1.5, 0), width=st.floats(0.01, 4), departs=st.booleans(),
)  # fmt: skip
@example(1.0, 1.0, 0.6, 0.2, -0.5, 0.5, 0, 2, 1.0, 0.0, 9.0, False)
@example(1.0, 1.0, 0.6, 0.0, 1.0, -0.5, 3, 2, -1.0, 0.0, 9.0, True)
def test_a_certified_motion_touches_no_support(
    nu: float, f: float, h: float, y: float, w: float, load: float, step: int, steps: int,
    sigma: float, near: float, width: float, departs: bool,
) -> None:  # fmt: skip
    """Compare with samples of the exact polynomial of each step."""
    grid = exact_grid(ALL_EFFECTS, Parameters(nu, f, h, 1.0, 0.0, 0.7, 0.7))
    if departs:
        y, near, w = 0.0, 0.0, abs(w)
    end_y, end_w, motion, c = y, w, [], np.empty(DEGREE + 1)
    for k in range(step, step + steps):
        phase = TWO_PI * k / grid.steps
        force = Force(sigma * f * np.sin(phase), sigma * f * np.cos(phase))
        combine(ALL_EFFECTS, grid.basis, c, end_y, end_w, load, force)
        motion.append(np.polyval(c[::-1], SAMPLES))
        force_y, force_w = force_at_step(grid, k % grid.steps)
        end_y, end_w = (
            grid.a11 * end_y + grid.a12 * end_w + sigma * force_y + grid.b1 * load,
            grid.a21 * end_y + grid.a22 * end_w + sigma * force_w + grid.b2 * load,
        )
    far, displacement = near + width, np.concatenate(motion)
    stays_above, stays_below = (
        stays_between(
            grid,
            Frame(0, sigma, load, near, far, *reachable),
            int(departs),
            y,
            w,
            end_y,
            end_w,
            float(steps),
        )
        for reachable in ((True, False), (False, True))
    )
    if stays_above:
        assert (displacement[1:] > near).all()
    if stays_below:
        assert (displacement < far).all()


def test_flights_off_the_supports_are_certified() -> None:
    """A certificate that rejects everything would be safe too: this one accepts motions 0.2 off the support."""
    grid = exact_grid(ALL_EFFECTS, Parameters(1.0, 1.0, 0.6, 1.0, 0.0, 0.7, 0.7))
    force = np.array([force_at_step(grid, k) for k in range(grid.steps)])
    passed = 0
    for k in range(grid.steps):
        y, w = 0.5, 0.3
        first = grid.a11 * y + grid.a12 * w + force[k, 0], grid.a21 * y + grid.a22 * w + force[k, 1]
        after = force[(k + 1) % grid.steps]
        y2 = grid.a11 * first[0] + grid.a12 * first[1] + after[0]
        w2 = grid.a21 * first[0] + grid.a22 * first[1] + after[1]
        passed += stays_between(
            grid, Frame(0, 1.0, 0.0, min(y, y2) - 0.2, 9.0, True, True), 0, y, w, y2, w2, 2.0
        )
    assert passed == grid.steps
