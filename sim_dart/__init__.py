"""Simulation of robots: plant, dynamics for controllers, and the C core that both use."""

from .batch.batch import Batch
from .core.blob import compile_blob
from .core.close_loops import close_loops
from .dynamics.core import CoreDynamics
from .dynamics.dart import DartDynamics
from .dynamics.independent import IndependentDynamics, control_dynamics, dependent_coordinates
from .muscles.custom_laws import MuscleLaw
from .muscles.inverse_model import MuscleDrive
from .muscles.paths import MusclePaths
from .plant.plant import Plant
from .scene import Scene

__all__ = [
    "Batch",
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
