"""Checks of tension laws: known, given and consistent parameters."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise

from ..caspr_vocabulary import CASPR_CABLES
from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, finite, unknown
from ..model.muscle import CableModel
from ..model.robot import Robot
from ..model.tension_laws import TENSION_LAWS
from ..model.tension_parameters import Parameter

Values = Mapping[str, float]

_ALSO_CASPRS = {
    cable.kind: [item.tag for item in cable.properties] for cable in CASPR_CABLES.values()
}
"""What CASPR's files say of a cable beside its law, such as its diameter."""


def tension_laws(robot: Robot) -> Iterator[Finding]:
    """Muscles of every cable set whose law cannot be computed with their parameters."""
    for subject, muscle in all_muscles(robot):
        yield from law_findings(subject, muscle.model)


def law_findings(subject: Subject, model: CableModel) -> Iterator[Finding]:
    """What is wrong with a muscle's tension law.

    Args:
        subject: Whose law it is.
        model: The law and its parameters, however broken.
    """
    if model.kind not in TENSION_LAWS:
        return
    parameters = TENSION_LAWS[model.kind].parameters
    yield from _names(subject, model, parameters)
    given = dict(model.parameters)
    for parameter in parameters:
        if parameter.name not in given and parameter.default is None:
            problem = f"a {model.kind} needs {_described(parameter)}"
            yield error(subject, "missing-law-parameter", problem)
    values = {p.name: given.get(p.name, p.default) for p in parameters}
    known = {name: value for name, value in values.items() if value is not None}
    bad = list(_out_of_bounds(parameters, known))
    if not bad and len(known) == len(values) and finite(known.values()):
        try:
            bad = [problem for rule in _RULES.get(model.kind, ()) for problem in rule(known)]
        except ArithmeticError:
            bad = ["parameters are so small or large that their quotients are no numbers"]
    for problem in bad:
        yield error(subject, "bad-law-parameter", f"{model.kind}: {problem}")


def _names(
    subject: Subject, model: CableModel, parameters: tuple[Parameter, ...]
) -> Iterator[Finding]:
    known = [parameter.name for parameter in parameters]
    allowed = {*known, *_ALSO_CASPRS.get(model.kind, ())}
    counts = Counter(name for name, _ in model.parameters)
    for name, count in counts.items():
        if model.kind != "ideal" and name not in allowed:
            problem = f"{model.kind}: {unknown('parameter', name, known)}"
            yield error(subject, "unknown-law-parameter", problem)
        if count > 1:
            problem = f"{model.kind}: parameter {name!r} is given {count} times; keep one"
            yield error(subject, "repeated-law-parameter", problem)


