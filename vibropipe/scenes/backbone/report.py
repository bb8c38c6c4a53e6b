"""What a report says of a backbone: its picture says all."""

from vibropipe.scenes.kind import ReportPart

REPORT = ReportPart()
