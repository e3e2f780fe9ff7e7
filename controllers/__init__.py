"""Control laws for cable-driven robots, as QPs over muscle forces. They know no simulator.

The names below are found when first used: what a run needs is light, what analyses need is not.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .control_loop import ControlLaw, ControlLoop
from .dynamics import Dynamics, TaskDynamics
from .flower import ApproachReference, FlowerReference, Reference, SequenceReference
from .force_distribution import ForceDistribution, ForceSolution
from .joint_space import JointSpaceController
from .operational_solution import OperationalSpaceSolution, Posture
from .operational_space import OperationalSpaceController
from .references import JointReference, SplineReference

if TYPE_CHECKING:
    from .cable_length import CableLengthController
    from .cable_velocity import CableVelocityController
    from .distributions import METHODS, DistributedForces, distribute, feasible_polygon
    from .force_position import ForcePositionController
    from .gains import from_bandwidth, largest_stable_period, lqr, margins, sampling_warning
    from .inverse_dynamics import (
        Motion,
        MotionForces,
        motion_terms,
        size_muscles,
    )
    from .kinematics import forward_kinematics, inverse_kinematics
    from .linearise import close_loop, linearise_controller, linearise_loop, linearise_robot
    from .lyapunov import LyapunovController
    from .motors import SpringMotors
    from .nonlinear_systems import to_nlsys
    from .reactive_qp import ReactiveQPController
    from .stiffness import Stiffness, task_stiffness
    from .torque_position import TorquePositionController
    from .workspace import Workspace, joint_grid

_HOMES = {
    "CableLengthController": "cable_length",
    "CableVelocityController": "cable_velocity",
    "DistributedForces": "distributions",
    "ForcePositionController": "force_position",
    "LyapunovController": "lyapunov",
    "METHODS": "distributions",
    "Motion": "inverse_dynamics",
    "MotionForces": "inverse_dynamics",
    "ReactiveQPController": "reactive_qp",
    "SpringMotors": "motors",
    "Stiffness": "stiffness",
    "TorquePositionController": "torque_position",
    "Workspace": "workspace",
    "close_loop": "linearise",
    "distribute": "distributions",
    "feasible_polygon": "distributions",
    "forward_kinematics": "kinematics",
    "from_bandwidth": "gains",
    "inverse_kinematics": "kinematics",
    "joint_grid": "workspace",
    "largest_stable_period": "gains",
    "linearise_controller": "linearise",
    "linearise_loop": "linearise",
    "linearise_robot": "linearise",
    "lqr": "gains",
    "margins": "gains",
    "motion_terms": "inverse_dynamics",
    "sampling_warning": "gains",
    "size_muscles": "inverse_dynamics",
    "task_stiffness": "stiffness",
    "to_nlsys": "nonlinear_systems",
}

__all__ = [
    "METHODS",
    "ApproachReference",
    "CableLengthController",
    "CableVelocityController",
    "ControlLaw",
    "ControlLoop",
    "DistributedForces",
    "Dynamics",
    "FlowerReference",
    "ForceDistribution",
    "ForcePositionController",
    "ForceSolution",
    "JointReference",
    "JointSpaceController",
    "LyapunovController",
    "Motion",
    "MotionForces",
    "OperationalSpaceController",
    "OperationalSpaceSolution",
    "Posture",
    "ReactiveQPController",
    "Reference",
    "SequenceReference",
    "SplineReference",
    "SpringMotors",
    "Stiffness",
    "TaskDynamics",
    "TorquePositionController",
    "Workspace",
    "close_loop",
    "distribute",
    "feasible_polygon",
    "forward_kinematics",
    "from_bandwidth",
    "inverse_kinematics",
    "joint_grid",
    "largest_stable_period",
    "linearise_controller",
    "linearise_loop",
    "linearise_robot",
    "lqr",
    "margins",
    "motion_terms",
    "sampling_warning",
    "size_muscles",
    "task_stiffness",
    "to_nlsys",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