def _described(parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
    return f"{parameter.name}{unit} ({parameter.meaning})"


def _out_of_bounds(parameters: Iterable[Parameter], values: Values) -> Iterator[str]:
    """Values beside their bounds. The check of all numbers finds those that are not finite."""
    for parameter in parameters:
        value, low, high = values.get(parameter.name, math.nan), parameter.low, parameter.high
        is_low = value < low or (parameter.open_low and value == low)
        if math.isfinite(value) and (is_low or value > high):
            least = f"above {low:g}" if parameter.open_low else f"{low:g} or more"
            most = "" if high == math.inf else f", and {high:g} at most"
            yield f"{parameter.name} {value!r} must be {least}{most}"


def _tendon(p: Values) -> Iterator[str]:
    if p["elastic_tendon"] not in (0.0, 1.0):
        yield "elastic_tendon must be 0 or 1"
    elif p["elastic_tendon"] and p["tendon_slack_length"] == 0.0:
        yield "an elastic tendon needs a tendon_slack_length above 0"


def _millard_lengths(p: Values) -> Iterator[str]:
    lengths = [p["active_shortest"], p["active_transition"], 0.95, 1.1, p["active_longest"]]
    if any(a >= b for a, b in pairwise(lengths)):
        yield "active_shortest < active_transition < 0.95 and 1.1 < active_longest must hold"
        return
    mean = 1.0 / (0.95 - p["active_shortest"])
    at_transition = 1.0 - p["active_shallow_slope"] * (0.95 - p["active_transition"])
    rise = 1.25 * at_transition / (p["active_transition"] - p["active_shortest"])
    if p["active_shallow_slope"] >= mean:
        yield f"active_shallow_slope must be below {mean:g}, the mean slope up to the plateau"
    elif rise <= mean:
        yield "active_transition is too far from active_shortest to rise in between"
    elif p["active_minimum"] >= at_transition / 2.0:
        yield f"active_minimum must be below {at_transition / 2.0:g}, half of where the slope turns"


def _millard_velocity(p: Values) -> Iterator[str]:
    for part in ("concentric", "eccentric"):
        if p[f"{part}_slope_at_vmax"] > p[f"{part}_slope_near_vmax"]:
            yield f"{part}_slope_at_vmax must not be above {part}_slope_near_vmax"
    if p["eccentric_slope_near_vmax"] >= p["eccentric_force"] - 1.0:
        yield "eccentric_slope_near_vmax must be below eccentric_force - 1"
    if p["concentric_slope_near_vmax"] == 1.0:
        yield "concentric_slope_near_vmax must be below 1"
    least = max(p["eccentric_force"] - 1.0, 1.0) / 0.9
    if p["isometric_slope"] <= least:
        yield f"isometric_slope must be above {least:g} to reach the ends of the curve"


def _millard_passive(p: Values) -> Iterator[str]:
    strain = p["passive_fibre_strain"] - p["passive_zero_strain"]
    if strain <= 0.0:
        yield "passive_fibre_strain must be above passive_zero_strain"
        return
    stiffness, low = p["passive_stiffness"] or 2.0 / strain, p["passive_stiffness_low"]
    toe = min(0.1 / stiffness, 0.1 * strain)
    mean = (1.0 - low * toe / 2.0) / (strain - toe)
    if low >= mean:
        yield f"passive_stiffness_low must be below {mean:g}, the mean slope"
    elif stiffness <= mean:
        yield f"passive_stiffness must be 0, or above {mean:g}, the mean slope"


def _millard_tendon(p: Values) -> Iterator[str]:
    least = 1.0 / p["tendon_strain"]
    if 0.0 < p["tendon_stiffness"] <= least:
        yield f"tendon_stiffness must be 0, or above {least:g}, one over the strain"


def _millard_angle(p: Values) -> Iterator[str]:
    if p["pennation_at_optimal"] >= p["maximum_pennation"]:
        yield "pennation_at_optimal must be below maximum_pennation"


def _thelen_velocity(p: Values) -> Iterator[str]:
    if not 1.0 < p["linear_from"] * p["eccentric_force"] < p["eccentric_force"]:
        yield "linear_from must be below 1 and, times eccentric_force, above 1"


def _mujoco(p: Values) -> Iterator[str]:
    if p["length_low"] >= p["length_high"]:
        yield "length_high must be above length_low"
    if p["force"] < 0.0 and p["acc0"] == 0.0:
        yield "acc0 must be above 0 where force is negative"
    for low, high in (("range_low", "range_high"), ("passive_range_low", "passive_range_high")):
        if p[low] >= p[high] and (p[low], p[high]) != (0.0, 0.0):
            yield f"{high} must be above {low}"
    if p["lmin"] >= 1.0 or 0.0 < p["passive_lmax"] <= 1.0:
        yield "lmin must be below 1, and passive_lmax 0 or above 1"
    if p["control_low"] > p["control_high"]:
        yield "control_low must not be above control_high"


def _tendon_spring(p: Values) -> Iterator[str]:
    if p["rest_low"] > p["rest_high"]:
        yield "rest_low must not be above rest_high"


MOST_QUICKNESS = 1e6
"""In [1/s]: of a motor; faster ones would need steps below a microsecond."""


def _motor_quickness(p: Values) -> Iterator[str]:
    inertia = p["motor_inertia"] + p["gear_inertia"]
    rates = (
        (p["resistance"] + p["bridge_resistance"]) / p["inductance"],
        math.sqrt(p["back_emf_constant"] * p["torque_constant"] / (p["inductance"] * inertia)),
        math.sqrt(p["stiffness"] / (p["gear_efficiency"] * inertia))
        * p["spindle_radius"]
        / p["gear_ratio"],
    )
    if sum(rates) > MOST_QUICKNESS:
        yield (
            f"it changes at a rate of {sum(rates):.3g} a second, {MOST_QUICKNESS:g} is the most; "
            "see inductance, inertias and stiffness"
        )


_RULES: dict[str, tuple[Callable[[Values], Iterator[str]], ...]] = {
    "series_elastic_motor": (_motor_quickness,),
    "hill_degroote2016": (_tendon,),
    "hill_millard2012": (
        _tendon,
        _millard_angle,
        _millard_lengths,
        _millard_velocity,
        _millard_passive,
        _millard_tendon,
    ),
    "hill_thelen2003": (_tendon, _thelen_velocity),
    "hill_schutte1993": (_tendon,),
    "mujoco_muscle": (_mujoco,),
    "tendon_spring": (_tendon_spring,),
}
