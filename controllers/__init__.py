"""Control laws for cable-driven robots, formulated as QPs over muscle forces.

The package does not depend on a simulator. Names in `_MODULES` are imported on first use, since a
run does not need the analyses.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .dynamics import Dynamics, TaskDynamics
from .force_distribution.bounded import ForceDistribution
from .force_distribution.solution import ForceSolution
from .laws.control_loop import ControlLaw, ControlLoop
from .laws.joint_space import JointSpaceController
from .laws.operational_space import (
    OperationalSpaceController,
    OperationalSpaceSolution,
    Posture,
)
from .references.flower import ApproachReference, FlowerReference, SequenceReference
from .references.reference import JointReference, Reference
from .references.splines import SplineReference

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
    from .analysis.stiffness import Stiffness, task_stiffness
    from .analysis.workspace import Workspace, joint_grid
    from .force_distribution.methods import METHODS, distribute
    from .force_distribution.polygon import feasible_polygon
    from .force_distribution.poses import DistributedForces
    from .laws.motors import SpringMotors
    from .optimal.custom import MotionCost, MotionState
    from .references.recorded import recorded_trajectory, waypoint_trajectory

_MODULES = {
    "analysis.gains": "from_bandwidth largest_stable_period lqr margins sampling_warning",
    "analysis.inverse_dynamics": "Motion MotionForces motion_terms size_muscles",
    "analysis.kinematics": "forward_kinematics inverse_kinematics",
    "analysis.linearise": "close_loop linearise_controller linearise_loop linearise_robot",
    "analysis.stiffness": "Stiffness task_stiffness",
    "analysis.workspace": "Workspace joint_grid",
    "force_distribution.methods": "METHODS distribute",
    "force_distribution.polygon": "feasible_polygon",
    "force_distribution.poses": "DistributedForces",
    "laws.motors": "SpringMotors",
    "optimal.custom": "MotionCost MotionState",
    "references.recorded": "recorded_trajectory waypoint_trajectory",
}
_MODULE_OF_NAME = {name: module for module, names in _MODULES.items() for name in names.split()}

__all__ = [
    "METHODS",
    "ApproachReference",
    "ControlLaw",
    "ControlLoop",
    "DistributedForces",
    "Dynamics",
    "FlowerReference",
    "ForceDistribution",
    "ForceSolution",
    "JointReference",
    "JointSpaceController",
    "Motion",
    "MotionCost",
    "MotionForces",
    "MotionState",
    "OperationalSpaceController",
    "OperationalSpaceSolution",
    "Posture",
    "Reference",
    "SequenceReference",
    "SplineReference",
    "SpringMotors",
    "Stiffness",
    "TaskDynamics",
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
    "recorded_trajectory",
    "sampling_warning",
    "size_muscles",
    "task_stiffness",
    "waypoint_trajectory",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF_NAME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULE_OF_NAME[name]}"), name)
