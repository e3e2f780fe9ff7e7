"""Required muscle forces along a motion, and attachments that limit them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.transforms.lock import lock
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, modelled_muscles
from cardsflow_fmu.cosim.signals.ports import force_unit
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import (
    Motion,
    MotionTerms,
    MuscleSizes,
    motion_terms,
    size_muscles,
)
from controllers.analysis.kinematics import inverse_kinematics
from controllers.analysis.wrench_set import too_many_facets
from controllers.force_distribution.linear import minimum_infinity_norm
from controllers.force_distribution.motor_columns import split_motors
from sim_dart import IndependentDynamics, MuscleDrive, control_dynamics
from sim_dart.muscles.paths import MusclePaths

MAX_POINTS = 1000
"""Maximum number of points of a motion."""

MIN_POINTS = 5

MARGIN = 0.2
"""Default force margin, as fraction of the peak force."""

_SHIFT = 1e-3  # finite-difference step of a via point, in [m]
_SMALL = 1e-6  # ignored: bottlenecks below this, in [N/mm], and forces, as fraction of the peak


def reference_motion(
    experiment: Experiment, points: int | None = None, *, rates: bool = True
) -> Motion:
    """Return the joint motion of the reference of an experiment.

    For a reference in operational space, every point is the configuration nearest to the posture of
    the controller, or to the start. Velocities and accelerations are from a cubic spline through
    these points.

    Args:
        points: Number of points, at least 5 (default: one per controller period, limited to
            5 to `MAX_POINTS`).
        rates: Whether velocities and accelerations of a reference in operational space are
            required; otherwise they are 0.

    Raises:
        InputError: A point is out of the robot's reach, or there are too few points.
    """
    from cardsflow_fmu.models.reference import make_reference

    reference = make_reference(experiment)
    duration = min(experiment.run.duration, reference.duration)
    if points is None:
        periods = math.floor(duration / experiment.controller.period)
        points = min(max(periods + 1, MIN_POINTS), MAX_POINTS)
    if points < MIN_POINTS:
        raise InputError(f"a motion requires at least {MIN_POINTS} points, not {points}")
    times = np.linspace(0.0, duration, points)
    q, qd, qdd = reference.evaluate(times)
    if experiment.reference.space == "operational":
        positions = _inverse_kinematics(experiment, times, q)
        if not rates:
            return Motion(times, positions, np.zeros_like(positions), np.zeros_like(positions))
        from scipy.interpolate import CubicSpline  # slow to import

        spline = CubicSpline(times, positions)
        return Motion(times, spline(times), spline(times, 1), spline(times, 2))
    if experiment.robot.loops:
        _close_loops(experiment, q, qd, qdd)
    return Motion(times, q, qd, qdd)


def _close_loops(experiment: Experiment, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> None:
    """Close the loops of a motion in place, point by point."""
    dynamics = IndependentDynamics(experiment.robot, experiment.controller.dependent)
    before = np.array(experiment.start.q)
    for k in range(len(q)):
        q[k] = before = dynamics.closed(np.where(dynamics.dependent, before, q[k]))
        qd[k] = dynamics.free_motion(q[k]) @ qd[k]
        qdd[k] = dynamics.complete(q[k], qd[k], qdd[k])


def _inverse_kinematics(experiment: Experiment, times: FloatArray, path: FloatArray) -> FloatArray:
    """Return the joint positions of task positions, by inverse kinematics point by point."""
    dynamics, tasks = control_dynamics(experiment.robot), experiment.controller.tasks
    q: ArrayLike = experiment.start.q
    posture = tasks.posture.q0 if tasks is not None and tasks.posture is not None else q
    positions = []
    for t, y in zip(times.tolist(), path, strict=True):
        try:
            q = inverse_kinematics(dynamics, y, q, posture=posture).q
        except InputError as error:
            raise InputError(f"at {t:g} s {error.problem}", key="reference") from None
        positions.append(q)
    return np.array(positions)


def size(
    experiment: Experiment, *, margin: float = MARGIN, method: str = "least_squares"
) -> dict[str, Any]:
    """Return the required muscle forces of an experiment, as plain data in SI units.

    The robot is the simulated one; external forces are included. Passive coordinates are locked at
    the first point of the motion.

    Args:
        margin: Force margin, as fraction of the peak forces.
        method: Force distribution, see `controllers.force_distribution`.

    Raises:
        InputError: The margin is invalid, or the robot cannot reach the reference.
    """
    robot, motion = required_motion(experiment)
    return size_robot(robot, motion, margin=margin, method=method)


def required_motion(experiment: Experiment, points: int | None = None) -> tuple[Robot, Motion]:
    """Return the simulated robot and its reference motion with external forces.

    Passive coordinates are locked at the first point of the motion.
    """
    motion = _with_external_forces(experiment, reference_motion(experiment, points))
    return lock_passive_coordinates(experiment, experiment.plant_robot, motion)


def lock_passive_coordinates(
    experiment: Experiment, robot: Robot, motion: Motion
) -> tuple[Robot, Motion]:
    """Return a robot and its motion with passive coordinates locked at the first point."""
    passive = np.array(experiment.controller.passive, bool)
    if not passive.any():
        return robot, motion
    names = np.array([c.name for c in robot.coordinates])
    locked = dict(zip(names[passive].tolist(), motion.q[0, passive].tolist(), strict=True))
    q, qd, qdd = (values[:, ~passive] for values in (motion.q, motion.qd, motion.qdd))
    w_e = None if motion.w_e is None else motion.w_e[:, ~passive]
    return lock(robot, locked), Motion(motion.times, q, qd, qdd, w_e)


def _with_external_forces(experiment: Experiment, motion: Motion) -> Motion:
    """Return the motion with w_e = -J_p'F of the external forces."""
    disturbance = experiment.disturbance
    if disturbance is None:
        return motion
    dynamics, forces = control_dynamics(experiment.robot), np.ravel(disturbance.forces)
    acts = (disturbance.begin <= motion.times) & (motion.times < disturbance.end)
    w_e = np.array([-dynamics.point_jacobian(q).T @ forces for q in motion.q])
    return replace(motion, w_e=np.where(acts[:, None], w_e, 0.0))


