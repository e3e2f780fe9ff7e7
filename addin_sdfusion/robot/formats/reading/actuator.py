"""Reader of the motor, gear, spindle and spring elements of a muscle in cardsflow.xml."""

from __future__ import annotations

from ...model.muscle import CableModel
from .xml import Node

ACTUATOR: dict[str, dict[str, str]] = {
    "motor": {
        "bemf_constant": "back_emf_constant",
        "torque_constant": "torque_constant",
        "inductance": "inductance",
        "resistance": "resistance",
        "inertiaMoment": "motor_inertia",
    },
    "gear": {
        "ratio": "gear_ratio",
        "efficiency": "gear_efficiency",
        "inertiaMoment": "gear_inertia",
    },
    "spindle": {"radius": "spindle_radius"},
    "SEE": {"stiffness": "stiffness"},
}
"""Names in the original format, by element, with the parameters of `series_elastic_motor`."""


def read_actuator(muscle: Node) -> CableModel | None:
    """Return the muscle law that motor elements define, or None if the muscle has none.

    The original plug-in requires these elements but overwrites their values. Here the values are
    used, and a finding lists the parameters that they replace.
    """
    elements = muscle.all(*ACTUATOR)
    if not elements:
        return None
    if muscle.optional("cable_model") is not None:
        elements[0].warning(
            "actuator-left-out",
            "its motor, gear and spring elements are ignored because it has a <cable_model>",
        )
        return None
    parameters: dict[str, float] = {}
    for element in elements:
        parameters |= _parameters(element)
    problem = (
        "its motor elements define a series_elastic_motor, whose command is a voltage; they "
        f"replace the default {', '.join(parameters) or '(nothing)'}; remove them to command forces"
    )
    elements[0].warning("actuator-read", problem)
    return CableModel("series_elastic_motor", tuple(parameters.items()))


def _parameters(element: Node) -> dict[str, float]:
    words = ACTUATOR[element.tag]
    parameters = {}
    for child in element.all():
        if child.tag in words:
            parameters[words[child.tag]] = child.numbers(1)[0]
        else:
            problem = f"<{child.tag}> of <{element.tag}> is ignored"
            child.warning("actuator-part-left-out", problem, words)
    return parameters
