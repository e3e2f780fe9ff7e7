"""The error of a study that stops before its end; what is done stays done."""

from __future__ import annotations

from addin_sdfusion.robot import SimulationError


class StudyError(SimulationError):
    """A study that cannot continue for now: the disk is full, the workers are lost, Ctrl-C."""