def size_robot(
    robot: Robot, motion: Motion, *, margin: float = MARGIN, method: str = "least_squares"
) -> dict[str, Any]:
    """Return the required muscle forces of a robot for a motion, as plain data in SI units.

    Passive muscles are loads and are not sized.

    Raises:
        InputError: The robot has no muscles, the motion has another number of coordinates, or the
            margin is invalid.
    """
    robot, terms = actuator_terms(robot, motion)
    sizes = size_muscles(terms, margin=margin, method=method)
    critical = sizes.critical
    return {
        "margin": margin,
        "method": method,
        "points": len(motion.times),
        "begin": float(motion.times[0]),
        "end": float(motion.times[-1]),
        "infeasible_points": int(np.sum(~sizes.forces.solved)),
        "impossible_points": len(sizes.impossible),
        "muscles": _muscle_rows(robot, sizes),
        "motors": _motor_rows(robot, sizes),
        "least_peak": None
        if critical is None
        else {"force": float(sizes.min_peaks[critical]), "time": float(motion.times[critical])},
        "bottlenecks": [] if critical is None else bottlenecks(robot, terms, critical),
        "coordinates": _coordinate_rows(sizes),
        "units": {"force": "N", "torque": "N.m", "time": "s", "power": "W", "gain": "N/mm"},
    }


def actuator_terms(robot: Robot, motion: Motion) -> tuple[Robot, MotionTerms]:
    """Return the robot without passive muscles, and the torques that its actuators must produce.

    Raises:
        InputError: The robot has no muscles and no motors, or the motion does not match it.
    """
    if not robot.muscles and not robot.motors:
        raise InputError(f"the robot {robot.name!r} has no muscles to size, and no motors")
    robot, motion = _passive_muscles_as_load(robot, motion)
    return robot, motion_terms(control_dynamics(robot), motion)


def _passive_muscles_as_load(robot: Robot, motion: Motion) -> tuple[Robot, Motion]:
    """Return the robot without passive muscles, and the motion with their forces as load."""
    passive = [k for k in modelled_muscles(robot) if k not in driven_muscles(robot)]
    if not passive:
        return robot, motion
    drive, dynamics = MuscleDrive(robot), control_dynamics(robot)
    pull = np.zeros_like(motion.q)
    for row, q, qd in zip(pull, motion.q, motion.qd, strict=True):
        drive.set_state(q, qd, np.zeros(drive.states))
        f = drive.tensions(np.zeros(len(robot.muscles)))[passive]
        row[:] = dynamics.muscle_jacobian(q)[passive].T @ f
    muscles = [
        replace(muscle, f_min=0.0, f_max=0.0) if k in passive else muscle
        for k, muscle in enumerate(robot.muscles)
    ]
    load = pull if motion.w_e is None else motion.w_e + pull
    return robot.with_muscles(muscles), replace(motion, w_e=load)


