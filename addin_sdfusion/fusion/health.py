"""Fusion's own errors and warnings on joints and construction points."""

from __future__ import annotations

from typing import Any

import adsk.fusion

from ..robot.finding import Subject
from .notes import Notes, optional


def problem_of(entity: Any, subject: Subject, notes: Notes) -> str:
    """What makes an entity unusable; empty if nothing. What is doubtful becomes a finding."""
    state = optional(lambda: entity.healthState)
    states = adsk.fusion.FeatureHealthStates
    if state == states.RolledBackFeatureHealthState:
        return "it is rolled back: move the timeline's marker to the end"
    if state not in (states.ErrorFeatureHealthState, states.WarningFeatureHealthState):
        return ""
    text = " ".join(str(entity.errorOrWarningMessage or "").split())
    if state == states.ErrorFeatureHealthState:
        return text or "Fusion reports an error"
    message = f"{subject.kind} {subject.name!r}: Fusion warns: {text or 'it is out of date'}"
    notes.warn(subject, "health-warning", message)
    return ""
