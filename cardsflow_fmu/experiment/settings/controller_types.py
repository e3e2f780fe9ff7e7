"""The controllers that an experiment may ask for: by the name of their type, or one's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from addin_sdfusion.robot import UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from controllers.laws.operational_space import FORCE_WEIGHT
from controllers.laws.reactive_qp import TASK_WEIGHT

from .own_law import OWN_LAW_FORM, OwnLaw

LawName = Literal[
    "joint_space",
    "force_position",
    "torque_position",
    "lyapunov",
    "operational_space",
    "reactive_qp",
]


@dataclass(frozen=True, slots=True)
class ControlType:
    """A type of controller.

    Attributes:
        law: Its class in `controllers`.
        space: What it follows: joint positions, or task coordinates.
        torque_gains: Whether its gains make torques of errors, instead of accelerations.
        unread: What of the reference the law does not read, by the first part of its names.
        force_weight: Default of the weights of the muscles, in [1/N²].
        task_weight: Default of the weights of tasks; None if they are to be met exactly.
    """

    law: str
    space: Space
    torque_gains: bool = False
    unread: tuple[str, ...] = ()
    force_weight: float = 1.0
    task_weight: float | None = None


TYPES: dict[LawName, ControlType] = {
    "joint_space": ControlType("JointSpaceController", "joint"),
    "force_position": ControlType("ForcePositionController", "joint", unread=("qdd_d",)),
    "torque_position": ControlType(
        "TorquePositionController", "joint", torque_gains=True, unread=("qd_d", "qdd_d")
    ),
    "lyapunov": ControlType("LyapunovController", "joint", torque_gains=True, unread=("qdd_d",)),
    "operational_space": ControlType(
        "OperationalSpaceController", "operational", force_weight=FORCE_WEIGHT
    ),
    "reactive_qp": ControlType(
        "ReactiveQPController",
        "operational",
        force_weight=FORCE_WEIGHT,
        task_weight=TASK_WEIGHT,
    ),
}


def require_law(law: str) -> None:
    """Refuse what is neither the name of a law nor of the form of one's own.

    Raises:
        UnknownNameError: It is none.
    """
    if law not in TYPES and OwnLaw.of(law) is None:
        raise UnknownNameError("controller type", law, [*get_args(LawName), OWN_LAW_FORM])


def control_type(law: str, space: Space | None = None) -> ControlType:
    """What is known of a law.

    Args:
        law: The name of one of ours, or one's own.
        space: What one's own follows.
    """
    return TYPES.get(law) or ControlType(law, space or "joint")  # type: ignore[call-overload]
