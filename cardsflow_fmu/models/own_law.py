"""Custom controllers: classes from Python files, with checked results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, SimulationError
from addin_sdfusion.robot.custom_code import WrongBaseClassError, call_custom, load_class
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.settings.custom_law import CustomLaw
from controllers import ForceSolution, JointSpaceController, OperationalSpaceController
from controllers.dynamics import actuator_names

Law = JointSpaceController | OperationalSpaceController

CLASSES: dict[Space, type[Law]] = {
    "joint": JointSpaceController,
    "operational": OperationalSpaceController,
}


def own_law(own: CustomLaw, space: Space) -> Callable[..., Law]:
    """Import the class of a custom controller. This runs the file.

    Errors in its methods name file and line. Forces that are not finite are errors as well.

    Args:
        own: File and class.
        space: Space of the reference.

    Raises:
        InputError: The file cannot be imported, or the class is not a controller.
    """
    try:
        found = load_class(own.file, own.name, CLASSES[space])
    except WrongBaseClassError as error:
        other = next((s for s, base in CLASSES.items() if issubclass(error.found, base)), None)
        if other is None:
            raise
        what = f'it follows a reference in {other} space; set controller.space = "{other}"'
        raise InputError(f"{error.what}; {what}", file=own.file) from None

    class Checked(found):  # type: ignore[misc, valid-type]
        """The custom class with checked results."""

        def __init__(self, *arguments: Any, **named: Any) -> None:
            call_custom(own.file, lambda: super(Checked, self).__init__(*arguments, **named))

        def solve(self, q: Any, qd: Any, *reference: Any, **loads: Any) -> ForceSolution:
            solve = super().solve
            solution = call_custom(own.file, lambda: solve(q, qd, *reference, **loads))
            if not isinstance(solution, ForceSolution):
                solution = self._as_solution(q, qd, solution)
            if not np.isfinite(solution.forces).all():
                what = f"{own.name}.solve returned forces that are not finite: {solution.forces}"
                raise SimulationError(f"{own.file}: {what}")
            return solution

        def _as_solution(self, q: Any, qd: Any, forces: Any) -> ForceSolution:
            """Complete forces to a solution: clip them to the limits; the rest is slack."""
            robot, bounds = self.dynamics, self.distribution
            given = np.asarray(forces, dtype=np.float64)
            if given.shape != bounds.f_min.shape:
                what = f"{own.name}.solve returned forces of shape {given.shape}"
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
