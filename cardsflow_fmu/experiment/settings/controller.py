"""Settings of [controller]: control law, gains, weights, and sampling."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.config.custom_law import CustomLaw
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    OR_FALSE,
    Context,
    File,
    FromZero,
    Positive,
    Table,
    setting,
)
from controllers.laws.operational_space import LIMIT_BANDWIDTH
from controllers.qp.law_in_c import number_of
from controllers.qp.solver import DEFAULT_SOLVER
from controllers.validation import MAX_PRETENSION
from sim_dart.plant.settings import Engine

from .controller_types import (
    EXACT,
    FEEDBACK,
    INFINITY,
    JOINT_ACCELERATION,
    OPERATIONAL,
    POLICY,
    TYPES,
    ControlType,
    Law,
    Norm,
    Rank,
    Solver,
    Weight,
    control_type,
)
from .plant import StartSettings
from .predictive import MPC, PredictiveBoundSettings, PredictiveCostSettings
from .run import RunSettings

MAX_HORIZON = 1e6
"""Maximum prediction horizon, in [s]. Much larger values would overflow the predicted forces."""


class PostureSettings(Table):
    """Posture of a redundant robot in the null space of its tasks; see `controllers.Posture`."""

    kp: tuple[FromZero, ...] = named_setting(
        "coordinate", "position gain, in 1/s²", 25.0, symbol="posture_kp"
    )
    kd: tuple[FromZero, ...] = named_setting(
        "coordinate", "velocity gain, in 1/s", 10.0, symbol="posture_kd"
    )
    q0: tuple[float, ...] = named_setting(
        "coordinate", "preferred posture, in rad or m (default: start pose)", None, symbol="q0"
    )


_OPEN = (MPC, POLICY)
"""Types that control either space."""

_PER_NODE, _TIME_CONSTANTS = 0.5, 10.0  # slowest time constants per interval, and in a horizon
_MAX_DEFAULT_HORIZON = 1.0  # in [s]; robots that fall without control diverge in longer ones


def _require_gains_of_laws(schema: dict[str, Any]) -> None:
    """Require gains in the JSON Schema only for types that use them."""
    of_motion = {"properties": {"type": {"enum": [FEEDBACK, POLICY]}}, "required": ["type"]}
    own_law = {"properties": {"type": {"pattern": "[.]py:"}}, "required": ["type"]}
    gains = {"required": schema.pop("required")}
    schema |= {"if": {"anyOf": [of_motion, own_law]}, "else": gains}


class ControllerSettings(Table):
    """Control law, gains, weights, and sampling."""

    model_config = ConfigDict(json_schema_extra=_require_gains_of_laws)

    type: Law = setting("control law; a custom law as `file.py:Class`", None)
    policy: File | None = setting("file of the policy, for the type `policy`", None)
    custom_space: Literal["joint", "operational"] = setting(
        "space that a custom law, a policy or mpc controls (default: joint; mpc: of the reference)",
        None,
        alias="space",
    )
    kp: tuple[Positive, ...] = named_setting("followed", "position gain, in 1/s²", symbol="kp")
    kd: tuple[FromZero, ...] = named_setting("followed", "velocity gain, in 1/s", symbol="kd")
    ki: tuple[FromZero, ...] = named_setting("followed", "integral gain, in 1/s³", 0.0, symbol="ki")
    period: Positive = setting(
        "sampling period, in s; a multiple of run.step (default: run.step)", None
    )
    solver: Solver = setting("QP solver: dual_newton, or a solver of qpsolvers", DEFAULT_SOLVER)
    weights: tuple[Positive, ...] = named_setting(
        "muscle", "weight of squared muscle forces, in 1/N²", None, symbol="H_f"
    )
    motor_weights: tuple[Positive, ...] = named_setting(
        "motor", "weight of squared motor torques, in 1/(N·m)² or 1/N²", None
    )
    norm: Norm = setting("norm of the forces that joint-space laws minimise", 2.0, symbol="norm")
    pretension: tuple[Annotated[FromZero, Field(le=MAX_PRETENSION)], ...] = named_setting(
        "muscle", "preferred force, in N", 0.0, symbol="f_p"
    )
    passive: tuple[bool, ...] = named_setting(
        "coordinate", "the coordinate is not controlled; its spring and damper move it", False
    )
    dependent: tuple[bool, ...] = named_setting(
        "coordinate",
        "the closed loops determine the coordinate (default: chosen from the loops)",
        False,
    )
    observer: FromZero = setting(
        "bandwidth of the disturbance observer, in rad/s; 0: no observer", 0.0
    )
    delay: Annotated[int, Field(ge=0, le=1), AS_WHOLE] = setting(
        "delay between measurement and force, in sampling periods", 0, symbol="delay"
    )
    predict: bool = setting("compensate for the delay by prediction", True, symbol="predict")
    muscle_horizon: Annotated[FromZero, Field(le=MAX_HORIZON)] = setting(
        "prediction horizon of muscle commands, in s; 0: the next ticks", 0.0
    )
    engine: Engine = setting("implementation of the dynamics; auto: core", "auto")
    posture: Annotated[PostureSettings | None, OR_FALSE] = setting(
        "posture control in the null space of the tasks; false: none", {}
    )
    task_weights: tuple[Weight, ...] = named_setting(
        "task coordinate", 'weight of a task; "exact": the task is a constraint', None, symbol="W"
    )
    priorities: tuple[Rank, ...] = named_setting(
        "task coordinate", "priority of a task; 1 is the highest", 1.0, symbol="priority"
    )
    acceleration_weights: tuple[Positive, ...] = named_setting(
        "coordinate", "weight of squared joint accelerations", 1.0, symbol="H_q"
    )
    force_rate_weights: tuple[FromZero, ...] = named_setting(
        "muscle", "weight of squared force changes", 0.0, symbol="H_r"
    )
    limit_bandwidth: Annotated[Positive | None, OR_FALSE] = setting(
        "bandwidth of the joint limits, in rad/s; false: ignore joint limits",
        LIMIT_BANDWIDTH,
        symbol="limit_bandwidth",
    )

    horizon: Positive | None = setting(
        "mpc: duration of the predicted motion, in s (default: half the slowest time constant of "
        "kp and kd per node; at most 10 of them, and 1 s)",
        None,
    )
    nodes: Annotated[int, Field(ge=2, le=200), AS_WHOLE] = setting(
        "mpc: number of intervals of the predicted motion, each with constant forces", 20
    )
    iterations: Annotated[int, Field(ge=1, le=1000), AS_WHOLE] = setting(
        "mpc: maximum number of solver iterations in a tick; four times as many in the first one",
        50,
    )
    deadline: Positive | None = setting(
        "mpc: time for a tick, in s of a real clock; if the solver needs longer, computed torque "
        "determines the forces, so runs are not reproducible (default: none)",
        None,
    )
    cost: PredictiveCostSettings = setting("mpc: cost of the predicted motion", {})
    bounds: PredictiveBoundSettings = setting("mpc: bounds of the predicted motion", {})

    @model_validator(mode="after")
    def _check_predictive(self) -> Self:
        if self.type not in (None, MPC):
            self.require_only(key for key in type(self).model_fields if key not in _MPC_KEYS)
        if self.type == MPC and self.solver != DEFAULT_SOLVER:
            raise SettingError(f"must be {DEFAULT_SOLVER!r} for {MPC!r}", key="solver")
        return self

    feedforward: bool = setting(
        "computed torque uses the forces nearest to those of the optimal motion", False
    )
    gains: File = setting(
        "file of the gains of an optimal motion, for trajectory_feedback or feedforward (default: "
        "`motion.gains.csv` for the reference `motion.csv`)",
        None,
    )

    @model_validator(mode="after")
    def _check_feedback(self) -> Self:
        if self.type == FEEDBACK:
            self.require_only((*_FEEDBACK_KEYS, "dependent"))
        elif self.gains is not None and not self.feedforward:
            problem = f"requires controller.type = {FEEDBACK!r} or controller.feedforward = true"
            raise SettingError(problem, key="gains")
        is_other = self.custom_law is not None or self.type in _OPEN
        if self.feedforward and (is_other or self.solver != DEFAULT_SOLVER):
            problem = f"requires a law of computed torque with the solver {DEFAULT_SOLVER!r}"
            raise SettingError(problem, key="feedforward")
        if self.uses_gains and self.engine == "dart":
            raise SettingError("must not be 'dart' with the gains of a motion", key="engine")
        return self

    @model_validator(mode="after")
    def _check_space(self) -> Self:
        if self.custom_space is not None and self.custom_law is None and self.type not in _OPEN:
            raise SettingError("is only for custom laws, policies and mpc; remove it", key="space")
        if (self.type == POLICY) != (self.policy is not None):
            problem = "is only for the type 'policy'; remove it"
            raise SettingError("missing" if self.policy is None else problem, key="policy")
        is_open = self.custom_space is None and (self.custom_law is not None or self.type == MPC)
        if self.type is not None and self.space == "joint" and not is_open:
            self.require_only(key for key in type(self).model_fields if key not in _TASK_KEYS)
        if any(self.passive) and self.type is not None and self.type not in JOINT_ACCELERATION:
            laws = " or ".join(map(repr, JOINT_ACCELERATION))
            problem = f"requires a controller of type {laws}, not {self.type!r}"
            raise SettingError(problem, key="passive")
        if self.norm != 2.0 and self.type is not None and self.space == "operational":
            problem = f"requires a joint-space law; {self.type!r} always uses the 2-norm"
            raise SettingError(problem, key="norm")
        closing = (*JOINT_ACCELERATION, *OPERATIONAL)
        if any(self.dependent) and self.type is not None and self.type not in closing:
            laws = " or ".join(repr(name) for name in closing if name != MPC)
            problem = f"must be {laws} for a robot with closed loops, not {self.type!r}"
            raise SettingError(problem, key="type")
        return self

    @property
    def predicted_time(self) -> float:
        """Duration of the predicted motion, in [s]: `horizon`, or its default."""
        if self.horizon:
            return self.horizon
        idle = self.uncontrolled if self.space == "joint" else (False,) * len(self.kp)
        gains = zip(self.kp, self.kd, idle, strict=True)
        rates = [_slowest_rate(kp, kd) for kp, kd, is_idle in gains if not is_idle]
        time_constants = min(_PER_NODE * self.nodes, _TIME_CONSTANTS)
        return min(time_constants / min(rates), _MAX_DEFAULT_HORIZON)

    @property
    def custom_law(self) -> CustomLaw | None:
        """The custom law; None for a built-in law."""
        return None if self.type is None else CustomLaw.of(self.type)

    @property
    def uses_gains(self) -> bool:
        """Whether the controller reads the forces and gains of an optimal motion."""
        return self.type == FEEDBACK or self.feedforward

    @property
    def law(self) -> ControlType:
        """Properties of the law."""
        return control_type(self.type, self.custom_space)

    @property
    def space(self) -> Space:
        """Controlled space: joint positions or task coordinates."""
        return self.law.space

    @property
    def torque_gains(self) -> bool:
        """Whether the gains convert errors to torques instead of accelerations."""
        return self.law.torque_gains

    @property
    def tasks(self) -> ControllerSettings | None:
        """Settings of an operational-space law (posture, weights, priorities); otherwise None."""
        return None if self.space == "joint" else self

    @property
    def uncontrolled(self) -> tuple[bool, ...]:
        """Flags of coordinates without a reference: passive and dependent coordinates."""
        return tuple(a or b for a, b in zip(self.passive, self.dependent, strict=True))

    def law_arrays(self) -> dict[str, Any]:
        """Return the arrays of the law and of the control loop in C, by their C names.

        Arrays of muscles end with the values of motors. See `computed_torque.h` and
        `control_loop.h`.
        """
        arrays = self.arrays(_TASK_KEYS if self.tasks is None else ())
        none = (0.0,) * len(self.motor_weights)
        for name, motor_values in {"H_f": self.motor_weights, "f_p": none, "H_r": none}.items():
            if name in arrays:
                arrays[name] += motor_values
        native = self.space == "joint" and self.custom_law is None and self.type != POLICY
        name = {MPC: _FALLBACK, FEEDBACK: _FALLBACK}.get(str(self.type), str(self.type))
        law = number_of(name) if native else 0
        return arrays | {"law": law, "passive": self.uncontrolled}

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data; joint-space laws omit operational-space keys."""
        if self.type == FEEDBACK:
            return super().data({*type(self).model_fields, "space"} - set(_FEEDBACK_KEYS))
        leave_out = [*leave_out, *(() if self.type == MPC else _MPC_KEYS)]
        if self.space == "joint":
            values = super().data([*leave_out, *_TASK_KEYS])
            return values | ({"norm": INFINITY} if math.isinf(self.norm) else {})
        exact = [w if math.isfinite(w) else EXACT for w in self.task_weights]
        nothing = dict.fromkeys(("posture", "limit_bandwidth"), False)
        return nothing | super().data(leave_out) | {"task_weights": exact}


