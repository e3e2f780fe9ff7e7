"""Control laws for cable-driven robots, as QPs over muscle forces. They know no simulator."""

from .cable_length import CableLengthController
from .cable_velocity import CableVelocityController
from .control_loop import ControlLaw, ControlLoop
from .dynamics import Dynamics, TaskDynamics
from .flower import ApproachReference, FlowerReference, Reference, SequenceReference
from .force_distribution import ForceDistribution, ForceSolution
from .force_position import ForcePositionController
from .gains import from_bandwidth, largest_stable_period, lqr, margins, sampling_warning
from .joint_space import JointSpaceController
from .linearise import close_loop, linearise_controller, linearise_loop, linearise_robot
from .lyapunov import LyapunovController
from .motors import SpringMotors
from .nonlinear_systems import to_nlsys
from .operational_space import OperationalSpaceController, Posture
from .references import JointReference, SplineReference
from .torque_position import TorquePositionController

__all__ = [
    "ApproachReference",
    "CableLengthController",
    "CableVelocityController",
    "ControlLaw",
    "ControlLoop",
    "Dynamics",
    "FlowerReference",
    "ForceDistribution",
    "ForcePositionController",
    "ForceSolution",
    "JointReference",
    "JointSpaceController",
    "LyapunovController",
    "OperationalSpaceController",
    "Posture",
    "Reference",
    "SequenceReference",
    "SplineReference",
    "SpringMotors",
    "TaskDynamics",
    "TorquePositionController",
    "close_loop",
    "from_bandwidth",
    "largest_stable_period",
    "linearise_controller",
    "linearise_loop",
    "linearise_robot",
    "lqr",
    "margins",
    "sampling_warning",
    "to_nlsys",
]
