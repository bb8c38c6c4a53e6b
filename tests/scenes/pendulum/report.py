"""What a report says of a pendulum."""

from vibropipe.report.section import Section
from vibropipe.report.table import Table
from vibropipe.scenes.kind import ReportPart


def sections(datasets):
    rows = [[name, f"{float(data['period'].max()):.4g}"] for name, data in datasets.items()]
    return [Section("Pendulums", tables=[Table(["scene", "longest period"], rows, "Periods.")])]


REPORT = ReportPart(sections)
