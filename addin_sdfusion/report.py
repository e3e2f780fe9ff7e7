"""Report of an export: its findings as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from .robot.finding import Finding, errors_first
from .robot.finding_builders import listed
from .robot.json_text import json_text

MAX_ALIKE = 3
"""Maximum number of warnings of one kind about a file format that are listed separately."""


def report_text(findings: Sequence[Finding]) -> str:
    """Return the findings as text, as `cardsflow check` prints them."""
    errors = sum(finding.is_error for finding in findings)
    counts = f"{errors} errors, {len(findings) - errors} warnings"
    return "\n".join([*map(str, findings), counts]) + "\n"


def report_json(findings: Iterable[Finding]) -> str:
    """Return the findings as JSON, as `cardsflow check --json` prints them."""
    rows = [finding.as_dict() for finding in findings]
    return json_text(rows, indent=1, ensure_ascii=False) + "\n"


def sort_findings(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return each finding once, errors first."""
    return tuple(errors_first(dict.fromkeys(findings)))


def merge_similar(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings with similar warnings about a file format merged into one."""
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kinds.setdefault((finding.severity, finding.code), []).append(finding)
    merged = []
    for alike in kinds.values():
        if len(alike) <= MAX_ALIKE or alike[0].is_error:
            merged += alike
            continue
        others = [finding.subject.name for finding in alike[1:]]
        more = f"and {len(others)} more like it: {listed(others, MAX_ALIKE)}"
        merged.append(replace(alike[0], message=f"{alike[0].message} ({more})"))
    return merged
