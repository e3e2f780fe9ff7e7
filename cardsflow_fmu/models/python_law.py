"""Python callbacks of the control loop in C: the control law and muscle laws."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import OperationalSpaceSolution, Posture
from controllers.qp.solver import DEFAULT_SOLVER
from sim_dart import CoreDynamics, DartDynamics, control_dynamics
from sim_dart.muscles.custom_laws import CustomLaws

from .custom_law import CLASSES, Law, import_custom_law
from .native.opened_model import OpenedModel

_STATUSES = ("solved", "soft", "not converged", "failed")  # in the order of computed_torque.h

_Row = ctypes.POINTER(ctypes.c_double)
_Torque = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, *[_Row] * 6)
_Solve = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, *[_Row] * 7)
_Error = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *[_Row] * 3)
_Forces = ctypes.CFUNCTYPE(None, ctypes.c_void_p, _Row, _Row)
_Reach = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
_Invert = ctypes.CFUNCTYPE(None, ctypes.c_void_p, _Row)


class _ControlLaw(ctypes.Structure):
    """The C structure `control_law` in control_loop.h."""

    _fields_ = (
        ("self", ctypes.c_void_p),
        ("torque", _Torque),
        ("solve", _Solve),
        ("error", _Error),
    )


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
        self._raised: BaseException | None = None
        self._law: Law | None = None
        self._muscles = CustomLaws(experiment.robot)
        n = len(experiment.robot.coordinates)
        law, muscles = _ControlLaw(), _MuscleFunctions()
        if law_in_python(experiment) is not None:
            dynamics = law_dynamics(experiment)
            self._law, self._slip = control_law(experiment, dynamics), dynamics.cable_slip
            self._set_up(n)
            law.solve, law.error = _Solve(self._solve), _Error(self._error)
        if self._muscles:
            names = ("lengths", "rates", "force_low", "force_high", "commands")
            self._paths = [opened.array(name) for name in names]
            muscles.forces, muscles.reach, muscles.invert = (
                _Forces(self._forces),
                _Reach(self._reach),
                _Invert(self._invert),
            )
        self._callbacks = law, muscles  # C stores pointers to these structures
        opened.use(law, muscles)

    def _set_up(self, n: int) -> None:
        opened = self._opened
        self._bounds = opened.array("f_min"), opened.array("f_max")
        self._gains = opened.array("kp"), opened.array("kd")
        self._dropped = opened.array("limits_dropped")
        self._n, self._r, self._a = n, self._gains[0].size, self._bounds[0].size
        self._parameters = [np.empty(0)] * 4

    def initialize(self, t: float) -> None:
        """Set the start state of the controller and of the law."""
        self._opened.initialize(t)
        self._reset()

    def step(self, t: float, h: float) -> None:
        """Execute one tick; raise the exception of a callback, if it failed."""
        try:
            self._opened.step(t, h)
        finally:
            self._raise_stored()
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

    def _raise_stored(self) -> None:
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised

    def _catch(self, call: Callable[[], Any]) -> Any:
        """Return the result of a call, or None after an exception.

        The exception is stored, since it must not propagate through C.
        """
        try:
            return call()
        except BaseException as error:
            self._raised = self._raised or error
            return None

    def _solve(self, _: int, *rows: Any) -> int:
        status: int | None = self._catch(lambda: self._solve_law(*rows))
        return _STATUSES.index("failed") if status is None else status

    def _solve_law(
        self, q: Any, qd: Any, reference: Any, correction: Any, load: Any, forces: Any, slack: Any
    ) -> int:
        law, n, r = self._law, self._n, self._r
        assert law is not None
        self._update_parameters(law)
        position, velocity, acceleration = _array(reference, 3 * r).reshape(3, r)
        solution = law.solve(
            *(_array(q, n), _array(qd, n), position, velocity, acceleration),
            w_e=_array(load, n),
            correction=_array(correction, r),
        )
        _view(forces, self._a)[:] = solution.forces
        _view(slack, r)[:] = solution.slack
        if isinstance(solution, OperationalSpaceSolution):
            self._dropped[0] = solution.limits_dropped
        return _STATUSES.index(solution.status)

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

    def _error(self, _: int, q: Any, position: Any, error: Any) -> None:
        law, r = self._law, self._r
        assert law is not None
        result = self._catch(lambda: law.error(_array(q, self._n), _array(position, r)))
        if result is not None:
            _view(error, r)[:] = result

    def _forces(self, _: int, commands: Any, inner: Any) -> None:
        lengths, rates, *_others = self._paths
        u = _array(commands, lengths.size)
        forces = self._catch(lambda: self._muscles.forces(u, lengths, rates))
        if forces is not None:
            _view(inner, lengths.size)[:] = forces

    def _reach(self, _: int) -> None:
        lengths, rates, low, high, _commands = self._paths
        self._catch(lambda: self._muscles.reach(low, high, lengths, rates))

    def _invert(self, _: int, forces: Any) -> None:
        lengths, rates, _low, _high, commands = self._paths
        desired = _array(forces, lengths.size)
        self._catch(lambda: self._muscles.invert(commands, desired, lengths, rates))


def _view(row: Any, size: int) -> FloatArray:
    """Return a view of the C memory at a pointer."""
    return np.ctypeslib.as_array(row, (size,))


def _array(row: Any, size: int) -> FloatArray:
    return _view(row, size).copy()


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
