"""Part of the report on backbones: none beside the figures."""

from vibropipe.scenes.kind import ReportPart

REPORT = ReportPart()
