"""Control laws for cable-driven robots, as QPs over muscle forces. They know no simulator.

The names below are found when first used: what a run needs is light, what analyses need is not.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .dynamics import Dynamics, TaskDynamics
from .force_distribution.bounded import ForceDistribution, ForceSolution
from .laws.control_loop import ControlLaw, ControlLoop
from .laws.joint_space import JointSpaceController
from .laws.operational_solution import OperationalSpaceSolution, Posture
from .laws.operational_space import OperationalSpaceController
from .references.flower import ApproachReference, FlowerReference, Reference, SequenceReference
from .references.splines import JointReference, SplineReference

if TYPE_CHECKING:
    from .analysis.gains import (
        from_bandwidth,
        largest_stable_period,
        lqr,
        margins,
        sampling_warning,
    )
    from .analysis.inverse_dynamics import Motion, MotionForces, motion_terms, size_muscles
    from .analysis.kinematics import forward_kinematics, inverse_kinematics
    from .analysis.linearise import (
        close_loop,
        linearise_controller,
        linearise_loop,
        linearise_robot,
    )
    from .analysis.nonlinear_systems import to_nlsys
    from .analysis.stiffness import Stiffness, task_stiffness
    from .analysis.workspace import Workspace, joint_grid
    from .force_distribution.methods import METHODS, DistributedForces, distribute, feasible_polygon
    from .laws.cable_length import CableLengthController
    from .laws.cable_velocity import CableVelocityController
    from .laws.force_position import ForcePositionController
    from .laws.lyapunov import LyapunovController
    from .laws.motors import SpringMotors
    from .laws.reactive_qp import ReactiveQPController
    from .laws.torque_position import TorquePositionController

_HOMES = {
    "CableLengthController": "laws.cable_length",
    "CableVelocityController": "laws.cable_velocity",
    "DistributedForces": "force_distribution.methods",
    "ForcePositionController": "laws.force_position",
    "LyapunovController": "laws.lyapunov",
    "METHODS": "force_distribution.methods",
    "Motion": "analysis.inverse_dynamics",
    "MotionForces": "analysis.inverse_dynamics",
    "ReactiveQPController": "laws.reactive_qp",
    "SpringMotors": "laws.motors",
    "Stiffness": "analysis.stiffness",
    "TorquePositionController": "laws.torque_position",
    "Workspace": "analysis.workspace",
    "close_loop": "analysis.linearise",
    "distribute": "force_distribution.methods",
    "feasible_polygon": "force_distribution.methods",
    "forward_kinematics": "analysis.kinematics",
    "from_bandwidth": "analysis.gains",
    "inverse_kinematics": "analysis.kinematics",
    "joint_grid": "analysis.workspace",
    "largest_stable_period": "analysis.gains",
    "linearise_controller": "analysis.linearise",
    "linearise_loop": "analysis.linearise",
    "linearise_robot": "analysis.linearise",
    "lqr": "analysis.gains",
    "margins": "analysis.gains",
    "motion_terms": "analysis.inverse_dynamics",
    "sampling_warning": "analysis.gains",
    "size_muscles": "analysis.inverse_dynamics",
    "task_stiffness": "analysis.stiffness",
    "to_nlsys": "analysis.nonlinear_systems",
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
