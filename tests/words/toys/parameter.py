"""A parameter: how much the supports have worn, which takes its share of both restitutions."""

from vibropipe.words.exciter import PARAMETERS
from vibropipe.words.records import FRACTION, Parameter


def restitutions(values):
    return {name: values[name] * (1.0 - values["wear"]) for name in ("R1", "R2")}


WEAR = Parameter(
    name="wear", range=FRACTION, default=0.0, symbol="$w$", plain="w", long_name="wear of the supports",
    words="wear", key="Share of the restitutions that wear has taken", effect="wear", acts=restitutions,
)  # fmt: skip
PARAMETERS.append(WEAR)
