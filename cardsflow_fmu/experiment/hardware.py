"""Reading and writing [hardware]: where the hardware is, and what it may never do."""

from __future__ import annotations

import math
from typing import Any, cast

from addin_sdfusion.robot import Robot
from cardsflow_fmu.config.table import Table

from .emulator import emulator_data, read_emulator
from .hardware_settings import (
    COMMAND_KINDS,
    LONGEST_RAMP_DOWN,
    MODES,
    CommandKind,
    EmulatorSettings,
    HardwareSettings,
    Mode,
    MotorSettings,
    SafetySettings,
)

_WATCHDOG = 0.02
_WATCHDOG_STEPS = 5
_TOLERANCE, _MARGIN = 0.1, 0.05


def read_hardware(table: Table, robot: Robot, step: float) -> HardwareSettings:
    """What an experiment says of its hardware; everything has a default.

    Args:
        table: The table [hardware].
        robot: The robot.
        step: Communication step of the runs, in [s].

    Raises:
        InputError: Something in it is wrong.
    """
    settings = HardwareSettings(
        link=table.text("link", ""),
        use=table.flag("use", False),
        mode=cast(Mode, table.choice("mode", "mode", MODES, "realtime")),
        bind=table.text("bind", ""),
        key_file=table.file.parent / table.text("key_file") if "key_file" in table else None,
        max_missed=table.whole("max_missed", 10),
        watchdog=table.positive("watchdog", max(_WATCHDOG, _WATCHDOG_STEPS * step)),
        timeout=table.positive("timeout", 1.0),
        scale=table.positive("scale", 1.0),
        has_lengths=table.flag("has_lengths", True),
        has_tensions=table.flag("has_tensions", True),
        approach=table.positive("approach") if "approach" in table else None,
        safety=_safety(table, robot),
        motors=_motors(table.table("motors"), robot),
        emulator=read_emulator(table.table("emulator")),
    )
    for key in ("key_file", "approach"):
        table.value(key, None)
    table.close()
    _check(settings, table, step)
    return settings


def _check(settings: HardwareSettings, table: Table, step: float) -> None:
    if settings.max_missed < 0:
        raise table.error("max_missed", f"must not be negative: {settings.max_missed}")
    if settings.is_paced and settings.watchdog < 2.0 * step:
        what = f"{settings.watchdog!r} s is shorter than two of run.step, {step!r} s"
        raise table.error("watchdog", f"{what}: the device would not keep running")
    if settings.approach is not None:
        table.multiple("approach", settings.approach, step, "run.step")
    if settings.emulator.faults.any and settings.link.startswith("loopback"):
        raise table.error("emulator", "frames of loopback: meet no faults; use link = 'emulated:'")
    if settings.safety.tension_max and not settings.has_tensions:
        raise table.error("tension_max", "limits what has_tensions = false says is not measured")


def _safety(table: Table, robot: Robot) -> SafetySettings:
    coordinates = [c.name for c in robot.coordinates]
    muscles = [muscle.name for muscle in robot.muscles]
    settings = SafetySettings(
        ramp_in=_from_zero(table, "ramp_in", 0.2),
        ramp_down=_from_zero(table, "ramp_down", 0.5),
        force_rate=_limits(table, "force_rate", muscles),
        tension_max=_limits(table, "tension_max", muscles),
        position_margin=table.by_name("position_margin", "coordinate", coordinates, _MARGIN),
        start_tolerance=table.by_name("start_tolerance", "coordinate", coordinates, _TOLERANCE),
    )
    if settings.ramp_down > LONGEST_RAMP_DOWN:
        what = f"must be at most {LONGEST_RAMP_DOWN:g} s, not {settings.ramp_down!r}"
        raise table.error("ramp_down", f"{what}: hosts of FMUs do not wait for longer")
    for key in ("position_margin", "start_tolerance"):
        if min(getattr(settings, key), default=0.0) < 0:
            raise table.error(key, "must not be negative")
    return settings


