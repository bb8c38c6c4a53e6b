"""Part of the report on coexisting motions."""

from vibropipe.scenes.basins.text import findings, sections
from vibropipe.scenes.kind import ReportPart

REPORT = ReportPart(sections, findings=findings)
