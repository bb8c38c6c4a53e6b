"""Lines of a branch: each impact has one of its own, also where the velocities of two become equal."""

import numpy as np
import xarray as xr

from vibropipe.scenes.branch.lines import velocities_of


def test_lines_of_impacts_cross_instead_of_turning_back():
    along = np.linspace(-1, 1, 9)
    first, second = 0.4 + 0.1 * along, 0.4 - 0.1 * along
    # From the sixth point on the orbit begins with its second impact.
    orbits = [
        (a, b) if n < 5 else (b, a) for n, (a, b) in enumerate(zip(first, second, strict=True))
    ]
    dataset = xr.Dataset(
        {"impact_velocity": ("impact", np.ravel(orbits)), "row_size": ("point", np.full(9, 2))},
        {"branch_id": ("point", np.zeros(9, int))},
    )
    np.testing.assert_array_equal(velocities_of(dataset), np.stack([first, second], axis=1))


def test_a_branch_of_its_own_begins_anew():
    dataset = xr.Dataset(
        {
            "impact_velocity": ("impact", [0.3, 0.2, -0.4, 0.2, 0.3]),
            "row_size": ("point", [2, 1, 2]),
        },
        {"branch_id": ("point", [0, 0, 1])},
    )
    expected = [[0.3, 0.2], [0.4, np.nan], [0.2, 0.3]]
    np.testing.assert_array_equal(velocities_of(dataset), expected)
