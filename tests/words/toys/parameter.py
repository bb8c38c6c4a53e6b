"""A parameter: how much the supports have worn, which takes its share of both restitutions."""

from vibropipe.words.exciter import PARAMETERS
from vibropipe.words.records import FRACTION, Parameter

WEAR = Parameter(
    name="wear", range=FRACTION, default=0.0, symbol="$w$", plain="w", long_name="wear of the supports",
    words="wear", key="Share of the restitutions that wear has taken", effect="wear",
    acts={name: f"{name} * (1.0 - wear)" for name in ("R1", "R2")},
)  # fmt: skip
PARAMETERS.append(WEAR)
