"""Part of the report on coexisting motions."""

from vibropipe.report.parts import answers_of, tables_of
from vibropipe.scenes.basins.text import findings, sections
from vibropipe.scenes.kind import ReportPart

REPORT = ReportPart(
    "Coexisting motions",
    "Which start settles on which motion?",
    answers_of(findings),
    tables_of(sections),
)
