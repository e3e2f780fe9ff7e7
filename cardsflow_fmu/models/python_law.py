"""Python callbacks of the control loop in C: the control law and muscle laws."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import ForceSolution, OperationalSpaceSolution, Posture
from controllers.laws.loop_in_c import Callbacks, LawStructure
from controllers.qp.solver import DEFAULT_SOLVER
from sim_dart import CoreDynamics, DartDynamics, control_dynamics
from sim_dart.muscles.custom_laws import CustomLaws

from .custom_law import CLASSES, Law, import_custom_law
from .native.opened_model import OpenedModel

_Forces = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)
_Reach = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_Invert = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2)


class _MuscleFunctions(ctypes.Structure):
    """The C structure `muscle_functions` in muscles.h."""

    _fields_ = (
        ("self", ctypes.c_void_p),
        ("forces", _Forces),
        ("reach", _Reach),
        ("invert", _Invert),
    )


def law_in_python(experiment: Experiment) -> str | None:
    """Return the reason why the law computes in Python, or None if it computes in C."""
    controller = experiment.controller
    if controller.engine == "dart" and not experiment.robot.loops:
        return 'the engine "dart"'
    if controller.custom_law is not None:
        return f"the custom law {controller.type!r} in Python"
    if controller.solver != DEFAULT_SOLVER:
        return f"the QP solver {controller.solver!r}"
    return None


class PythonController:
    """Controller in C with a control law or muscle laws in Python.

    Args:
        valid: Whether the estimate is valid, shape (1,); shape (0,) without an estimator.
    """

    def __init__(self, experiment: Experiment, opened: OpenedModel, valid: FloatArray) -> None:
        self._opened, self._valid = opened, valid
        self._callbacks = calls = Callbacks()
        self._law: Law | None = None
        self._muscles = CustomLaws(experiment.robot)
        n = len(experiment.robot.coordinates)
        law, muscles = LawStructure(), _MuscleFunctions()
        if law_in_python(experiment) is not None:
            dynamics = law_dynamics(experiment)
            self._law, self._slip = control_law(experiment, dynamics), dynamics.cable_slip
            self._bounds = opened.array("f_min"), opened.array("f_max")
            self._gains = opened.array("kp"), opened.array("kd")
            self._dropped = opened.array("limits_dropped")
            self._parameters = [np.empty(0)] * 4
            sizes = n, self._bounds[0].size, self._gains[0].size
            law = calls.law(sizes, self._solve, self._law.error)
        if self._muscles:
            names = ("lengths", "rates", "force_low", "force_high", "commands")
            self._paths = [opened.array(name) for name in names]
            muscles.forces, muscles.reach, muscles.invert = (
                _Forces(calls.guard(self._forces)),
                _Reach(calls.guard(self._reach)),
                _Invert(calls.guard(self._invert)),
            )
        self._structures = law, muscles  # C stores pointers to these structures
        opened.use(law, muscles)

    def initialize(self, t: float) -> None:
        """Set the start state of the controller and of the law."""
        self._opened.initialize(t)
        self._reset()

    def step(self, t: float, h: float) -> None:
        """Execute one tick; raise the exception of a callback, if it failed."""
        try:
            self._opened.step(t, h)
        finally:
            self._callbacks.raise_stored()
        if self._valid.size and not self._valid[0]:
            self._reset()

    def get_state(self) -> bytes:
        """Return the state of the controller, followed by the state of the law."""
        return self._opened.get_state() + self._law_state()

    def set_state(self, state: bytes) -> None:
        """Restore a state from `get_state`."""
        end = len(state) - len(self._law_state())
        if end != len(self._opened.get_state()):
            raise InputError(f"invalid state of this controller: {len(state)} bytes")
        self._opened.set_state(state[:end])
        if self._law is not None:
            self._law.set_state(np.frombuffer(state[end:]))

    def _law_state(self) -> bytes:
        return b"" if self._law is None else self._law.get_state().tobytes()

    def _reset(self) -> None:
        if self._law is not None:
            self._law.reset()

    def _solve(self, *state: FloatArray, **loads: FloatArray) -> ForceSolution:
        law = self._law
        assert law is not None
        self._update_parameters(law)
        solution = law.solve(*state, **loads)
        if isinstance(solution, OperationalSpaceSolution):
            self._dropped[0] = solution.limits_dropped
        return solution

    def _update_parameters(self, law: Law) -> None:
        """Pass the current gains, force limits and slip directions of cables to the law."""
        current = [*self._gains, *self._bounds]
        changed = [not np.array_equal(a, b) for a, b in zip(current, self._parameters, strict=True)]
        if any(changed[:2]):
            law.set_gains(*(row.copy() for row in current[:2]))
        if any(changed[2:]):
            law.set_bounds(*(row.copy() for row in current[2:]))
        self._parameters = [row.copy() for row in current]
        if self._slip is not None:
            count = self._slip.states.size
            self._slip.states[:] = self._opened.array("law_states")[-count:]

    def _forces(self, commands: int, inner: int) -> None:
        lengths, rates, *_others = self._paths
        u = self._callbacks.read(commands, lengths.size)
        self._callbacks.view(inner, lengths.size)[:] = self._muscles.forces(u, lengths, rates)

    def _reach(self) -> None:
        lengths, rates, low, high, _commands = self._paths
        self._muscles.reach(low, high, lengths, rates)

    def _invert(self, forces: int) -> None:
        lengths, rates, _low, _high, commands = self._paths
        desired = self._callbacks.read(forces, lengths.size)
        self._muscles.invert(commands, desired, lengths, rates)


def law_dynamics(experiment: Experiment) -> CoreDynamics | DartDynamics:
    """Return the robot model for a law in Python."""
    robot, settings = experiment.robot, experiment.controller
    if settings.engine == "dart" and not robot.loops:
        return DartDynamics(robot)
    return control_dynamics(robot, settings.dependent)


def control_law(experiment: Experiment, dynamics: CoreDynamics | DartDynamics) -> Law:
    """Create the control law of an experiment."""
    settings = experiment.controller
    custom, tasks, arrays = settings.custom_law, settings.tasks, settings.law_arrays()
    law: Callable[..., Law] = (
        CLASSES[settings.space] if custom is None else import_custom_law(custom, settings.space)
    )
    if tasks is None:
        return law(
            dynamics,
            settings.kp,
            settings.kd,
            weights=arrays["H_f"],
            solver=settings.solver,
            **({"norm": settings.norm} if settings.norm != 2.0 else {}),
            **({"pretension": arrays["f_p"]} if any(settings.pretension) else {}),
            **({"passive": settings.uncontrolled} if any(settings.uncontrolled) else {}),
            **({"law": settings.type} if custom is None else {}),
        )
    posture = tasks.posture
    return law(
        dynamics,
        settings.kp,
        settings.kd,
        posture=None if posture is None else Posture(posture.kd, posture.kp, posture.q0),
        task_weights=tasks.task_weights,
        priorities=tasks.priorities,
        acceleration_weights=tasks.acceleration_weights,
        force_weights=arrays["H_f"],
        force_rate_weights=arrays["H_r"],
        pretension=arrays["f_p"],
        limit_bandwidth=tasks.limit_bandwidth,
        solver=settings.solver,
    )
