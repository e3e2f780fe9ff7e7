"""The controllers that an experiment may ask for: by the name of their type, or one's own."""

from __future__ import annotations

from dataclasses import dataclass

from addin_sdfusion.robot import UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from controllers.laws.joint_laws import JOINT_LAWS
from controllers.laws.operational_space import FORCE_WEIGHT
from controllers.laws.reactive_qp import TASK_WEIGHT

from .own_law import OWN_LAW_FORM, OwnLaw


@dataclass(frozen=True, slots=True)
class ControlType:
    """A type of controller.

    Attributes:
        meaning: What it is, in Markdown; empty for one's own.
        space: What it follows: joint positions, or task coordinates.
        torque_gains: Whether its gains make torques of errors, instead of accelerations.
        unread: What of the reference the law does not read, by the first part of its names.
        force_weight: Default of the weights of the muscles, in [1/N²].
        task_weight: Default of the weights of tasks; None if they are to be met exactly.
    """

    meaning: str
    space: Space
    torque_gains: bool = False
    unread: tuple[str, ...] = ()
    force_weight: float = 1.0
    task_weight: float | None = None


TYPES = {
    law.name: ControlType(law.meaning, "joint", torque_gains=law.torque_gains, unread=law.unread)
    for law in JOINT_LAWS
} | {
    "operational_space": ControlType(
        "computed torque, [eq. (4)](../explanation/equations.md#operational-space-eq-4), with "
        "posture, joint limits, weights, priorities",
        "operational",
        force_weight=FORCE_WEIGHT,
    ),
    "reactive_qp": ControlType(
        "eq. (4) with the tasks as cost: always solvable",
        "operational",
        force_weight=FORCE_WEIGHT,
        task_weight=TASK_WEIGHT,
    ),
}
"""The package's own, by name."""
JOINT_ACCELERATION = tuple(
    name for name, known in TYPES.items() if known.space == "joint" and not known.torque_gains
)
"""Those that command accelerations of joints, and may leave some joints to themselves."""
OPERATIONAL = tuple(name for name, known in TYPES.items() if known.space == "operational")


def require_law(law: str) -> None:
    """Refuse what is neither the name of a law nor of the form of one's own.

    Raises:
        UnknownNameError: It is none.
    """
    if law not in TYPES and OwnLaw.of(law) is None:
        raise UnknownNameError("controller type", law, [*TYPES, OWN_LAW_FORM])


def control_type(law: str, space: Space | None = None) -> ControlType:
    """What is known of a law.

    Args:
        law: The name of one of ours, or one's own.
        space: What one's own follows.
    """
    return TYPES.get(law) or ControlType("", space or "joint")