def _from_zero(table: Table, key: str, default: float) -> float:
    value = table.number(key, default)
    if value < 0:
        raise table.error(key, f"must not be negative: {value!r}")
    return value


def _limits(table: Table, key: str, muscles: list[str]) -> tuple[float, ...]:
    """A limit for every muscle, infinite where a table by name leaves one out; () for none."""
    if key not in table:
        table.value(key, None)
        return ()
    given = table.value(key)
    if given == {}:
        return ()
    if isinstance(given, dict):
        limits = Table(given, table.file, table.key(key))
        values = tuple(limits.number(n) if n in limits else math.inf for n in muscles)
        for name in muscles:
            limits.value(name, None)
        limits.close()
    else:
        values = table.by_name(key, "muscle", muscles)
    if min(values) <= 0:
        raise table.error(key, "must be above 0")
    return values


def _motors(table: Table, robot: Robot) -> MotorSettings:
    command = cast(CommandKind, table.choice("command", "command", COMMAND_KINDS, "force"))
    if command == "force":
        table.close()
        return MotorSettings()
    muscles = [muscle.name for muscle in robot.muscles]

    def positive(key: str) -> tuple[float, ...]:
        values = table.by_name(key, "muscle", muscles)
        if min(values) <= 0:
            raise table.error(key, "must be above 0")
        return values

    def optional(key: str) -> tuple[float, ...]:
        if key in table:
            return positive(key)
        table.value(key, None)
        return ()

    damping = table.by_name("damping", "muscle", muscles, 0.0)
    if min(damping) < 0:
        raise table.error("damping", "must not be negative")
    takes_start = table.value("offset", 0.0) == "start"
    settings = MotorSettings(
        command,
        stiffness=positive("stiffness"),
        damping=damping,
        spindle_radius=optional("spindle_radius"),
        encoder_scale=optional("encoder_scale"),
        offset=None if takes_start else table.by_name("offset", "muscle", muscles, 0.0),
    )
    table.close()
    return settings


def hardware_data(settings: HardwareSettings, robot: Robot) -> dict[str, Any]:
    """What the hardware's FMU needs to know, as plain data that reads back as the same.

    Whether and how runs use the FMU is not of it, and no word leads to a key.

    Args:
        settings: What to write.
        robot: The robot.
    """
    safety = settings.safety
    data: dict[str, Any] = {
        "mode": settings.mode,
        "max_missed": settings.max_missed,
        "watchdog": settings.watchdog,
        "timeout": settings.timeout,
        "scale": settings.scale,
        "has_lengths": settings.has_lengths,
        "has_tensions": settings.has_tensions,
        "ramp_in": safety.ramp_in,
        "ramp_down": safety.ramp_down,
        "position_margin": list(safety.position_margin),
        "start_tolerance": list(safety.start_tolerance),
    }
    data |= {key: text for key in ("link", "bind") if (text := getattr(settings, key))}
    for key in ("force_rate", "tension_max"):
        limits = zip(robot.muscles, getattr(safety, key), strict=False)
        # no number stands for infinity in JSON
        data[key] = {muscle.name: limit for muscle, limit in limits if math.isfinite(limit)}
    if settings.emulator != EmulatorSettings():
        data["emulator"] = emulator_data(settings.emulator)
    return data | {"motors": _motor_data(settings.motors)}


def _motor_data(motors: MotorSettings) -> dict[str, Any]:
    if motors.command == "force":
        return {"command": "force"}
    data: dict[str, Any] = {
        "command": motors.command,
        "stiffness": list(motors.stiffness),
        "damping": list(motors.damping),
        "offset": "start" if motors.offset is None else list(motors.offset),
    }
    for key in ("spindle_radius", "encoder_scale"):
        if getattr(motors, key):
            data[key] = list(getattr(motors, key))
    return data
