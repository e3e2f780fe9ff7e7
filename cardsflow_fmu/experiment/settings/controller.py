"""[controller]: the control law, its gains and weights, and what is around it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
    model_validator,
)

from addin_sdfusion.robot import UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.names import each
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    OR_FALSE,
    Context,
    FromZero,
    Positive,
    Table,
    Text,
    setting,
)
from controllers.laws.operational_space import LIMIT_BANDWIDTH
from controllers.qp.law_in_c import number_of
from controllers.qp.solver import DEFAULT_SOLVER, require_solver
from controllers.validation import LARGEST_NORM, LARGEST_PRETENSION

from .controller_types import (
    JOINT_ACCELERATION,
    OPERATIONAL,
    TYPES,
    ControlType,
    control_type,
    require_law,
)
from .own_law import OwnLaw
from .plant import Engine, StartSettings
from .reference import ReferenceSettings
from .run import RunSettings

EXACT = "exact"
"""An infinite weight, which no number in a file is."""
INFINITY = "infinity"
"""The norm that is the largest, likewise."""
LONGEST_HORIZON = 1e6
"""In [s]: days; forces beyond all numbers are aimed at with 1e300."""


def _solver(name: str) -> str:
    try:
        return require_solver(name)
    except UnknownNameError as error:
        raise SettingError(error) from None


def _weight(value: Any, handler: ValidatorFunctionWrapHandler) -> float:
    if isinstance(value, str) and value == EXACT:
        return math.inf
    if isinstance(value, int | float) and not isinstance(value, bool) and value <= 0:
        raise SettingError(f"must be above 0, or {EXACT!r}: {value!r}")
    number: float = handler(value)
    return number


def _norm(value: Any, handler: ValidatorFunctionWrapHandler) -> float:
    if value == INFINITY:
        return math.inf
    number: float = handler(value)
    if not 1 <= number <= LARGEST_NORM or number != int(number):
        raise SettingError(
            f"must be a whole number from 1 to {LARGEST_NORM}, or {INFINITY!r}: {value!r}"
        )
    return number


def _rank(value: float) -> float:
    if value < 1 or value != int(value):
        raise SettingError(f"must be whole numbers from 1 on: {value!r}")
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
                {"type": "integer", "minimum": 1, "maximum": LARGEST_NORM},
                {"const": INFINITY},
            ]
        }
    ),
]
Rank = Annotated[float, AfterValidator(_rank), WithJsonSchema({"type": "number", "minimum": 1})]


def _law(law: str) -> str:
    try:
        require_law(law)
    except UnknownNameError as error:
        raise SettingError(error) from None
    return law


_OWN = {"type": "string", "pattern": r"\.py:\w+$"}
Law = Annotated[
    str,
    AfterValidator(_law),
    WithJsonSchema({"anyOf": [{"enum": list(TYPES)}, _OWN]}),
]


class PostureSettings(Table):
    """What a redundant robot does beside its tasks; see `controllers.Posture`."""

    kp: tuple[FromZero, ...] = each("coordinate", "in 1/s²", 25.0, symbol="posture_kp")
    kd: tuple[FromZero, ...] = each("coordinate", "in 1/s", 10.0, symbol="posture_kd")
    q0: tuple[float, ...] = each(
        "coordinate", "the preferred posture, in rad or m; that of the start", None, symbol="q0"
    )


class ControllerSettings(Table):
    """The controller."""

    type: Law = setting("the control law; one's own as `file.py:Class`", None)
    own_space: Literal["joint", "operational"] = setting(
        "what a law of one's own follows", None, alias="space"
    )
    kp: tuple[Positive, ...] = each("followed", "gain of position errors, in 1/s²", symbol="kp")
    kd: tuple[FromZero, ...] = each("followed", "gain of velocity errors, in 1/s", symbol="kd")
    ki: tuple[FromZero, ...] = each(
        "followed", "gain of the errors' integrals, in 1/s³", 0.0, symbol="ki"
    )
    period: Positive = setting("time between two ticks, in s: a whole multiple of run.step", None)
    solver: Annotated[Text, AfterValidator(_solver)] = setting(
        "what solves the QP: dual_newton, or a back end of qpsolvers", DEFAULT_SOLVER
    )
    weights: tuple[Positive, ...] = each("muscle", "of squared forces, in 1/N²", None, symbol="H_f")
    motor_weights: tuple[Positive, ...] = each(
        "motor", "of squared torques, in 1/(N·m)² or 1/N²", None
    )
    norm: Norm = setting("which norm of forces is least, by laws that follow q", 2.0, symbol="norm")
    pretension: tuple[Annotated[FromZero, Field(le=LARGEST_PRETENSION)], ...] = each(
        "muscle", "force that is preferred, in N", 0.0, symbol="f_p"
    )
    passive: tuple[bool, ...] = each(
        "coordinate", "whether it follows nothing, left to its spring and damper", False
    )
    dependent: tuple[bool, ...] = each(
        "coordinate", "whether it follows from the others by loops; chosen where not said", False
    )
    observer: FromZero = setting("bandwidth of the disturbance observer, in rad/s", 0.0)
    delay: Annotated[int, Field(ge=0, le=1), AS_WHOLE] = setting(
        "ticks until forces take effect", 0, symbol="delay"
    )
    predict: bool = setting("whether the controller makes up for the delay", True, symbol="predict")
    muscle_horizon: Annotated[FromZero, Field(le=LONGEST_HORIZON)] = setting(
        "how far ahead commands of muscles aim, in s; 0 for the next ticks", 0.0
    )
    engine: Engine = setting("what computes the dynamics; auto is the core", "auto")
    posture: Annotated[PostureSettings | None, OR_FALSE] = setting(
        "what a redundant robot does beside its tasks; false for nothing", {}
    )
    task_weights: tuple[Weight, ...] = each(
        "task coordinate", 'how much a task counts; "exact" to meet it exactly', None, symbol="W"
    )
    priorities: tuple[Rank, ...] = each(
        "task coordinate", "rank of a task, 1 first", 1.0, symbol="priority"
    )
    acceleration_weights: tuple[Positive, ...] = each(
        "coordinate", "of squared accelerations", 1.0, symbol="H_q"
    )
    force_rate_weights: tuple[FromZero, ...] = each(
        "muscle", "of squared changes of force", 0.0, symbol="H_r"
    )
    limit_bandwidth: Annotated[Positive | None, OR_FALSE] = setting(
        "how joint limits are kept, in rad/s; false for not at all",
        LIMIT_BANDWIDTH,
        symbol="limit_bandwidth",
    )

    @model_validator(mode="after")
    def _check_space(self) -> Self:
        if self.own_space is not None and self.own_law is None:
            raise SettingError("is that of the law; leave it out", key="space")
        unsaid = self.own_law is not None and self.own_space is None
        if self.type is not None and self.space == "joint" and not unsaid:
            self.require_only(key for key in type(self).model_fields if key not in _OF_TASKS)
        if any(self.passive) and self.type is not None and self.type not in JOINT_ACCELERATION:
            what = f"is for controllers of type {' and '.join(map(repr, JOINT_ACCELERATION))}"
            raise SettingError(f"{what}, not {self.type!r}", key="passive")
        if self.norm != 2.0 and self.type is not None and self.space == "operational":
            what = f"is for controllers that follow q; {self.type!r} weighs squares of forces"
            raise SettingError(what, key="norm")
        closing = (*JOINT_ACCELERATION, *OPERATIONAL)
        if any(self.dependent) and self.type is not None and self.type not in closing:
            what = f"the robot has closed loops, which only {', '.join(map(repr, closing))} know"
            raise SettingError(f"{what}, not {self.type!r}", key="type")
        return self

    @property
    def own_law(self) -> OwnLaw | None:
        """The controller of one's own that is asked for; None for one of ours."""
        return None if self.type is None else OwnLaw.of(self.type)

    @property
    def law(self) -> ControlType:
        """What is known of the law."""
        return control_type(self.type, self.own_space)

    @property
    def space(self) -> Space:
        """What it follows: joint positions, or task coordinates."""
        return self.law.space

    @property
    def torque_gains(self) -> bool:
        """Whether the gains make torques of errors, instead of accelerations."""
        return self.law.torque_gains

    @property
    def tasks(self) -> ControllerSettings | None:
        """Posture, weights and priorities of a controller in operational space; else None."""
        return None if self.space == "joint" else self

    @property
    def unfollowing(self) -> tuple[bool, ...]:
        """Which coordinates follow no reference: passive ones, and those that loops move."""
        return tuple(a or b for a, b in zip(self.passive, self.dependent, strict=True))

    def law_arrays(self) -> dict[str, Any]:
        """The settings that are arrays of the law and of its loop in C, by their names there.

        Those of muscles have motors behind them. See `computed_torque.h` and `control_loop.h`.
        """
        arrays = self.arrays(_OF_TASKS if self.tasks is None else ())
        none = (0.0,) * len(self.motor_weights)
        for name, behind in {"H_f": self.motor_weights, "f_p": none, "H_r": none}.items():
            if name in arrays:
                arrays[name] += behind  # those of motors
        native = self.space == "joint" and self.own_law is None
        law = number_of(str(self.type)) if native else 0
        return arrays | {"law": law, "passive": self.unfollowing}

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """As of any table; without what only counts in operational space where it does not."""
        if self.space == "joint":
            whole = super().data([*leave_out, *_OF_TASKS])
            return whole | ({"norm": INFINITY} if math.isinf(self.norm) else {})
        exact = [w if math.isfinite(w) else EXACT for w in self.task_weights]
        nothing = dict.fromkeys(("posture", "limit_bandwidth"), False)
        return nothing | super().data(leave_out) | {"task_weights": exact}


