"""Settings of [motion.cost]."""

from __future__ import annotations

from typing import Self

from pydantic import field_validator, model_validator

from cardsflow_fmu.experiment.config.custom_law import CUSTOM_LAW_FORM, CustomLaw
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import File, FromZero, Table, Text, setting


class TrackingSettings(Table):
    """Cost of deviations from a recorded motion, for a fixed duration: integrals over time."""

    file: File = setting("recorded motion, as in [reference]; it starts with the motion")
    q: tuple[FromZero, ...] = named_setting(
        "coordinate", "weight of the squared deviations of joint positions", 0.0
    )
    y: tuple[FromZero, ...] = named_setting(
        "task coordinate", "weight of the squared deviations of task coordinates", 0.0
    )

    @model_validator(mode="after")
    def _check_weights(self) -> Self:
        if {"q", "y"} <= self.model_fields_set:
            raise SettingError("excludes q; remove one of them", key="y")
        if not {"q", "y"} & self.model_fields_set:
            raise SettingError("missing; set q or y", key="q")
        return self


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
    accelerations: tuple[FromZero, ...] = named_setting(
        "coordinate", "weight of the squared joint accelerations, averaged over an interval", 0.0
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
    tracking: TrackingSettings = setting("cost of deviations from a recorded motion", None)
    function: Text = setting(
        "custom cost as `file.py:Class`, a subclass of `controllers.MotionCost`", None
    )

    @field_validator("function")
    @classmethod
    def _check_function(cls, value: str | None) -> str | None:
        if value is not None and CustomLaw.of(value) is None:
            raise SettingError(f"must be {CUSTOM_LAW_FORM}, not {value!r}")
        return value
