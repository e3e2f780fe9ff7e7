"""Report of the parts of a robot's description that no engine simulates."""

from __future__ import annotations

from ..model.robot import Robot
from .muscles import cable_models

NOT_SIMULATED = (
    "cable-model-not-simulated",
    "winch-travel-left-out",
)
"""Codes of the findings about parts that are not simulated."""


def not_simulated(robot: Robot) -> list[str]:
    """Return one line for each kind of part that is not simulated; empty if everything is."""
    first: dict[str, str] = {}
    names: dict[str, list[str]] = {}
    for finding in cable_models(robot):
        if finding.code in NOT_SIMULATED:
            problem = finding.message.partition(": ")[2]
            first.setdefault(finding.code, problem)
            names.setdefault(finding.code, []).append(finding.subject.name)
    return [_line(problem, names[code]) for code, problem in first.items()]


def _line(problem: str, names: list[str]) -> str:
    others = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"not simulated: muscle {names[0]!r}{others}: {problem}"