_OF_TASKS = (
    *("posture", "task_weights", "priorities", "acceleration_weights", "force_rate_weights"),
    "limit_bandwidth",
)
"""What counts in operational space alone."""


def read_controller(
    data: Mapping[str, Any],
    context: Context,
    run: RunSettings,
    reference: ReferenceSettings,
    start: StartSettings,
) -> ControllerSettings:
    """The controller's settings."""
    fitting = [name for name, known in TYPES.items() if known.space == reference.space]
    name = data.get("type", fitting[0])
    law = control_type(name, data.get("space"))
    if law.space != reference.space:
        what = f"{name!r} does not follow a reference in {reference.space} space"
        ours = f"use {' or '.join(map(repr, fitting))}"
        what += f"; {ours if OwnLaw.of(name) is None else 'say what it follows by space'}"
        raise context.error("controller.type", what)
    exact = math.inf if law.task_weight is None else law.task_weight
    weights = dict.fromkeys(("weights", "motor_weights"), law.force_weight)
    defaults = weights | {"task_weights": exact, "q0": start.q}
    settings = ControllerSettings.read(
        {"type": name, "period": run.step, **data},
        replace(context, defaults=defaults),
        "controller",
    )
    if settings.unfollowing and all(settings.unfollowing):
        raise context.error("controller.passive", "leaves no coordinate to follow")
    require_multiple(
        settings.period, run.step, "run.step", file=context.file, key="controller.period"
    )
    if settings.own_law is None:
        return settings
    own = settings.own_law._replace(file=context.file.parent / settings.own_law.file)
    own.require()
    return settings.replaced(type=str(own))
