"""Columns of the analysis of muscle redundancy: powers, metabolic rates, joint reactions."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.muscle_laws import law_parameters
from cardsflow_fmu.cosim.signals.muscles import tension_signals
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import control_dynamics
from sim_dart.dynamics.joint_reactions import joint_reactions
from sim_dart.muscles.fibres import FIBRE_POINT, HillMuscles, has_fibres
from sim_dart.muscles.metabolics import FibreStates, bhargava_2004, umberger_2010

from .motion import GivenMotion
from .static import Activations

_RATES = {"umberger_2010": umberger_2010, "bhargava_2004": bhargava_2004}


def motion_columns(recorded: GivenMotion, result: Activations) -> dict[str, FloatArray]:
    """Return the columns of results.csv by name, shape (T,) each, in SI units.

    They are the motion, tensions and activations; the powers -f l' of the muscles; for muscles with
    fibres, fibre lengths and velocities and metabolic rates; for robots without loops, the forces
    and moments of joints, see `JointReactions`.
    """
    robot, motion = recorded.robot, recorded.motion
    columns = {"time": motion.times}

    def add(names: list[str], rows: FloatArray) -> None:
        columns.update(zip(names, rows.T, strict=True))

    for letter in ("q", "qd", "qdd"):
        add(coordinate_signals(letter, robot), getattr(motion, letter))
    add(tension_signals(robot), result.forces)
    add(muscle_signals("activation", robot), result.activations)
    add(coordinate_signals("reserve", robot), result.reserves)
    dynamics = control_dynamics(robot)
    L = np.array([dynamics.muscle_jacobian(q) for q in motion.q])
    rates = np.einsum("tmn,tn->tm", L, motion.qd)
    add(muscle_signals("power", robot), -result.forces * rates)
    muscles = [muscle for muscle in robot.muscles if has_fibres(muscle)]
    if muscles:
        columns |= _fibre_columns(robot.with_muscles(muscles), recorded, result, rates)
    if not robot.loops:
        columns |= _reaction_columns(recorded, result)
    return columns


def _fibre_columns(
    robot: Robot, recorded: GivenMotion, result: Activations, rates: FloatArray
) -> dict[str, FloatArray]:
    """Return the columns of muscles with fibres, which are all muscles of `robot`."""
    has = np.array([has_fibres(muscle) for muscle in recorded.robot.muscles])
    dynamics, muscles = control_dynamics(recorded.robot), HillMuscles(robot)
    lengths = np.array([dynamics.muscle_lengths(q)[has] for q in recorded.motion.q])
    a = u = result.activations[:, has]
    fibres, speeds = muscles.rigid(lengths, rates[:, has])
    if result.trajectory is not None:
        u = result.trajectory.excitations
        fibres, speeds = result.trajectory.fibre_lengths, result.trajectory.fibre_rates
    points = np.zeros((*a.shape, FIBRE_POINT))
    points[:, :, 0], points[:, :, 1], points[:, :, 2], points[:, :, 3] = a, fibres, speeds, lengths
    values = muscles.fibres(points)
    active = muscles.force * a * values[:, :, 6] * values[:, :, 7]
    states = FibreStates(
        muscles.force,
        muscles.optimal,
        np.array([law_parameters(m.model)["max_contraction_velocity"] for m in robot.muscles]),
        u,
        a,
        fibres / muscles.optimal,
        speeds,
        values[:, :, 6],
        active,
        values[:, :, 0] / values[:, :, 9] - active,
    )
    parts = {"u": u, "fibre_length": fibres, "fibre_rate": speeds}
    parts |= {name: rate(states) for name, rate in _RATES.items()}
    columns: dict[str, FloatArray] = {}
    for name, rows in parts.items():
        columns |= dict(zip(muscle_signals(name, robot), rows.T, strict=True))
        if name in _RATES:
            columns[f"{name}.total"] = rows.sum(axis=1)
    return columns


def _reaction_columns(recorded: GivenMotion, result: Activations) -> dict[str, FloatArray]:
    motion, loads = recorded.motion, recorded.loads
    wrenches = None if loads is None else (loads.links, loads.forces, loads.moments)
    states = (motion.q, motion.qd, motion.qdd)
    reactions = joint_reactions(recorded.robot, states, result.forces, wrenches)
    columns: dict[str, FloatArray] = {}
    rows_of = {"reaction_force": reactions.forces, "reaction_moment": reactions.moments}
    for kind, rows in rows_of.items():
        for k, name in enumerate(reactions.joints):
            columns |= {f"{kind}.{name}.{axis}": rows[:, k, j] for j, axis in enumerate("xyz")}
    return columns
