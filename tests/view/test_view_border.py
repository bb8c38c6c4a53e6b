"""Borders on the page: what lies after the first row of a followed line is none."""

import numpy as np
import pytest
from figures.sample_datasets import sweep

from vibropipe.view.border import Borders
from vibropipe.view.plane import Plane
from vibropipe.words.regimes import Regime


@pytest.mark.parametrize(("follow", "first"), [("nu up", 0), ("nu down", -1), ("f up", None)])
@pytest.mark.parametrize("order", [1, -1])
def test_the_first_row_of_a_followed_line_is_beside_no_border(follow, first, order):
    dataset = sweep(12, f=np.linspace(0.05, 2, 12)).assign_attrs(follow=follow)
    regime = dataset["regime"].copy(data=np.full(dataset["regime"].shape, Regime.NO_IMPACT))
    # only the columns of the least and the largest frequency differ
    for column in (0, -1):
        regime[{"nu": column}] = Regime.TWO_SIDED
    plane = Plane(dataset.assign(regime=regime).isel(nu=slice(None, None, order)))
    borders = Borders(plane)
    steps = np.sort(dataset["nu"].values)
    places = {0: 0.5 * (steps[0] + steps[1]), -1: 0.5 * (steps[-1] + steps[-2])}
    x = plane.axes.index("nu")
    found = {
        round(borders.nearest(at).at[x], 9)
        for at in np.ndindex(*(values.size for values in plane.values))
    }
    assert found == {round(float(place), 9) for end, place in places.items() if end != first}
