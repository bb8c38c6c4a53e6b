"""An effect that kernels do not know: worn supports."""

from vibropipe.words.exciter import EFFECTS
from vibropipe.words.records import Effect

WEAR = Effect(
    name="wear", unless="wear = 0", shown=("wear",), calls=("wear",), is_marched=False,
    sentence="wear takes its share of both restitutions",
)  # fmt: skip
EFFECTS.append(WEAR)
