"""Views of robots and runs: scenes and HTML pages."""

from .scene.motion import Motion, motion_of
from .scene.stage import Stage

__all__ = ["Motion", "Stage", "motion_of"]
