"""Physics: the plant on DART, dynamics for controllers, and a small C core below both."""

from .blob import compile_blob
from .core_dynamics import CoreDynamics
from .dynamics import DartDynamics
from .muscle_drive import MuscleDrive
from .muscle_paths import MusclePaths
from .plant import Plant
from .scene import Scene

__all__ = [
    "CoreDynamics",
    "DartDynamics",
    "MuscleDrive",
    "MusclePaths",
    "Plant",
    "Scene",
    "compile_blob",
]
