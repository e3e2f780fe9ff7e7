"""Results for tests, without a simulation."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.simulation.result import SystemResult


def waving(robot: Robot, seconds: float = 2.0, step: float = 0.01) -> SystemResult:
    """Joints that wave about their middles, and tensions that rise and fall within their bounds."""
    time = np.arange(round(seconds / step) + 1) * step
    columns = {"time": time}
    for k, (name, c) in enumerate(
        zip(coordinate_signals("q", robot), robot.coordinates, strict=True)
    ):
        low, high = max(c.lower, -1.0), min(c.upper, 1.0)
        columns[name] = (low + high) / 2 + 0.4 * (high - low) * np.sin((1.0 + 0.3 * k) * time)
    for k, (name, m) in enumerate(zip(muscle_signals("f", robot), robot.muscles, strict=True)):
        part = 0.5 - 0.5 * np.cos((0.7 + 0.2 * k) * time)
        columns[name] = m.f_min + part * (min(m.f_max, 500.0) - m.f_min)
    rows = np.stack(list(columns.values()), axis=1)
    return SystemResult(tuple(columns), rows, {}, {"status": "complete"})


def with_columns(result: SystemResult, more: dict[str, np.ndarray]) -> SystemResult:
    """The same result with more columns."""
    rows = np.column_stack([result.rows, *more.values()])
    return SystemResult((*result.names, *more), rows, result.units, result.summary)
