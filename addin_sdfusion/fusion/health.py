"""Errors and warnings of Fusion on joints, rigid groups and construction points."""

from __future__ import annotations

from typing import Any

import adsk.fusion

from ..robot.finding import Subject
from .notes import Notes, optional


def _with_health(entity: Any) -> Any:
    """Return the object with the health state: the entity or its timeline object.

    As-built joints and rigid groups do not have a health state themselves.
    """
    state = optional(lambda: entity.healthState)
    timeline = None if state is not None else optional(lambda: entity.timelineObject)
    return entity if timeline is None else timeline


def problem_of(entity: Any, subject: Subject, notes: Notes) -> str:
    """Return the error that makes an entity unusable, or an empty string.

    A warning of Fusion is added to the findings.
    """
    source = _with_health(entity)
    state = optional(lambda: source.healthState)
    states = adsk.fusion.FeatureHealthStates
    if state == states.RolledBackFeatureHealthState:
        return "it is rolled back: move the marker of the timeline to the end"
    if state not in (states.ErrorFeatureHealthState, states.WarningFeatureHealthState):
        return ""
    text = " ".join(str(source.errorOrWarningMessage or "").split())
    if state == states.ErrorFeatureHealthState:
        return text or "Fusion reports an error"
    message = f"{subject.kind} {subject.name!r}: Fusion warns: {text or 'it is out of date'}"
    notes.warn(subject, "health-warning", message)
    return ""
