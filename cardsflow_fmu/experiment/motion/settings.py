"""Settings of [motion]: an optimal motion from the start to goals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.muscle_laws import states_of
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import AS_WHOLE, Listed, Positive, Table, setting

from .bounds import MotionBoundSettings, ObstacleSettings
from .costs import MotionCostSettings
from .goals import FREE, GoalSettings, MotionStartSettings
from .parameters import ParameterSettings

MAX_SUBSTEPS = 256
FREE_STARTS = {"start", "periodic"}
"""Keys of [motion] with which the optimisation chooses a part of the start."""


def _range(value: Any) -> tuple[float, float]:
    """Return a duration as a range."""
    pair = list(value) if isinstance(value, list | tuple) else [value, value]
    is_number = [isinstance(k, int | float) and not isinstance(k, bool) for k in pair]
    if len(pair) != 2 or not all(is_number):
        problem = "must be a number, or a list of the smallest and the largest duration"
        raise SettingError(f"{problem}, not {value!r}")
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


class MotionFeedbackSettings(Table):
    """Deviations from the motion that cost as much as its largest forces, for the gains."""

    q: tuple[Positive, ...] = named_setting(
        "coordinate", "deviation of a joint position, in rad or m", 0.005
    )
    qd: tuple[Positive, ...] = named_setting(
        "coordinate", "deviation of a joint velocity, in rad/s or m/s (default: no cost)", None
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
        "states of the muscle laws (default: laws if a muscle has an activation, else forces)",
        None,
    )
    start: MotionStartSettings = setting("start that the optimisation chooses", {})
    start_command: tuple[float, ...] = named_setting(
        "muscle",
        'commands with which the muscles rest at the start, with `muscles = "laws"` (default: '
        "those that hold the robot)",
        None,
        others=FREE,
    )
    goals: Annotated[tuple[GoalSettings, ...], Listed] = setting("the goals", ())
    periodic: tuple[float, ...] = named_setting(
        "coordinate",
        "coordinates that return at the end, except for an advance in rad or m, with the same "
        "velocity, which is free: { crank = 6.283, hip = 0.0 }",
        None,
        others=FREE,
    )
    obstacles: Annotated[tuple[ObstacleSettings, ...], Listed] = setting(
        "spheres and capsules that parts of the robot must not enter", ()
    )
    cost: MotionCostSettings = setting("the cost (default: squared forces)", {})
    bounds: MotionBoundSettings = setting("bounds, in addition to those of the robot", {})
    parameters: Annotated[tuple[ParameterSettings, ...], Listed] = setting(
        "numbers of the robot that the optimisation chooses together with the motion", ()
    )
    feedback: MotionFeedbackSettings = setting(
        "tracking accuracy for which the feedback gains are computed", {}
    )
    max_iterations: Annotated[int, Field(ge=1, le=10_000), AS_WHOLE] = setting(
        "maximum number of iterations", 200
    )

    @model_validator(mode="after")
    def _check_muscles(self) -> Self:
        if self.muscles is None:
            return self
        other_costs = ["commands", "activations"] if self.muscles == "forces" else ["forces"]
        keys = [f"cost.{key}" for key in other_costs if key in self.cost.model_fields_set]
        limits = {"u_min", "u_max"} & self.bounds.model_fields_set
        if self.muscles == "forces":
            keys += [f"bounds.{key}" for key in sorted(limits)]
            keys += ["start_command"] if self.start_command else []
        if keys:
            other = "laws" if self.muscles == "forces" else "forces"
            raise SettingError(f'requires motion.muscles = "{other}"', key=keys[0])
        return self

    @model_validator(mode="after")
    def _check_goals(self) -> Self:
        tracking = self.cost.tracking
        if not (self.goals or self.periodic or tracking):
            problem = "must have at least one table"
            raise SettingError(f"{problem}; or set periodic or cost.tracking", key="goals")
        if tracking and self.duration[0] < self.duration[1]:
            raise SettingError("requires a fixed duration", key="cost.tracking")
        for k, goal in enumerate(self.goals):
            try:
                goal.check_times(*self.duration)
            except SettingError as error:
                for each in error.errors:
                    each.key = f"goals[{k}].{each.key}"
                raise
        return self


def with_default_muscles(motion: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Return [motion] with the default of `muscles` for a robot: muscles follow activations."""
    states = (state for muscle in robot.muscles for state in states_of(muscle.model))
    has_activation = any(state.name == "activation" for state in states)
    return {"muscles": "laws" if has_activation else "forces", **motion}
