"""Controller types of experiments, and values of [controller] such as weights and norms."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

from pydantic import AfterValidator, ValidatorFunctionWrapHandler, WithJsonSchema, WrapValidator

from addin_sdfusion.robot import UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.config.custom_law import (
    CUSTOM_LAW_FORM,
    CUSTOM_LAW_SCHEMA,
    CustomLaw,
)
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import Text
from controllers.laws.joint_laws import JOINT_LAWS
from controllers.laws.operational_space import FORCE_WEIGHT, TASK_WEIGHT
from controllers.qp.solver import require_solver
from controllers.validation import MAX_NORM

from .predictive import MPC

FEEDBACK = "trajectory_feedback"
"""Controller type with the forces and gains of an optimal motion."""
DEFAULT_GAINS = 100.0, 20.0
"""kp and kd of controllers that may not use them: critically damped, at 10 rad/s."""


@dataclass(frozen=True, slots=True)
class ControlType:
    """Properties of a controller type.

    Attributes:
        meaning: Description in Markdown; empty for custom laws.
        space: Controlled space: joint positions or task coordinates.
        torque_gains: Whether the gains convert errors to torques instead of accelerations.
        unread: Prefixes of the reference signals that the law does not read.
        force_weight: Default weight of squared muscle forces, in [1/N²].
        task_weight: Default weight of tasks; None if tasks are constraints.
    """

    meaning: str
    space: Space
    torque_gains: bool = False
    unread: tuple[str, ...] = ()
    force_weight: float = 1.0
    task_weight: float | None = None


POLICY = "policy"
"""Controller type without a control law."""

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
        "eq. (4) with the tasks in the cost; always feasible",
        "operational",
        force_weight=FORCE_WEIGHT,
        task_weight=TASK_WEIGHT,
    ),
    MPC: ControlType(
        "[model predictive control](../explanation/equations.md#model-predictive-control) in joint "
        "or operational space; joint_space or operational_space is its fallback",
        "joint",
    ),
    POLICY: ControlType(
        "commands of a trained [policy](../how_to/learning.md#from-policy-to-robot), which "
        "`policy` names; kp and kd have no effect",
        "joint",
        torque_gains=True,
    ),
    FEEDBACK: ControlType(
        "forces and feedback gains of an [optimal motion](../explanation/optimal_motion.md), "
        "within the force limits",
        "joint",
        unread=("qdd_d",),
    ),
}
"""Built-in controller types by name."""
JOINT_ACCELERATION = tuple(
    name
    for name, law in TYPES.items()
    if law.space == "joint" and not law.torque_gains and name != FEEDBACK
)
"""Joint-space laws whose gains define accelerations; they support passive coordinates."""
OPERATIONAL = tuple(name for name, law in TYPES.items() if law.space == "operational")


def control_type(law: str, space: Space | None = None) -> ControlType:
    """Return the properties of a law.

    Args:
        law: Name of a built-in law, or a custom law.
        space: Controlled space of a custom law, of a policy or of model predictive control.
    """
    if law == MPC and space == "operational":
        return replace(TYPES[law], space=space, force_weight=FORCE_WEIGHT)
    if law == POLICY and space == "operational":
        return replace(TYPES[law], space=space, torque_gains=False)
    return TYPES.get(law) or ControlType("", space or "joint")


EXACT = "exact"
"""Value of an infinite weight in files."""
INFINITY = "infinity"
"""Value of the infinity norm in files."""


def _solver(name: str) -> str:
    try:
        return require_solver(name)
    except UnknownNameError as error:
        raise SettingError(error) from None


def _weight(value: Any, handler: ValidatorFunctionWrapHandler) -> float:
    if isinstance(value, str) and value == EXACT:
        return math.inf
    if isinstance(value, int | float) and not isinstance(value, bool) and value <= 0:
        raise SettingError(f"must be positive, or {EXACT!r}, not {value!r}")
    number: float = handler(value)
    return number


def _norm(value: Any, handler: ValidatorFunctionWrapHandler) -> float:
    if value == INFINITY:
        return math.inf
    number: float = handler(value)
    if not 1 <= number <= MAX_NORM or number != int(number):
        raise SettingError(
            f"must be an integer from 1 to {MAX_NORM}, or {INFINITY!r}, not {value!r}"
        )
    return number


def _rank(value: float) -> float:
    if value < 1 or value != int(value):
        raise SettingError(f"must be an integer of at least 1, not {value!r}")
    return value


Weight = Annotated[
    float,
    WrapValidator(_weight),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"const": EXACT}]}),
]
Norm = Annotated[
    float,
    WrapValidator(_norm),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "integer", "minimum": 1, "maximum": MAX_NORM},
                {"const": INFINITY},
            ]
        }
    ),
]
Rank = Annotated[float, AfterValidator(_rank), WithJsonSchema({"type": "number", "minimum": 1})]


def _law(law: str) -> str:
    if law not in TYPES and CustomLaw.of(law) is None:
        raise SettingError(UnknownNameError("controller type", law, [*TYPES, CUSTOM_LAW_FORM]))
    return law


Law = Annotated[
    str,
    AfterValidator(_law),
    WithJsonSchema({"anyOf": [{"enum": list(TYPES)}, CUSTOM_LAW_SCHEMA]}),
]

Solver = Annotated[Text, AfterValidator(_solver)]
