"""The pictures of a pendulum."""

from vibropipe.figures.style import new_figure
from vibropipe.scenes.kind import Picture


def draw(dataset):
    figure = new_figure(6)
    figure.subplots().plot(dataset["amplitude"], dataset["period"])
    return figure


PICTURES = (Picture("period", draw, lambda dataset: "The period grows with the amplitude."),)
