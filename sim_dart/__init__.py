"""Physics: muscle paths in a small C core, the plant on DART, and the dynamics for controllers."""

from .dynamics import DartDynamics
from .muscle_drive import MuscleDrive
from .muscle_paths import MusclePaths
from .plant import Plant
from .scene import Scene

__all__ = ["DartDynamics", "MuscleDrive", "MusclePaths", "Plant", "Scene"]
