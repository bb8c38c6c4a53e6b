"""What a report says of a pendulum."""

from vibropipe.report.parts import Answer, Table
from vibropipe.scenes.kind import ReportPart


def answers(datasets):
    return {
        name: [Answer("The period grows.", f"It reaches {float(data['period'].max()):.4g} s.")]
        for name, data in datasets.items()
    }


def tables(datasets):
    rows = [[name, f"{float(data['period'].max()):.4g}"] for name, data in datasets.items()]
    return [Table(["scene", "longest period"], rows, title="Periods")]


REPORT = ReportPart("Pendulums", "How long does it swing?", answers, tables)
