"""Settings of [motion]: an optimal motion from the start to goals."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    FromZero,
    Listed,
    Positive,
    Table,
    Vector3,
    setting,
)

MAX_SUBSTEPS = 256
_FREE = math.nan  # value of names that a table omits


def _range(value: Any) -> tuple[float, float]:
    """Return a duration as a range."""
    pair = list(value) if isinstance(value, list | tuple) else [value, value]
    is_number = [isinstance(k, int | float) and not isinstance(k, bool) for k in pair]
    if len(pair) != 2 or not all(is_number):
        what = "must be a number, or a list of the smallest and the largest duration"
        raise SettingError(f"{what}, not {value!r}")
    try:
        low, high = map(float, pair)
    except OverflowError:
        low = high = math.inf
    if not (0.0 < low < math.inf and 0.0 < high < math.inf):
        raise SettingError("must be positive and finite")
    if high < low:
        raise SettingError(f"must increase, not {value!r}")
    return low, high


Duration = Annotated[
    tuple[float, float],
    BeforeValidator(_range),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "exclusiveMinimum": 0},
                {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
            ]
        }
    ),
]


class GoalSettings(Table):
    """Goal that the motion reaches exactly; omitted coordinates are free."""

    time: FromZero = setting("time, in s (default: the end)", None)
    q: tuple[float, ...] = named_setting(
        "coordinate", "joint positions, in rad or m", None, others=_FREE
    )
    y: tuple[float, ...] = named_setting(
        "task coordinate", "task coordinates, in m or rad", None, others=_FREE
    )
    rest: bool = setting("joint velocities are 0 (default: only at the end)", None)

    @model_validator(mode="after")
    def _check_goal(self) -> Self:
        if not self.model_fields_set & {"q", "y", "rest"}:
            raise SettingError("missing; set q or y", key="q")
        return self


class ObstacleSettings(Table):
    """Sphere that an end-effector point must not enter, at the nodes between intervals."""

    centre: Vector3 = setting("centre, in the world frame, in m")
    radius: Positive = setting("radius, in m")
    points: Annotated[tuple[str, ...], Listed] = setting(
        "names of the task frames (default: all points)", ()
    )


class MotionCostSettings(Table):
    """Cost of the motion: weights of integrals over time, and of the duration."""

    forces: tuple[FromZero, ...] = named_setting(
        "actuator",
        "weight of the squared muscle forces and motor torques (default: 1 without other costs)",
        0.0,
    )
    force_rates: tuple[FromZero, ...] = named_setting(
        "actuator", "weight of the squared rates of the forces and torques", 0.0
    )
    speeds: tuple[FromZero, ...] = named_setting(
        "coordinate", "weight of the squared joint velocities", 0.0
    )
    commands: tuple[FromZero, ...] = named_setting(
        "actuator",
        'weight of the squared commands, with `muscles = "laws"` (default: 1 without other costs)',
        0.0,
    )
    activations: tuple[FromZero, ...] = named_setting(
        "muscle", 'weight of the squared activations, with `muscles = "laws"`', 0.0
    )
    time: FromZero = setting("weight of the duration", 0.0)


class MotionBoundSettings(Table):
    """Bounds of the motion, in addition to those of the robot."""

    f_min: tuple[float, ...] = named_setting(
        "actuator", "minimum forces and torques (default: of the robot)", None, others=_FREE
    )
    f_max: tuple[float, ...] = named_setting(
        "actuator", "maximum forces and torques (default: of the robot)", None, others=_FREE
    )
    u_min: tuple[float, ...] = named_setting(
        "muscle", "minimum commands (default: of the muscle law)", None, others=_FREE
    )
    u_max: tuple[float, ...] = named_setting(
        "muscle", "maximum commands (default: of the muscle law)", None, others=_FREE
    )
    q_min: tuple[float, ...] = named_setting(
        "coordinate", "minimum joint positions (default: joint limits)", None, others=_FREE
    )
    q_max: tuple[float, ...] = named_setting(
        "coordinate", "maximum joint positions (default: joint limits)", None, others=_FREE
    )
    qd_max: tuple[FromZero, ...] = named_setting(
        "coordinate", "maximum joint speeds, in rad/s or m/s (default: none)", None, others=_FREE
    )


class MotionTable(Table):
    """Optimal motion from the start to its goals, for `cardsflow optimise`."""

    duration: Duration = setting(
        "duration, in s; or its smallest and largest value, [0.2, 2.0], if it is free"
    )
    intervals: Annotated[int, Field(ge=2, le=10_000), AS_WHOLE] = setting(
        "number of intervals, each with constant forces", 50
    )
    substeps: Annotated[int, Field(ge=1, le=MAX_SUBSTEPS), AS_WHOLE] = setting(
        "Runge-Kutta steps per interval; doubled until the intervals are accurate", 1
    )
    muscles: Literal["forces", "laws"] = setting(
        "forces: the motion has tensions; laws: it has commands, such as excitations, and the "
        "states of the muscle laws",
        "forces",
    )
    start_command: tuple[float, ...] = named_setting(
        "muscle",
        'commands with which the muscles rest at the start, with `muscles = "laws"` (default: '
        "those that hold the robot)",
        None,
        others=_FREE,
    )
    goals: Annotated[tuple[GoalSettings, ...], Listed, Field(min_length=1)] = setting("the goals")
    obstacles: Annotated[tuple[ObstacleSettings, ...], Listed] = setting(
        "spheres that end-effector points must not enter", ()
    )
    cost: MotionCostSettings = setting("the cost (default: squared forces)", {})
    bounds: MotionBoundSettings = setting("bounds, in addition to those of the robot", {})
    max_iterations: Annotated[int, Field(ge=1, le=10_000), AS_WHOLE] = setting(
        "maximum number of iterations", 200
    )

    @model_validator(mode="after")
    def _check_muscles(self) -> Self:
        own = ["commands", "activations"] if self.muscles == "forces" else ["forces"]
        found = [f"cost.{key}" for key in own if key in self.cost.model_fields_set]
        limits = {"u_min", "u_max"} & self.bounds.model_fields_set
        if self.muscles == "forces":
            found += [f"bounds.{key}" for key in sorted(limits)]
            found += ["start_command"] if self.start_command else []
        if found:
            other = "laws" if self.muscles == "forces" else "forces"
            raise SettingError(f'requires motion.muscles = "{other}"', key=found[0])
        return self

    @model_validator(mode="after")
    def _check_goals(self) -> Self:
        low, high = self.duration
        for k, goal in enumerate(self.goals):
            if goal.time is None:
                continue
            if low < high:
                what = "requires a fixed duration; omit it for a goal at the end"
                raise SettingError(what, key=f"goals[{k}].time")
            if goal.time > high:
                what = f"must be within the duration, {high!r} s, not {goal.time!r} s"
                raise SettingError(what, key=f"goals[{k}].time")
        return self
