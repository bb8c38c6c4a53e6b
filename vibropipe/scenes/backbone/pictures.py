"""Pictures of a backbone: over amplitude, or the curves of eq. (10)."""

from vibropipe.scenes.backbone.amplitude_frequency import draw_amplitude_frequency
from vibropipe.scenes.backbone.captions import describe_amplitude_frequency, describe_backbone
from vibropipe.scenes.backbone.curves import draw_backbone
from vibropipe.scenes.kind import only_picture

PICTURES = (
    only_picture(
        "amplitude_frequency",
        draw_amplitude_frequency,
        describe_amplitude_frequency,
        lambda dataset: "eigenfrequency" in dataset,
    ),
    only_picture("backbone", draw_backbone, describe_backbone),
)
