"""The plant as an FMU model: forces and loads in; positions, velocities, lengths, tasks out."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment import Experiment
from cardsflow_fmu.ports import Port, plant_ports
from cardsflow_fmu.timing import whole_steps
from sim_dart import Plant

from .experiment_model import ExperimentModel
from .model import FloatArray


class PlantModel(ExperimentModel):
    """A simulated robot; a step may be any whole number of its internal steps.

    Args:
        experiment: What to simulate.
        values: Memory for the variables.
    """

    description = "Simulated robot with muscles"
    has_derivatives = True

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        robot = experiment.plant_robot
        n, m = len(robot.coordinates), len(robot.muscles)
        self._robot = robot
        self._plant = Plant(robot, experiment.plant.step)
        self._forces, self._loads = np.split(self.inputs, [m])
        self._q, self._qd, self._lengths, self._tasks = np.split(
            self.outputs, [n, 2 * n, 2 * n + m]
        )
        self.states = self.inputs.size + np.arange(2 * n)
        self._q_start, self._qd_start, self._step = np.split(self.parameters, [n, 2 * n])

    @staticmethod
    def table(experiment: Experiment) -> list[Port]:
        """The table of variables for an experiment."""
        start = experiment.start
        return plant_ports(experiment.robot, start.q, start.qd, experiment.plant.step)

    def initialize(self, t: float = 0.0) -> None:
        """Go to the start state."""
        for coordinate, q in zip(self._robot.coordinates, self._q_start, strict=True):
            if not coordinate.lower <= q <= coordinate.upper:
                limits = f"{coordinate.lower!r} to {coordinate.upper!r}"
                raise InputError(f"q_start of {coordinate.name!r}, {q!r}, is outside {limits}")
        if self._step[0] != self._plant.step_size:
            self._plant = Plant(self._robot, float(self._step[0]))
        self._plant.reset(self._q_start, self._qd_start)
        self._write_outputs()

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h, with forces and loads held."""
        plant = self._plant
        loads = self._loads if self._loads.any() else None
        for _ in range(whole_steps(h, plant.step_size, "the plant's internal step")):
            plant.step(self._forces, loads=loads)
        self._write_outputs()

    def get_state(self) -> bytes:
        """Number of steps, q and qd."""
        return self._plant.get_state().tobytes()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        if len(state) % 8:
            raise InputError(f"a plant's state is a row of float64, not {len(state)} bytes")
        self._plant.set_state(np.frombuffer(state))
        self._write_outputs()

    def set_states(self, states: FloatArray) -> None:
        """Go to other q and qd."""
        state = self._plant.get_state()
        state[1:] = states
        self._plant.set_state(state)
        self._write_outputs()

    def _write_outputs(self) -> None:
        plant = self._plant
        self._q[:] = plant.q
        self._qd[:] = plant.qd
        self._lengths[:] = plant.lengths_view
        if self._tasks.size:
            self._tasks[:] = plant.task_position
