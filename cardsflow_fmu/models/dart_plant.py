"""Plant in DART, for worlds with contacts and for muscle laws in Python."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.muscles import (
    commanded_muscles,
    friction_muscles,
    modelled_muscles,
    state_order,
)
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.multiples import MAX_STEPS, whole_steps
from sim_dart import Plant


class DartPlant:
    """Connection of `sim_dart.Plant` to the variables of a plant.

    Raises:
        InputError: A tension is scaled, or a cable breaks.
    """

    def __init__(self, experiment: Experiment, views: Mapping[str, FloatArray]) -> None:
        for key, usual in (("tension_scale", 1.0), ("break_time", 0.0)):
            if any(value != usual for value in getattr(experiment.plant, key)):
                raise InputError(
                    "requires the engine core, which supports neither contacts nor custom laws",
                    file=experiment.file,
                    key=f"plant.{key}",
                )
        robot = experiment.plant_robot
        self._robot = robot
        self._settings, self._scene = experiment.plant, experiment.scene
        self._plant = self._create_plant(experiment.plant.step)
        self._modelled, self._state_order = modelled_muscles(robot), state_order(robot)
        self._rubbing = friction_muscles(robot)
        self._commanded = commanded_muscles(robot)
        self._all_commands = np.zeros(len(robot.muscles))
        self._commands, self._torques, self._loads, self._wrenches = (
            views[name] for name in ("commands", "torques", "loads", "wrenches")
        )
        self._q, self._qd, self._lengths, self._tasks = (
            views[name] for name in ("q", "qd", "lengths", "tasks")
        )
        self._tensions, self._states, self._energies, self._world, self._far = (
            views[name] for name in ("tensions", "states", "energies", "world", "far_tensions")
        )
        self._q_start, self._qd_start, self._step = (
            views[name] for name in ("q_start", "qd_start", "step")
        )

    def initialize(self, t: float = 0.0) -> None:
        """Set the start state, with muscles in equilibrium under the current commands."""
        for coordinate, q in zip(self._robot.coordinates, self._q_start, strict=True):
            if not coordinate.lower <= q <= coordinate.upper:
                limits = f"{coordinate.lower!r} to {coordinate.upper!r}"
                raise InputError(
                    f"q_start of {coordinate.name!r} is {q!r}, outside the limits {limits}"
                )
        if self._step[0] != self._plant.step_size:
            self._plant = self._create_plant(float(self._step[0]))
        self._plant.reset(self._q_start, self._qd_start, self._muscle_commands())
        self._write_outputs()

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h with constant commands and loads."""
        plant = self._plant
        loads = self._loads if self._loads.any() else None
        wrenches = self._wrenches if self._wrenches.any() else None
        commands, torques = self._muscle_commands(), self._torques if self._torques.size else None
        steps = whole_steps(
            *(h, plant.step_size, "the plant's internal step"), most=MAX_STEPS, parameter="step"
        )
        for _ in range(steps):
            plant.step(commands, torques, loads, wrenches)
        self._write_outputs()

    def get_state(self) -> bytes:
        """Return step count, q, qd, muscle states, work (if computed) and states of objects."""
        return self._plant.get_state().tobytes()

    def set_state(self, state: bytes) -> None:
        """Restore a state from `get_state`."""
        if len(state) % 8:
            raise InputError(
                f"the state of a plant must be an array of float64, not {len(state)} bytes"
            )
        self._plant.set_state(np.frombuffer(state))
        self._plant.hold(self._muscle_commands())
        self._write_outputs()

    def _create_plant(self, step: float) -> Plant:
        settings = self._settings
        return Plant(
            self._robot,
            step,
            integrator=settings.integrator,
            substeps=settings.substeps,
            energy=settings.energy,
            scene=self._scene,
            wrenched=settings.wrenches,
            engine=settings.engine,
        )

    def _muscle_commands(self) -> FloatArray:
        """Return the commands of all muscles, in the order of f; 0 for passive muscles."""
        if not self._modelled:
            return self._commands
        self._all_commands[self._commanded] = self._commands
        return self._all_commands.copy()

    def _write_outputs(self) -> None:
        plant = self._plant
        self._q[:] = plant.q
        self._qd[:] = plant.qd
        self._lengths[:] = plant.lengths_view
        if self._tasks.size:
            self._tasks[:] = plant.task_position
        if self._tensions.size == len(self._robot.muscles):
            self._tensions[:] = plant.tensions
        elif self._modelled:
            self._tensions[:] = plant.tensions[self._modelled]
        if self._modelled:
            self._states[:] = plant.muscle_states[self._state_order]
        if self._far.size:
            self._far[:] = plant.far_tensions[self._rubbing]
        if self._energies.size:
            (linear, angular) = plant.momentum
            self._energies[:] = [*plant.energy, *linear, *angular]
        if self._world.size:
            world = plant.world
            bodies = *world.contact_forces().flat, *world.object_poses().flat
            self._world[:] = [*bodies, *world.take_friction_error()]
