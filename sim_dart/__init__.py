"""Physics: muscle paths in a small C core, the plant on DART, and the dynamics for controllers."""

from .dynamics import DartDynamics
from .muscle_paths import MusclePaths
from .plant import Plant

__all__ = ["DartDynamics", "MusclePaths", "Plant"]
