"""Views of robots and runs: scenes, and adapters that draw them."""

from .scene.motion import Motion, motion_of
from .scene.stage import Stage

__all__ = ["Motion", "Stage", "motion_of"]
