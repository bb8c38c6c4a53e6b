"""Pictures of a backbone: over amplitude, or the curves of eq. (10)."""

from vibropipe.scenes.backbone.amplitude_frequency import draw_amplitude_frequency
from vibropipe.scenes.backbone.captions import describe_amplitude_frequency, describe_backbone
from vibropipe.scenes.backbone.curves import draw_backbone
from vibropipe.scenes.kind import Picture, showing

PICTURES = (
    Picture(
        "amplitude_frequency",
        draw_amplitude_frequency,
        lambda dataset, show: describe_amplitude_frequency(dataset),
        lambda dataset: "eigenfrequency" in dataset,
        showing,
    ),
    Picture(
        "backbone",
        draw_backbone,
        lambda dataset, show: describe_backbone(dataset),
        lambda dataset: "velocity_over_l" in dataset,
        keywords=showing,
    ),
)
