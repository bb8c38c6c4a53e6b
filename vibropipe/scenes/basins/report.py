"""Part of the report on coexisting motions."""

from vibropipe.scenes.basins.text import sections
from vibropipe.scenes.kind import ReportPart

REPORT = ReportPart(sections)