_TASK_KEYS = (
    *("posture", "task_weights", "priorities", "acceleration_weights", "force_rate_weights"),
    "limit_bandwidth",
)
"""Keys of operational-space laws."""
_MPC_KEYS = ("horizon", "nodes", "iterations", "deadline", "cost", "bounds")
"""Keys of model predictive control."""
_FALLBACK = "joint_space"
"""Law in joint space if model predictive control has no solution; unused by trajectory_feedback."""
_FEEDBACK_KEYS = ("type", "period", "gains", "engine", "kp", "kd")
"""Keys of the feedback along an optimal motion."""


def _slowest_rate(kp: float, kd: float) -> float:
    """Return the decay of the slowest error of predictive control with default costs, in [1/s]."""
    half = max(kd, math.sqrt(2.0 * kp)) / 2.0
    return min(half, kp / (half + math.sqrt(max(half**2 - kp, 0.0))))


def read_controller(
    data: Mapping[str, Any],
    context: Context,
    run: RunSettings,
    space: Space,
    start: StartSettings,
) -> ControllerSettings:
    """Read the table [controller], for a reference in a space."""
    fitting = [name for name, entry in TYPES.items() if entry.space == space]
    name = data.get("type", fitting[0])
    if name == MPC:
        data = {"space": space, **data}
    law = control_type(name, data.get("space"))
    if law.space != space:
        problem = f"{name!r} cannot follow a reference in {space} space"
        hint = f"use {' or '.join(map(repr, fitting))}"
        custom = f'set controller.space = "{space}"'
        is_open = name in (MPC, POLICY) or CustomLaw.of(name) is not None
        problem += f"; {custom if is_open else hint}"
        raise context.error("controller.type", problem)
    exact = math.inf if law.task_weight is None else law.task_weight
    weights = dict.fromkeys(("weights", "motor_weights"), law.force_weight)
    defaults = weights | {"task_weights": exact, "q0": start.q}
    settings = ControllerSettings.read(
        {"type": name, "period": run.step, **data},
        replace(context, defaults=defaults),
        "controller",
    )
    if settings.uncontrolled and all(settings.uncontrolled):
        raise context.error(
            "controller.passive", "at least one coordinate must not be passive or dependent"
        )
    _check_times(settings, context, run)
    if settings.custom_law is None:
        return settings
    custom_law = settings.custom_law._replace(file=context.file.parent / settings.custom_law.file)
    custom_law.require()
    return settings.copy_with(type=str(custom_law))


def _check_times(settings: ControllerSettings, context: Context, run: RunSettings) -> None:
    """Check the period, and horizon and deadline of model predictive control."""
    period = settings.period
    require_multiple(period, run.step, "run.step", file=context.file, key="controller.period")
    if settings.type == MPC and (horizon := settings.predicted_time) <= period:
        problem = f"must be longer than the period, {period!r} s, not {horizon!r} s"
        raise context.error("controller.horizon", problem)
    if settings.deadline is not None and settings.deadline > period:
        problem = f"must be at most the period, {period!r} s, not {settings.deadline!r} s"
        raise context.error("controller.deadline", problem)
