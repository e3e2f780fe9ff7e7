"""Muscles, ligaments and cables of OpenSim."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ....checks.driven import function_fault
from ....finding import Subject
from ....model import function
from ....model.laws import MUSCLE_LAWS
from ....model.muscle import CableKind, CableModel, Muscle
from ....model.schutte_curves import RANGES, SCHUTTES_CURVES
from ...reading.xml import Node
from ..writing.muscles import (
    CLASSES,
    MILLARDS_CURVES,
    PROPERTIES,
    millards_stiffnesses,
    taken_by_opensim,
)
from .document import is_true
from .functions import read_terms
from .paths import Surroundings, geometry_path, read_points, read_wraps

KINDS: dict[str, CableKind] = {
    **{class_: kind for kind, class_ in CLASSES.items()},
    "PathActuator": "ideal",
}
DEFAULTS: dict[str, dict[str, float]] = {
    "hill": {"max_isometric_force": 1000.0, "optimal_fibre_length": 0.1,
             "tendon_slack_length": 0.2},
    "ligament_blankevoort1991": {"linear_stiffness": 1.0, "slack_length": 0.0},
    "path_spring": {},
}  # fmt: skip
"""OpenSim's own values of what our laws want to be given."""


SAME = 1e-9
"""Over F0: curves that are no further apart are the same."""
STRENGTH = "max_isometric_force"
"""What all muscles of OpenSim have, and other forces along paths have not."""


def is_muscle(node: Node) -> bool:
    """Return whether a force acts along a path."""
    return node.tag in KINDS or bool(node.all("GeometryPath", "path"))


def read_muscle(node: Node, around: Surroundings) -> Muscle | None:
    """A muscle; None if it is not to act, or neither its law nor its strength is known."""
    node = node.about(Subject("muscle", node.attribute("name")))
    if not is_true(node, "appliesForce", True) or is_true(node, "isDisabled", False):
        node.warning("muscle-left-out", "it is disabled in the file; ignored")
        return None
    if node.tag not in KINDS and not node.all(STRENGTH):
        known = ", ".join(KINDS)
        problem = f"<{node.tag}> is not supported; ignored (supported: {known})"
        node.warning("muscle-left-out", problem)
        return None
    path = geometry_path(node)
    if path is None:
        return None
    points = read_points(path, around)
    wraps = tuple(read_wraps(path, around, len(points)))
    muscle = Muscle(node.subject.name, tuple(points), wraps=wraps)
    if node.tag == "PathActuator":
        return _actuator(node, muscle)
    if node.tag not in KINDS:
        return _cable(node, muscle)
    return replace(muscle, model=CableModel(KINDS[node.tag], tuple(_parameters(node))))


def _cable(node: Node, muscle: Muscle) -> Muscle:
    """Of a muscle whose law is not known the path, and the force that it has at most."""
    most = node.number(STRENGTH)
    problem = (
        f"the law of <{node.tag}> is not supported: its path pulls as an ideal cable, with any "
        f"force up to its max_isometric_force of {most:g} N, at once"
    )
    node.warning("muscle-as-cable", problem)
    return replace(muscle, f_max=max(most, 0.0))


def _actuator(node: Node, muscle: Muscle) -> Muscle:
    """Return a cable whose control times its optimal force is the tension."""
    scale = node.number("optimal_force", 1.0)
    low = scale * node.number("min_control", float("-inf"), infinite=True)
    high = scale * node.number("max_control", float("inf"), infinite=True)
    if low < 0.0:
        node.warning("cable-pulls-only", f"its tension may be {low:g} N; here it only pulls")
    return replace(muscle, f_min=max(low, 0.0), f_max=max(high, 0.0))


def _parameters(node: Node) -> Iterator[tuple[str, float]]:
    """The parameters of a law that differ from their defaults, in its order."""
    kind = KINDS[node.tag]
    values = dict(DEFAULTS.get(kind, DEFAULTS["hill"]))
    values |= _given(node, PROPERTIES[kind])
    if "activation_time_constant" in PROPERTIES[kind]:
        rigid = kind != "hill_thelen2003" and is_true(node, "ignore_tendon_compliance", False)
        values["elastic_tendon"] = 0.0 if rigid else 1.0
        if is_true(node, "ignore_activation_dynamics", False):
            problem = "its activation is its excitation in the file; here it follows with a delay"
            node.warning("activation-dynamics", problem)
    if kind == "hill_schutte1993":
        values |= {"elastic_tendon": 1.0, **_schuttes_times(node)}
        _note_other_curves(node, values["max_isometric_force"])
    if kind == "hill_millard2012":
        for curve, names in MILLARDS_CURVES.items():
            child = node.optional(curve)
            values |= {} if child is None else _given(child, names)
    law = {p.name: p.default for p in MUSCLE_LAWS[kind].parameters}
    complete = {name: values.get(name, default) for name, default in law.items()}
    known = {name: value for name, value in complete.items() if value is not None}
    if kind == "hill_millard2012":
        known |= _implied_stiffnesses(known)
    for name, value in taken_by_opensim(kind, known).items():
        if value != law[name]:
            yield name, value


def _schuttes_times(node: Node) -> dict[str, float]:
    """Rates that are given over a scale of time, as time constants."""
    scale = node.number("time_scale", 0.1)
    rise, fall = node.number("activation1", 7.667), node.number("activation2", 1.459854)
    if not (scale > 0.0 and fall > 0.0 and rise + fall > 0.0):
        problem = "time_scale, activation2 and its sum with activation1 must be above 0"
        node.error("bad-law-parameter", problem)
        return {}
    return {
        "max_contraction_velocity": 1.0 / scale,
        "activation_time_constant": scale / (rise + fall),
        "deactivation_time_constant": scale / fall,
    }


def _note_other_curves(node: Node, most: float) -> None:
    """Curves that are not those of the law, with the force that this makes."""
    by_name = {child.attribute("name", ""): child for child in node.all("SimmSpline")}
    for name, ours in SCHUTTES_CURVES.items():
        if name not in by_name:
            problem = f"no {name}: OpenSim has another one then; the wrist model's is taken"
            node.warning("muscle-curves", problem)
            continue
        terms = [f for _, f in read_terms(by_name[name], ["strain"])]
        low, high = RANGES[name]
        fault = "".join(map(function_fault, terms))
        if fault:
            by_name[name].error("bad-function", f"its {name}: a {fault}")
            continue
        at = [low + k / 200 * (high - low) for k in range(201)]
        off = max(
            abs(sum(function.value(f, x) for f in terms) - function.value(ours, x)) for x in at
        )
        if off > SAME:
            problem = (
                f"its {name} is ignored: the curve of the wrist model is used, which "
                f"differs by up to {off * most:.3g} N"
            )
            by_name[name].warning("muscle-curves", problem)


def _implied_stiffnesses(values: Mapping[str, float]) -> dict[str, float]:
    """0 for the stiffnesses that follow from the strains: so they are ours, unless given."""
    implied = millards_stiffnesses({**values, "passive_stiffness": 0.0, "tendon_stiffness": 0.0})
    return {name: 0.0 for name, value in implied.items() if values[name] == value}


def _given(node: Node, names: Mapping[str, str]) -> dict[str, float]:
    """Return the parameters that an element gives, by our names."""
    return {ours: node.number(theirs) for ours, theirs in names.items() if node.all(theirs)}
