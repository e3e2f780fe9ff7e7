"""Physics: the plant on DART, dynamics for controllers, and a small C core below both."""

from .core.blob import compile_blob
from .core.close_loops import close_loops
from .dynamics.core import CoreDynamics
from .dynamics.dart import DartDynamics
from .dynamics.independent import IndependentDynamics, control_dynamics, dependent_coordinates
from .muscles.inverse_model import MuscleDrive
from .muscles.own_laws import MuscleLaw
from .muscles.paths import MusclePaths
from .plant.plant import Plant
from .scene import Scene

__all__ = [
    "CoreDynamics",
    "DartDynamics",
    "IndependentDynamics",
    "MuscleDrive",
    "MuscleLaw",
    "MusclePaths",
    "Plant",
    "Scene",
    "close_loops",
    "compile_blob",
    "control_dynamics",
    "dependent_coordinates",
]
