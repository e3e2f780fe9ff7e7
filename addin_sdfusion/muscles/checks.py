"""Findings on a muscle table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice, pairwise

from ..robot.finding import Finding, Severity, Subject
from .table import MuscleTable

_LISTED = 5


def finding(severity: Severity, code: str, message: str, kind: str, name: str) -> Finding:
    """Return a finding about an object of the design."""
    return Finding(severity, code, message, Subject(kind, name))


def table_findings(table: MuscleTable) -> list[Finding]:
    """Return findings on duplicate or missing point numbers and on invalid wrap surfaces."""
    return [*_numbers(table), *_wrap_uses(table)]


def _numbers(table: MuscleTable) -> list[Finding]:
    """Return findings on duplicate and missing point numbers."""
    findings = []
    for row in table.rows:
        counts = Counter(point.number for point in table.points_of(row.name))
        twice = [number for number, count in counts.items() if count > 1]
        if twice:
            message = (
                f"muscle {row.name!r} has several points with number {_listed(twice)}, so their "
                "order is unknown; order them in Define muscles"
            )
            findings.append(finding("error", "duplicate-number", message, "muscle", row.name))
        missing = list(islice(_gaps(sorted(counts)), _LISTED + 1))
        if missing:
            message = (
                f"muscle {row.name!r} has no point number {_listed(missing)}; if no point is "
                "missing, press OK in Define muscles to renumber"
            )
            findings.append(finding("warning", "missing-number", message, "muscle", row.name))
    return findings


def _gaps(numbers: Sequence[int]) -> Iterator[int]:
    for before, after in pairwise(numbers):
        yield from range(before + 1, after)


def _listed(numbers: Sequence[int]) -> str:
    shown = ", ".join(map(str, numbers[:_LISTED]))
    return f"{shown}, ..." if len(numbers) > _LISTED else shown


def _wrap_uses(table: MuscleTable) -> list[Finding]:
    """Return findings on invalid uses of wrap surfaces and on duplicate names."""
    findings = []
    for wrap, use in table.bad_uses():
        message = (
            f"wrap surface {wrap.name!r} comes after point {use.after} of muscle {use.muscle!r}, "
            "which does not exist or is the last point; choose the muscle and point again on the "
            "wrap tab of Define muscles"
        )
        findings.append(finding("error", "bad-wrap", message, "wrap_surface", wrap.name))
    for name, count in Counter(wrap.name for wrap in table.wraps).items():
        if count > 1:
            message = f"{count} wrap surfaces are called {name!r}; rename all but one"
            findings.append(finding("error", "duplicate-wrap", message, "wrap_surface", name))
    return findings
