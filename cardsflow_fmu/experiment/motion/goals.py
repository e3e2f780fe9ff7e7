"""Settings of the goals of a motion, and of its start."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import model_validator

from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    Fraction,
    FromZero,
    Listed,
    Positive,
    Table,
    Text,
    setting,
)

FREE = math.nan
"""Value of names that a table omits."""


class MotionStartSettings(Table):
    """Start that the optimisation chooses; the rest of the start is that of [start]."""

    free: Annotated[tuple[Text, ...], Listed] = setting(
        'coordinates with a free position, or ["*"] for all (default: none; all with y)', ()
    )
    free_speeds: Annotated[tuple[Text, ...], Listed] = setting(
        'coordinates with a free velocity, or ["*"] for all (default: none)', ()
    )
    free_states: bool = setting(
        "whether states of muscles, such as activations, are free (default: if a position or "
        "velocity is free)",
        None,
    )
    y: tuple[float, ...] = named_setting(
        "task coordinate", "task coordinates at the start, in m or rad", None, others=FREE
    )


class GoalSettings(Table):
    """Goal of the motion; omitted coordinates are free."""

    time: FromZero = setting("time, in s (default: the end)", None)
    fraction: Fraction = setting("time as a fraction of the duration, which may be free", None)
    hold: Positive = setting("time for which the robot rests at the goal, in s", None)
    q: tuple[float, ...] = named_setting(
        "coordinate", "joint positions, in rad or m", None, others=FREE
    )
    y: tuple[float, ...] = named_setting(
        "task coordinate", "task coordinates, in m or rad", None, others=FREE
    )
    qd: tuple[float, ...] = named_setting(
        "coordinate", "joint velocities, in rad/s or m/s", None, others=FREE
    )
    yd: tuple[float, ...] = named_setting(
        "task coordinate", "velocities of task coordinates, in m/s or rad/s", None, others=FREE
    )
    rest: bool = setting(
        "joint velocities are 0 (default: only at the end, without qd and yd)", None
    )
    weight: Positive = setting(
        "weight of the squared deviations, in the cost (default: they are 0)", None
    )

    @property
    def is_moving(self) -> bool:
        """Whether the goal contains velocities."""
        return bool(self.qd or self.yd)

    @model_validator(mode="after")
    def _check_goal(self) -> Self:
        if not self.model_fields_set & {"q", "y", "qd", "yd", "rest"}:
            raise SettingError("missing; set q, y, qd or yd", key="q")
        if self.time is not None and self.fraction is not None:
            raise SettingError("excludes time; remove one of them", key="fraction")
        if self.hold is not None and self.rest is False:
            raise SettingError("excludes rest = false; the robot rests while it holds", key="hold")
        if self.is_moving and (self.rest or self.hold is not None):
            key = "rest" if self.rest else "hold"
            raise SettingError("excludes qd and yd; remove them or this key", key=key)
        return self

    def check_times(self, low: float, high: float) -> None:
        """Check times against the smallest and the largest duration, in [s]."""
        for key, time in (("time", self.time), ("hold", self.hold)):
            if time is None:
                continue
            if low < high:
                hint = "use fraction, or omit it for a goal at the end" if key == "time" else ""
                problem = f"requires a fixed duration{'; ' * bool(hint)}{hint}"
                raise SettingError(problem, key=key)
            if time > high:
                problem = f"must be within the duration, {high!r} s, not {time!r} s"
                raise SettingError(problem, key=key)
