"""A quantity: how much harder support 1 is struck than support 2."""

from vibropipe.words.quantities import QUANTITIES, Quantity


def difference(quantities, parameters):
    hardest = quantities["impact_velocity_max"]
    return hardest[:, 0] - hardest[:, 1]


HARDER = Quantity(
    long_name="impact velocity by which support 1 is struck harder", symbol="$d$", dimension="velocity",
    output="impacts", is_signed=True, goal="smooth", short="difference of impact velocities",
    drawn=("sweep",), function=difference,
)  # fmt: skip
QUANTITIES["impact_difference"] = HARDER
