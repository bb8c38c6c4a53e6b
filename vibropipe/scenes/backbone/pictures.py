"""Pictures of a backbone: over amplitude, or the curves of eq. (10)."""

from vibropipe.scenes.backbone.amplitude_frequency import draw_amplitude_frequency
from vibropipe.scenes.backbone.captions import describe_amplitude_frequency, describe_backbone
from vibropipe.scenes.backbone.curves import draw_backbone
from vibropipe.scenes.kind import Picture, shown

PICTURES = (
    Picture(
        "amplitude_frequency",
        lambda dataset: "eigenfrequency" in dataset,
        lambda dataset, options, _: draw_amplitude_frequency(dataset, shown(options)),
        lambda dataset, options, _: describe_amplitude_frequency(dataset),
    ),
    Picture(
        "backbone",
        lambda dataset: True,
        lambda dataset, options, _: draw_backbone(dataset, shown(options)),
        lambda dataset, options, _: describe_backbone(dataset),
    ),
)
