"""Controllers of one's own: classes from files of Python, checked where they meet ours."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError, UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.settings.controller_types import OwnLaw
from controllers import ForceSolution, JointSpaceController, OperationalSpaceController
from controllers.dynamics import actuator_names

Law = JointSpaceController | OperationalSpaceController

_BASES: dict[Space, type[Law]] = {
    "joint": JointSpaceController,
    "operational": OperationalSpaceController,
}
T = TypeVar("T")


def own_law(own: OwnLaw, space: Space) -> Callable[..., Law]:
    """The class of a controller of one's own; the file is run.

    What it does wrong later is an error that names file and line, and so are forces that are no
    numbers.

    Args:
        own: File and class.
        space: What it is to follow.

    Raises:
        InputError: The file cannot be run, or the class is none of a controller.
    """
    found = getattr(_module(own.file), own.name, None)
    base = _BASES[space]
    if not isinstance(found, type):
        raise UnknownNameError("class", own.name, [], file=own.file)
    if not issubclass(found, base):
        other = next((s for s, b in _BASES.items() if issubclass(found, b)), None)
        what = f"{own.name} is no subclass of controllers.{base.__name__}"
        if other is not None:
            what += f'; it follows a reference in {other} space: say controller.space = "{other}"'
        raise InputError(what, file=own.file)

    class Checked(found):  # type: ignore[misc, valid-type]
        """The class, with checks of what it gives."""

        def __init__(self, *arguments: Any, **named: Any) -> None:
            _guarded(own.file, lambda: super(Checked, self).__init__(*arguments, **named))

        def solve(self, q: Any, qd: Any, *reference: Any, **loads: Any) -> ForceSolution:
            solve = super().solve
            solution = _guarded(own.file, lambda: solve(q, qd, *reference, **loads))
            if not isinstance(solution, ForceSolution):
                solution = self._as_solution(q, qd, solution)
            if not np.isfinite(solution.forces).all():
                what = f"{own.name}.solve gave forces that are not finite: {solution.forces}"
                raise SimulationError(f"{own.file}: {what}")
            return solution

        def _as_solution(self, q: Any, qd: Any, forces: Any) -> ForceSolution:
            """Forces alone: those beyond the bounds are held at them, and what lacks is slack."""
            robot, bounds = self.dynamics, self.distribution
            given = np.asarray(forces, dtype=np.float64)
            if given.shape != bounds.f_min.shape:
                what = f"{own.name}.solve gave forces of shape {given.shape}"
                raise SimulationError(f"{own.file}: {what}, not {bounds.f_min.shape}")
            held = np.clip(given, bounds.f_min, bounds.f_max)
            slack = robot.actuator_jacobian(q).T @ (held - given)
            return ForceSolution(
                held,
                "solved" if not slack.any() else "soft",
                slack,
                bounds.f_min,
                bounds.f_max,
                robot.coordinate_names,
                actuator_names(robot),
            )

    Checked.__name__ = Checked.__qualname__ = own.name
    return Checked


def _module(file: Path) -> ModuleType:
    """The file as a module of its own, run anew."""
    name = f"_controller_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file.absolute())
    if spec is None or spec.loader is None:
        raise InputError("is no file of Python", file=file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look there
    loader = spec.loader
    _guarded(file, lambda: loader.exec_module(module))
    return module


def _guarded(file: Path, call: Callable[[], T]) -> T:
    """What a call into the file gives; its errors with the line that made them."""
    try:
        return call()
    except CardsflowError:
        raise
    except Exception as error:
        own = str(file.absolute())
        rows = [r for r in traceback.extract_tb(error.__traceback__) if r.filename == own]
        line = rows[-1].lineno if rows else getattr(error, "lineno", None)
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(what, file=file, line=line) from error
