"""Import of custom controllers from Python files, with checks of their results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, SimulationError
from addin_sdfusion.robot.custom_code import WrongBaseClassError, call_custom, load_class
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.experiment.config.custom_law import CustomLaw
from controllers import ForceSolution, JointSpaceController, OperationalSpaceController
from controllers.dynamics import actuator_names

Law = JointSpaceController | OperationalSpaceController

CLASSES: dict[Space, type[Law]] = {
    "joint": JointSpaceController,
    "operational": OperationalSpaceController,
}


def import_custom_law(custom: CustomLaw, space: Space) -> Callable[..., Law]:
    """Import the class of a custom controller. This executes the file.

    The methods of the returned class raise errors that name file and line. They also raise an error
    for forces that are not finite.
    """
    try:
        law = load_class(custom.file, custom.name, CLASSES[space])
    except WrongBaseClassError as error:
        other = next((s for s, base in CLASSES.items() if issubclass(error.loaded, base)), None)
        if other is None:
            raise
        advice = f'the class follows a {other} reference; set controller.space = "{other}"'
        raise InputError(f"{error.problem}; {advice}", file=custom.file) from None

    class Checked(law):  # type: ignore[misc, valid-type]
        """Custom class with checked results."""

        def __init__(self, *arguments: Any, **named: Any) -> None:
            call_custom(custom.file, lambda: super(Checked, self).__init__(*arguments, **named))

        def solve(self, q: Any, qd: Any, *reference: Any, **loads: Any) -> ForceSolution:
            solve = super().solve
            solution = call_custom(custom.file, lambda: solve(q, qd, *reference, **loads))
            if not isinstance(solution, ForceSolution):
                solution = self._as_solution(q, qd, solution)
            if not np.isfinite(solution.forces).all():
                raise SimulationError(
                    f"{custom.file}: {custom.name}.solve returned forces that are not finite: "
                    f"{solution.forces}"
                )
            return solution

        def _as_solution(self, q: Any, qd: Any, forces: Any) -> ForceSolution:
            """Create a solution: clip forces to the limits and compute the slack."""
            robot, bounds = self.dynamics, self.distribution
            output = np.asarray(forces, dtype=np.float64)
            if output.shape != bounds.f_min.shape:
                raise SimulationError(
                    f"{custom.file}: {custom.name}.solve returned forces of shape {output.shape}, "
                    f"not {bounds.f_min.shape}"
                )
            clipped = np.clip(output, bounds.f_min, bounds.f_max)
            slack = robot.actuator_jacobian(q).T @ (clipped - output)
            return ForceSolution(
                clipped,
                "solved" if not slack.any() else "soft",
                slack,
                bounds.f_min,
                bounds.f_max,
                robot.coordinate_names,
                actuator_names(robot),
            )

    Checked.__name__ = Checked.__qualname__ = custom.name
    return Checked
