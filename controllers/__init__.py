"""Control laws for cable-driven robots, as QPs over muscle forces. They know no simulator."""

from .dynamics import Dynamics
from .force_distribution import ForceDistribution, ForceSolution
from .joint_space import JointSpaceController
from .references import JointReference, SplineReference

__all__ = [
    "Dynamics",
    "ForceDistribution",
    "ForceSolution",
    "JointReference",
    "JointSpaceController",
    "SplineReference",
]
