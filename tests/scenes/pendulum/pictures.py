"""The pictures of a pendulum."""

from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.scenes.kind import Picture


def draw(dataset):
    figure = new_canvas(6.0)
    axes(figure, 1.5, 1.0, 14.0, 4.5).plot(dataset["amplitude"], dataset["period"])
    return figure


PICTURES = (Picture("period", draw, lambda dataset: "The period grows with the amplitude."),)
