"""Reading and writing [hardware.emulator]: motors, sensors and line of an emulated robot."""

from __future__ import annotations

import math
from typing import Any

from addin_sdfusion.robot import InputError
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.hardware.emulator.faults import Faults
from cardsflow_fmu.hardware.emulator.sensors import SensorSettings

from .hardware_settings import EmulatorSettings

_COUNTS = ("joint_counts", "length_counts")
_CHANCES = ("loss", "duplicate", "reorder", "corrupt")
_TIMES = ("delay", "jitter")


def read_emulator(table: Table) -> EmulatorSettings:
    """How the emulated robot is imperfect; it is perfect where nothing is said.

    Args:
        table: The table [hardware.emulator].

    Raises:
        InputError: Something in it is wrong.
    """
    motor_lag, seed = table.number("motor_lag", 0.0), table.whole("seed", 0)
    counts = {key: table.positive(key) if key in table else math.inf for key in _COUNTS}
    for key in _COUNTS:
        table.value(key, None)
    noise, differences = table.number("noise", 0.0), table.flag("differences", False)
    chances = {key: table.number(key, 0.0) for key in (*_CHANCES, *_TIMES)}
    outages = _outages(table)
    table.close()
    if motor_lag < 0:
        raise table.error("motor_lag", f"must not be negative: {motor_lag!r}")
    if seed < 0:
        raise table.error("seed", f"must not be negative: {seed}")
    try:
        return EmulatorSettings(
            motor_lag,
            SensorSettings(**counts, noise=noise, differences=differences, seed=seed),
            Faults(**chances, outages=outages, seed=seed),
        )
    except InputError as error:
        raise InputError(error.what, file=table.file, key=table.path) from None


def _outages(table: Table) -> tuple[tuple[float, float], ...]:
    rows = table.value("outages", [])
    if not isinstance(rows, list):
        raise table.error("outages", f"must be a list of begins and lengths, not {rows!r}")
    pairs = Table({f"outages[{k}]": row for k, row in enumerate(rows)}, table.file, table.path)
    return tuple((begin, length) for begin, length in (pairs.numbers(key, 2) for key in pairs))


def emulator_data(settings: EmulatorSettings) -> dict[str, Any]:
    """The same as plain data, which reads back as this.

    Args:
        settings: What to write.
    """
    sensors, faults = settings.sensors, settings.faults
    counts = {key: getattr(sensors, key) for key in _COUNTS}
    return {
        "motor_lag": settings.motor_lag,
        "seed": faults.seed,
        "noise": sensors.noise,
        "differences": sensors.differences,
        "outages": [list(outage) for outage in faults.outages],
        # no number stands for infinity in JSON
        **{key: value for key, value in counts.items() if math.isfinite(value)},
        **{key: getattr(faults, key) for key in (*_CHANCES, *_TIMES)},
    }
