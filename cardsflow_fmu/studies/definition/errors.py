"""Error of a study that stops before its end. Completed runs are kept."""

from __future__ import annotations

from addin_sdfusion.robot import SimulationError


class StudyError(SimulationError):
    """A study that stops but can be resumed, for example on a full disk, lost workers or Ctrl-C."""
