"""Metrics of a run: values by name, with units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from cardsflow_fmu.cosim.signals.ports import muscle_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.simulation.result import Result
from cardsflow_fmu.utils.arrays import FloatArray

from .tables import Box

MAX_POSES = 100
"""Maximum number of poses of a run at which the stiffness is evaluated."""


@dataclass(frozen=True, slots=True)
class Metric:
    """Definition of a metric.

    Attributes:
        unit: Unit; empty for a dimensionless metric, None for the unit of the tracking error.
        description: Description in one line.
        value: Function that computes the metric of a run; NaN if the metric is not available.
        is_per_muscle: Whether `name.<muscle>` is the metric of a single muscle.
        large_is_good: Whether large values are better than small values.
    """

    unit: str | None
    description: str
    value: Callable[[Result, Box | None, str | None], float]
    is_per_muscle: bool = False
    large_is_good: bool = False


def expand_wildcards(names: Iterable[str], robot: Robot) -> tuple[str, ...]:
    """Replace `*` by the names of all muscles and remove duplicates.

    Args:
        names: Names such as `tracking.rms`, `force.peak`, `force.peak.biceps` or `force.peak.*`.

    Raises:
        UnknownNameError: A metric or muscle does not exist.
    """
    muscles = [muscle.name for muscle in robot.muscles]
    expanded: list[str] = []
    for name in names:
        base = next((n for n in _per_muscle() if name.startswith(f"{n}.")), None)
        if name in METRICS:
            expanded.append(name)
        elif base is not None:
            last = name[len(base) + 1 :]
            if last not in ("*", *muscles):
                raise UnknownNameError("muscle", last, muscles)
            expanded += [f"{base}.{m}" for m in muscles] if last == "*" else [name]
        else:
            metrics = [*METRICS, *(f"{n}.*" for n in _per_muscle())]
            raise UnknownNameError("metric", name, metrics)
    return tuple(dict.fromkeys(expanded))


def _per_muscle() -> list[str]:
    return [name for name, metric in METRICS.items() if metric.is_per_muscle]


def split_metric(name: str) -> tuple[Metric, str | None]:
    """Return the metric with a name, and the muscle in the name or None."""
    if name in METRICS:
        return METRICS[name], None
    base = next(n for n in _per_muscle() if name.startswith(f"{n}."))
    return METRICS[base], name[len(base) + 1 :]


def metric_values(names: Iterable[str], result: Result, box: Box | None) -> dict[str, Any]:
    """Return the metrics of a run, with None for metrics that are not available.

    Raises:
        InputError: The workspace has no limits.
    """
    values: dict[str, Any] = {}
    for name in names:
        metric, muscle = split_metric(name)
        value = metric.value(result, box, muscle)
        values[name] = None if math.isnan(value) else value
    return values


def metric_units(names: Iterable[str], tracking: str) -> dict[str, str]:
    """Return the unit of every metric."""
    units = {name: split_metric(name)[0].unit for name in names}
    return {name: tracking if unit is None else unit for name, unit in units.items()}


def _tracking(key: str) -> Callable[[Result, Box | None, str | None], float]:
    def value(result: Result, box: Box | None, muscle: str | None) -> float:
        number = result.summary["tracking"][key]
        return math.nan if number is None else float(number)

    return value


def _reduced_forces(
    reduce: Callable[[FloatArray], Any],
) -> Callable[[Result, Box | None, str | None], float]:
    def value(result: Result, box: Box | None, muscle: str | None) -> float:
        forces = _forces(result, muscle)
        return float(reduce(forces)) if forces.size else math.nan

    return value


def _forces(result: Result, muscle: str | None) -> FloatArray:
    """Return forces over time, shape (rows, muscles), of all muscles or of one muscle."""
    robot = result.experiment.robot
    names = [m.name for m in robot.muscles]
    signals = muscle_signals("f", robot)
    if muscle is not None:
        signals = [signals[names.index(muscle)]] if muscle in names else []
    signals = [name for name in signals if name in result.names]
    return result.columns(signals) if signals else np.empty((0, 0))


def _rms(forces: FloatArray) -> float:
    return float(np.sqrt(np.mean(forces**2)))


def _energy(result: Result, box: Box | None, muscle: str | None) -> float:
    """Return the absolute work of the muscles: the sum of f |dl|, with f constant in each step."""
    robot = result.experiment.robot
    names = [m.name for m in robot.muscles]
    muscles = range(len(names)) if muscle is None else [names.index(muscle)]
    f, l = (muscle_signals(prefix, robot) for prefix in "fl")  # noqa: E741
    if any(f[k] not in result.names or l[k] not in result.names for k in muscles):
        return math.nan
    work = [np.sum(result[f[k]][1:] * np.abs(np.diff(result[l[k]]))) for k in muscles]
    return float(sum(work))


def _count(key: str) -> Callable[[Result, Box | None, str | None], float]:
    def count(result: Result, box: Box | None, muscle: str | None) -> float:
        value = result.summary[key]
        return math.nan if value is None else value

    return count


def _missed(result: Result, box: Box | None, muscle: str | None) -> float:
    """Return the number of exchanges with an emulated robot without a new state."""
    return float(result["missed"][-1]) if "missed" in result.names else math.nan


def _margin(bound: str) -> Callable[[Result, Box | None, str | None], float]:
    """Return the smallest distance of the forces from a force limit, in [N]."""

    def value(result: Result, box: Box | None, muscle: str | None) -> float:
        forces = result.summary["forces"]["per_muscle"].values()
        if bound == "f_max":
            gaps = [m["f_max"] - m["max"] for m in forces if m["f_max"] is not None]
        else:
            gaps = [m["min"] - m["f_min"] for m in forces if m["f_min"] is not None]
        return float(min(gaps, default=math.nan))

    return value


def _stiffness(result: Result, box: Box | None, muscle: str | None) -> float:
    """Return the smallest eigenvalue of the joint stiffness at constant forces, along the run."""
    from controllers.analysis.stiffness import stiffness
    from sim_dart import control_dynamics

    robot = result.experiment.plant_robot
    positions = [f"q.{name[2:]}" for name in _coordinate_columns(result)]
    forces = _forces(result, None)
    if forces.shape[1:] != (len(robot.muscles),) or not positions:
        return math.nan
    q = result.columns(positions)
    dynamics = control_dynamics(robot)
    rows = np.unique(np.linspace(0, len(q) - 1, min(MAX_POSES, len(q))).round().astype(int))
    lowest = [np.linalg.eigvalsh(stiffness(dynamics, q[row], forces[row]).total)[0] for row in rows]
    return float(min(lowest))


def _coordinate_columns(result: Result) -> list[str]:
    from cardsflow_fmu.cosim.signals.ports import coordinate_signals

    names = coordinate_signals("q", result.experiment.robot)
    return names if all(name in result.names for name in names) else []


def _loop_margin(which: str) -> Callable[[Result, Box | None, str | None], float]:
    """Return the smallest stability margin of the sampled loops."""

    def value(result: Result, box: Box | None, muscle: str | None) -> float:
        from controllers.analysis.gains import margins

        settings = result.experiment.controller
        if settings.torque_gains or min(settings.kd) <= 0:
            return math.nan
        delay = 0 if settings.predict else settings.delay
        loops = [
            margins(kp, kd, settings.period, delay)
            for kp, kd in zip(settings.kp, settings.kd, strict=True)
        ]
        return float(min(getattr(loop, which) for loop in loops))

    return value


def wrench_closure(experiment: Experiment, box: Box | None) -> float:
    """Return the fraction of the workspace with wrench closure, from 0 to 1.

    In a pose with wrench closure, muscles without force limits can generate any torque.

    Args:
        box: Joint positions of the workspace, or None for 5 poses between the joint limits of each
            coordinate.

    Raises:
        InputError: A joint has no limits.
    """
    from controllers.analysis.workspace import is_wrench_closed, joint_grid
    from controllers.force_distribution.motor_columns import split_motors
    from sim_dart import control_dynamics

    robot = experiment.robot
    if box is None:
        limits = [(c.lower, c.upper) for c in robot.coordinates]
        lower, upper = zip(*limits, strict=True)
        box = Box(lower=lower, upper=upper)
    try:
        poses = joint_grid(box.lower, box.upper, box.points)
    except InputError as error:
        raise InputError(f"{error.problem}; set [workspace] lower and upper") from None
    dynamics = control_dynamics(robot)
    poses = poses.reshape(-1, len(robot.coordinates))
    rows = np.stack([dynamics.actuator_jacobian(q) for q in poses])
    L, _, _ = split_motors(rows, dynamics.f_min, dynamics.f_max, len(dynamics.motor_names))
    return float(np.mean(is_wrench_closed(L)))


def _breaks_survived(result: Result, box: Box | None, muscle: str | None) -> float:
    """Return the fraction of the reference that is feasible without one muscle or motor."""
    from cardsflow_fmu.results.analysis.failures import failures

    single = failures(result.experiment)[1:]
    shares = [(failure.strength <= 1.0).mean() for failure in single]
    return float(np.mean(shares)) if shares else math.nan


METRICS: Mapping[str, Metric] = {
    "tracking.rms": Metric(None, "RMS tracking error", _tracking("rms")),
    "tracking.max": Metric(None, "Maximum tracking error", _tracking("max")),
    "force.peak": Metric("N", "Maximum muscle force", _reduced_forces(np.max), is_per_muscle=True),
    "force.rms": Metric("N", "RMS muscle force", _reduced_forces(_rms), is_per_muscle=True),
    "force.low": Metric(
        "N", "Minimum muscle force", _reduced_forces(np.min), is_per_muscle=True, large_is_good=True
    ),
    "energy": Metric("J", "Absolute work of the muscles", _energy, is_per_muscle=True),
    "infeasible_ticks": Metric("", "Ticks with an infeasible torque", _count("infeasible_ticks")),
    "not_converged_ticks": Metric(
        "", "Ticks in which the force distribution did not converge", _count("not_converged_ticks")
    ),
    "missed": Metric("", "Exchanges with the robot without an answer", _missed),
    "stiffness.min": Metric(
        "N.m/rad", "Minimum joint stiffness at constant forces", _stiffness, large_is_good=True
    ),
    "margin.upper": Metric("N", "Minimum distance to f_max", _margin("f_max"), large_is_good=True),
    "margin.lower": Metric("N", "Minimum distance to f_min", _margin("f_min"), large_is_good=True),
    "margin.gain": Metric("", "Gain margin", _loop_margin("gain_margin"), large_is_good=True),
    "margin.phase": Metric("rad", "Phase margin", _loop_margin("phase_margin"), large_is_good=True),
    "margin.delay": Metric("s", "Delay margin", _loop_margin("delay_margin"), large_is_good=True),
    "breaks_survived": Metric(
        "",
        "Fraction of the reference that is feasible without one muscle or motor, mean over all; "
        "1: the motion survives any single failure",
        _breaks_survived,
        large_is_good=True,
    ),
    "wrench_closure": Metric(
        "",
        "Fraction of the workspace with wrench closure",
        lambda result, box, _: wrench_closure(result.experiment, box),
        large_is_good=True,
    ),
}

DEFAULT_METRICS = (
    "tracking.rms",
    "tracking.max",
    "force.peak",
    "force.rms",
    "energy",
    "infeasible_ticks",
    "force.peak.*",
    "force.rms.*",
)
"""Default metrics of a study."""
