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
    parts = muscle.all(*ACTUATOR)
    if not parts:
        return None
    if muscle.optional("cable_model") is not None:
        parts[0].warning(
            "actuator-left-out",
            "its motor, gear and spring elements are ignored because it has a <cable_model>",
        )
        return None
    given: dict[str, float] = {}
    for part in parts:
        given |= _parameters(part)
    problem = (
        "its motor elements define a series_elastic_motor, whose command is a voltage; they "
        f"replace the default {', '.join(given) or '(nothing)'}; remove them to command forces"
    )
    parts[0].warning("actuator-read", problem)
    return CableModel("series_elastic_motor", tuple(given.items()))


def _parameters(part: Node) -> dict[str, float]:
    words = ACTUATOR[part.tag]
    found = {}
    for child in part.all():
        if child.tag in words:
            found[words[child.tag]] = child.numbers(1)[0]
        else:
            known = ", ".join(words)
            problem = f"<{child.tag}> of <{part.tag}> is ignored (known: {known})"
            child.warning("actuator-part-left-out", problem)
    return found
