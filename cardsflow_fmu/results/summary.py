"""Summary of a run: tracking, forces, infeasible ticks, speed, versions."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Muscle
from addin_sdfusion.robot.model.muscle_laws import law_of
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.muscles import tension_signals
from cardsflow_fmu.cosim.signals.ports import (
    FALLBACK,
    LATE,
    TORQUE,
    force_unit,
    motor_signals,
    slack_signals,
)
from cardsflow_fmu.cosim.signals.tracked_signals import (
    TrackedSignal,
    tracked_signals,
    tracked_signals_by_name,
    tracking_unit,
)
from cardsflow_fmu.cosim.signals.world import FRICTION_ERROR, FRICTION_NOT_CONVERGED
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.run import Accept
from cardsflow_fmu.utils.arrays import FloatArray, IntArray
from cardsflow_fmu.version import __version__

from .engines import OVER_FMUS, engine_summary
from .estimation import estimation_summary, fault_events
from .verdict import failure, problems

Columns = Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True)
class Speed:
    """Computation times of a run.

    Attributes:
        wall_time: Time of the loop, in [s].
        first_step_after: Time from the start of the program to the first step, in [s].
    """

    wall_time: float
    first_step_after: float


@np.errstate(over="ignore", invalid="ignore")  # for diverged runs
def summarize(
    experiment: Experiment,
    recording: Recording,
    speed: Speed,
    observed: Mapping[str, Any] = {},
) -> dict[str, Any]:
    """Return the summary of a run; signals that an external FMU does not provide are omitted."""
    robot, columns = experiment.robot, recording.columns
    followed = tracked_signals(
        robot, experiment.reference.space, experiment.controller.uncontrolled
    )
    bounds = dict(zip(tension_signals(robot, columns), map(_bounds, robot.muscles), strict=True))
    slack = slack_signals(robot, experiment.controller.space)
    motors = {
        name: (_finite(motor.tau_min), _finite(motor.tau_max), force_unit(motor))
        for name, motor in zip(motor_signals(TORQUE, robot), robot.motors, strict=True)
    }
    signals = _contacts(experiment, columns) | estimation_summary(experiment, columns, observed)
    signals |= _signals(recording, columns, followed, bounds, slack)
    failed = failure(signals) if experiment.run.accept == "tracked" else None
    return {
        "experiment": experiment.name,
        "robot": robot.name,
        "cable_set": robot.cable_set,
        **_outcome(recording, columns, failed),
        "scheme": experiment.stepping.scheme,
        "step": experiment.run.step,
        "control_period": experiment.controller.period,
        **engine_summary(experiment),
        **signals,
        **_torques(motors, columns),
        **_speed(recording, speed),
        "warnings": [*problems(signals), *experiment.warnings(), *recording.warnings],
        "versions": versions(),
    }


def summarize_system(
    name: str,
    recording: Recording,
    speed: Speed,
    *,
    scheme: str,
    step: float,
    engine: Mapping[str, str],
    accept: Accept = "tracked",
) -> dict[str, Any]:
    """Return the summary of a run of a system, based on signal names."""
    columns, followed = recording.columns, tracked_signals_by_name(recording.names, recording.units)
    if len({signal.actual[0] for signal in followed}) > 1:
        followed = []
    muscles_with_tension = {n.partition(".")[2] for n in columns if n.startswith("tension.")}
    forces: dict[str, tuple[float | None, float | None]] = {
        name: (None, None)
        for name in columns
        if name.startswith("tension.")
        or (name.startswith("f.") and name[2:] not in muscles_with_tension)
    }
    signals = _signals(recording, columns, followed, forces, {})
    failed = failure(signals) if accept == "tracked" else None
    return {
        "experiment": name,
        **_outcome(recording, columns, failed),
        "scheme": scheme,
        "step": step,
        "engine": dict(engine),
        "master": OVER_FMUS,
        **signals,
        **_torques(
            {n: (None, None, recording.units.get(n, "")) for n in columns if n.startswith("tau.")},
            columns,
        ),
        **_speed(recording, speed),
        "warnings": problems(signals),
        "versions": versions(),
    }


def _contacts(experiment: Experiment, columns: Columns) -> dict[str, Any]:
    """Return the contact friction law and its error; empty without contacts."""
    if experiment.scene is None or experiment.hardware.use or "plant" in experiment.fmus:
        return {}
    from sim_dart.scene import FRICTION_EXCESS

    law = experiment.scene.friction_law
    friction: dict[str, Any] = {"law": law, "excess": FRICTION_EXCESS[law]}
    if FRICTION_NOT_CONVERGED in columns:
        raised = columns[FRICTION_NOT_CONVERGED] != 0
        friction["not_converged_steps"] = int(np.count_nonzero(raised))
        friction["steps"] = len(raised)
        friction["error"] = float(columns[FRICTION_ERROR].max(initial=0.0))
    return {"contact_friction": friction}


def _outcome(recording: Recording, columns: Columns, failed: str | None) -> dict[str, Any]:
    """Return status, failure and error of a run."""
    error = recording.failure
    status = "complete" if failed is None else "failed"
    return {
        "status": status if error is None else "incomplete",
        "failure": failed,
        "error": None if error is None else str(error),
        "duration": float(columns["time"][-1]) if len(recording.rows) else 0.0,
    }


def _signals(
    recording: Recording,
    columns: Columns,
    followed: Sequence[TrackedSignal],
    bounds: Mapping[str, tuple[float | None, float | None]],
    slack: Mapping[str, str],
) -> dict[str, Any]:
    ticks = recording.ticks[recording.ticks < len(recording.rows)]
    recorded = [signal for signal in followed if {signal.actual, signal.desired} <= set(columns)]
    counts, has_failed = {}, np.zeros(len(ticks), bool)
    for name in ("infeasible", "not_converged"):
        raised = columns[name][ticks] != 0 if name in columns else None
        counts[f"{name}_ticks"] = None if raised is None else int(np.count_nonzero(raised))
        has_failed = has_failed if raised is None else has_failed | raised
    if FALLBACK in columns:
        counts["fallback_ticks"] = int(np.count_nonzero(columns[FALLBACK][ticks]))
        counts["late_ticks"] = int(np.count_nonzero(columns[LATE][ticks]))
    return {
        "tracking": _tracking(recorded, columns),
        "forces": _forces({n: b for n, b in bounds.items() if n in columns}, columns),
        **counts,
        "ticks": len(recording.ticks),
        "slack": _slack(slack, columns, ticks, has_failed),
        "solve_time": _solve_time(recording.solve_times),
        **_exchanges(columns),
        **({"faults": events} if (events := fault_events(columns)) else {}),
    }


def _exchanges(columns: Columns) -> dict[str, Any]:
    """Return the statistics of the exchanges with hardware; empty without hardware."""
    if "round_trip_time" not in columns:
        return {}
    from cardsflow_fmu.hardware.protocol.exchange_statistics import exchange_statistics

    return exchange_statistics(columns)


def _tracking(followed: Sequence[TrackedSignal], columns: Columns) -> dict[str, Any]:
    """Return the RMS over time of the 2-norm of the errors, and the largest error."""
    if not followed or not len(columns["time"]):
        return {"rms": None, "max": None, "unit": None, "per_signal": {}}
    errors = [signal.error(columns[signal.actual], columns[signal.desired]) for signal in followed]
    return {
        "rms": _rms(np.linalg.norm(np.stack(errors, axis=1), axis=1)),
        "max": float(np.abs(errors).max()),
        "unit": tracking_unit(followed),
        "per_signal": {
            signal.actual: {
                "rms": _rms(error),
                "max": float(np.abs(error).max()),
                "moves": float(np.ptp(columns[signal.desired])),
                "unit": signal.unit,
            }
            for signal, error in zip(followed, errors, strict=True)
        },
    }


def _slack(
    signals: Mapping[str, str], columns: Columns, ticks: IntArray, has_failed: NDArray[np.bool_]
) -> dict[str, Any]:
    """Return the maximum slack by signal, and first and last time of infeasible ticks."""
    missing = {n: np.abs(columns[n][ticks][has_failed]) for n in signals if n in columns}
    times = columns["time"][ticks][has_failed]
    dropped = columns.get("limits_dropped", np.zeros(len(columns["time"])))
    return {
        "limits_dropped_ticks": int(np.count_nonzero(dropped[ticks])),
        "first_at_s": float(times[0]) if times.size else None,
        "last_at_s": float(times[-1]) if times.size else None,
        "per_signal": {
            name: {"max": float(values.max(initial=0.0)), "unit": signals[name]}
            for name, values in missing.items()
        },
    }


def _solve_time(seconds: FloatArray) -> dict[str, Any]:
    """Return the computation times of the controller ticks."""
    if not len(seconds):
        return {"median": None, "max": None, "unit": "s"}
    return {"median": float(np.median(seconds)), "max": float(seconds.max()), "unit": "s"}


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _bounds(muscle: Muscle) -> tuple[float | None, float | None]:
    """Return the force limits of a muscle; None for passive muscles."""
    if law_of(muscle.model).command is None:
        return None, None
    return muscle.f_min, _finite(muscle.f_max)


def _forces(
    bounds: Mapping[str, tuple[float | None, float | None]], columns: Columns
) -> dict[str, Any]:
    if not bounds or not len(columns["time"]):
        return {"min": None, "max": None, "unit": "N", "per_muscle": {}}
    values = np.stack([columns[name] for name in bounds])
    per_muscle = {
        name: {
            "min": float(columns[name].min()),
            "max": float(columns[name].max()),
            "f_min": f_min,
            "f_max": f_max,
        }
        for name, (f_min, f_max) in bounds.items()
    }
    return {
        "min": float(values.min()),
        "max": float(values.max()),
        "unit": "N",
        "per_muscle": per_muscle,
    }


def _torques(
    motors: Mapping[str, tuple[float | None, float | None, str]], columns: Columns
) -> dict[str, Any]:
    """Return torques or forces of motors; empty without motors."""
    rows = {
        name: {
            "min": float(columns[name].min()),
            "max": float(columns[name].max()),
            "tau_min": low,
            "tau_max": high,
            "unit": unit,
        }
        for name, (low, high, unit) in motors.items()
        if name in columns and len(columns[name])
    }
    return {"torques": {"per_motor": rows}} if rows else {}


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _speed(recording: Recording, speed: Speed) -> dict[str, Any]:
    simulated = float(recording.rows[-1, 0]) if len(recording.rows) else 0.0
    return {
        "real_time_factor": simulated / speed.wall_time if speed.wall_time > 0 else None,
        "first_step_after_s": speed.first_step_after,
    }


def versions() -> dict[str, str]:
    """Return the versions of the software of a run."""
    return {
        "cardsflow": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    } | dict(_package_versions())


@cache
def _package_versions() -> tuple[tuple[str, str], ...]:
    """Return package versions; cached, since the search takes about as long as a short run."""
    packages = ("numpy", "scipy", "dartpy", "qpsolvers", "daqp", "fmpy")
    return tuple((package, importlib.metadata.version(package)) for package in packages)