def bottlenecks(robot: Robot, terms: MotionTerms, point: int) -> list[dict[str, Any]]:
    """Return the effect of moving each attachment on the peak muscle force, largest effect first.

    Muscles that only carry their minimum force are omitted. The peak force is the minimum infinity
    norm of the muscle forces without upper limits. It does not depend on the force distribution.
    Its gradient is computed by central differences of robots with one moved via point.
    """
    q, tau = terms.motion.q[point], terms.tau[point]
    muscles, motor_rows = len(robot.muscles), terms.L[point][len(robot.muscles) :]
    unlimited = np.full(terms.motors, -np.inf)
    low = np.concatenate([terms.f_min[:muscles], unlimited])
    is_counted = (np.arange(len(low) + terms.motors) < muscles).astype(float)

    def least_forces(moved: Robot) -> FloatArray:
        paths = MusclePaths(moved)  # keeps the memory of the evaluated paths alive
        rows = np.concatenate([paths.evaluate(q).jacobian, motor_rows])
        L, f_min, f_max = split_motors(rows, low, np.full(len(low), np.inf), terms.motors)
        least = minimum_infinity_norm(L, tau, f_min, f_max, counts=is_counted)
        return np.asarray(least.forces[:muscles])

    def min_peak(moved: Robot) -> float:
        return float(least_forces(moved).max(initial=0.0))

    effects, forces = [], least_forces(robot)
    pulls = forces > terms.f_min[:muscles] + _SMALL * forces.max(initial=0.0)
    for k, muscle in enumerate(robot.muscles):
        if not pulls[k]:
            continue
        for i, via in enumerate(muscle.via_points):
            gradient = np.zeros(3)
            for axis in range(3):
                forward, backward = (
                    min_peak(_move_via_point(robot, k, i, axis, sign * _SHIFT)) for sign in (1, -1)
                )
                gradient[axis] = (forward - backward) / (2.0 * 1e3 * _SHIFT)
            gain = float(np.linalg.norm(gradient))
            if math.isfinite(gain) and gain > _SMALL:
                effects.append(
                    {
                        "muscle": muscle.name,
                        "via_point": i + 1,
                        "link": via.link,
                        "gain": gain,
                        "direction": (-gradient / gain).tolist(),
                    }
                )
    return sorted(effects, key=lambda entry: -entry["gain"])


def _move_via_point(robot: Robot, muscle: int, via: int, axis: int, shift: float) -> Robot:
    """Return the robot with one via point moved along one axis of its link frame, in [m]."""
    muscles: list[Muscle] = list(robot.muscles)
    points = list(muscles[muscle].via_points)
    x, y, z = (p + shift * (k == axis) for k, p in enumerate(points[via].position))
    points[via] = replace(points[via], position=(x, y, z))
    muscles[muscle] = replace(muscles[muscle], via_points=tuple(points))
    return robot.with_muscles(muscles)


def _muscle_rows(robot: Robot, sizes: MuscleSizes) -> list[dict[str, Any]]:
    """Return forces of each muscle within its limits, and its required f_max."""
    columns = _columns(sizes, "needed_f_max", "f_min", "f_max")
    return [
        {
            "name": muscle.name,
            "f_min": muscle.f_min,
            "f_max": _finite(muscle.f_max),
            **{name: _finite(column[k]) for name, column in columns.items()},
        }
        for k, muscle in enumerate(robot.muscles)
    ]


def _motor_rows(robot: Robot, sizes: MuscleSizes) -> list[dict[str, Any]]:
    """Return torques of each motor within its limits, and its required effort."""
    columns = _columns(sizes, "needed_effort", "tau_min", "tau_max")
    return [
        {
            "name": motor.name,
            "unit": force_unit(motor),
            "tau_min": _finite(motor.tau_min),
            "tau_max": _finite(motor.tau_max),
            **{name: _finite(column[k]) for name, column in columns.items()},
        }
        for k, motor in enumerate(robot.motors, start=len(robot.muscles))
    ]


def _columns(sizes: MuscleSizes, needed: str, low: str, high: str) -> dict[str, FloatArray]:
    """Return the loads of every muscle and motor, by column name."""
    forces = sizes.forces
    at_min, at_max = forces.shares_at_bounds()
    power = np.where(np.isnan(forces.power), 0.0, forces.power)
    return {
        "peak": forces.peaks(),
        "peak_time": forces.peak_times(),
        "rms": forces.rms(),
        needed: sizes.needed,
        f"share_at_{low}": at_min,
        f"share_at_{high}": at_max,
        "peak_power": np.maximum(power.max(axis=0), 0.0),
        "peak_braking_power": np.maximum(-power.min(axis=0), 0.0),
    }


def _coordinate_rows(sizes: MuscleSizes) -> list[dict[str, Any]]:
    """Return the minimum torque margins of every coordinate along the motion; None if unknown."""
    names = sizes.forces.terms.coordinate_names
    rows: list[dict[str, Any]] = [
        {"name": name, "torque_down": None, "torque_up": None} for name in names
    ]
    if too_many_facets(len(sizes.needed) + sizes.forces.terms.motors, len(names)):
        return rows
    for key, margins in zip(("torque_down", "torque_up"), sizes.forces.torque_margins, strict=True):
        for j, row in enumerate(rows):
            finite = margins[:, j][np.isfinite(margins[:, j])]
            row[key] = float(finite.min()) if len(finite) else None
    return rows


def _finite(value: float) -> float | None:
    """Return a number for JSON; None for infinity."""
    return float(value) if math.isfinite(value) else None
