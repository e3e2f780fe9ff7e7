"""Views of robots and runs: scenes, live view, HTML page, and Rerun file."""

from .scene.motion import Motion, motion_of
from .scene.stage import Stage

__all__ = ["Motion", "Stage", "motion_of"]
