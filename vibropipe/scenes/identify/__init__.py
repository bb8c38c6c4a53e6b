"""Identification: parameters that explain a measured motion or response."""

from vibropipe.scenes.identify.keys import CHECKS, IdentifyScene
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    IdentifyScene,
    CHECKS,
    unit="steps",
    packages=("scipy",),
    holds=lambda data: "fit_result" in data,
)
