"""Reader of OpenSim muscles, ligaments and cables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ....checks.driven import function_fault
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
    opensim_parameters,
)
from .document import is_true
from .functions import read_terms
from .paths import PathContext, geometry_path, read_points, read_wraps

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
"""OpenSim's defaults of parameters that are required here."""


CURVE_TOLERANCE = 1e-9
"""Curves that differ by less than this, relative to F0, are equal."""
MAX_FORCE_TAG = "max_isometric_force"
"""Property of all OpenSim muscles, which other forces along paths do not have."""


def is_muscle(node: Node) -> bool:
    """Return whether a force acts along a path."""
    return node.tag in KINDS or bool(node.all("GeometryPath", "path"))


def read_muscle(node: Node, context: PathContext) -> Muscle | None:
    """Return a muscle; None if it is disabled or not supported."""
    node = node.named("muscle")
    if not is_true(node, "appliesForce", True) or is_true(node, "isDisabled", False):
        node.warning("muscle-left-out", "it is disabled in the file; ignored")
        return None
    if node.tag not in KINDS and not node.all(MAX_FORCE_TAG):
        node.warning("muscle-left-out", f"<{node.tag}> is not supported; ignored", KINDS)
        return None
    path = geometry_path(node)
    if path is None:
        return None
    points = read_points(path, context)
    wraps = tuple(read_wraps(path, context, len(points)))
    muscle = Muscle(node.subject.name, tuple(points), wraps=wraps)
    if node.tag == "PathActuator":
        return _actuator(node, muscle)
    if node.tag not in KINDS:
        return _cable(node, muscle)
    return replace(muscle, model=CableModel(KINDS[node.tag], tuple(_parameters(node))))


def _cable(node: Node, muscle: Muscle) -> Muscle:
    """Return a cable with the path and the maximum force of an unsupported muscle."""
    f_max = node.number(MAX_FORCE_TAG)
    problem = (
        f"the muscle law of <{node.tag}> is not supported; the muscle is read as an ideal cable, "
        f"with any force up to its max_isometric_force of {f_max:g} N, without delay"
    )
    node.warning("muscle-as-cable", problem)
    return replace(muscle, f_max=max(f_max, 0.0))


def _actuator(node: Node, muscle: Muscle) -> Muscle:
    """Return a cable whose tension is its control times its optimal force."""
    scale = node.number("optimal_force", 1.0)
    low = scale * node.number("min_control", float("-inf"), infinite=True)
    high = scale * node.number("max_control", float("inf"), infinite=True)
    if low < 0.0:
        node.warning("cable-pulls-only", f"its tension may be {low:g} N; here it can only pull")
    return replace(muscle, f_min=max(low, 0.0), f_max=max(high, 0.0))


_NO_PASSIVE_FORCE = 1e9
"""Strain of the passive fibre for a passive force below 1e-9 of F0 at all lengths."""


def _parameters(node: Node) -> Iterator[tuple[str, float]]:
    """Yield the parameters of a muscle law that differ from their defaults, in order."""
    kind = KINDS[node.tag]
    values = dict(DEFAULTS.get(kind, DEFAULTS["hill"]))
    values |= _read_properties(node, PROPERTIES[kind])
    if "activation_time_constant" in PROPERTIES[kind]:
        rigid = kind != "hill_thelen2003" and is_true(node, "ignore_tendon_compliance", False)
        values["elastic_tendon"] = 0.0 if rigid else 1.0
        if is_true(node, "ignore_activation_dynamics", False):
            problem = "its activation equals its excitation in the file; here it has dynamics"
            node.warning("activation-dynamics", problem)
    if kind == "hill_degroote2016" and is_true(node, "ignore_passive_fiber_force", False):
        values["passive_fibre_strain"] = _NO_PASSIVE_FORCE
    if kind == "hill_schutte1993":
        values |= {"elastic_tendon": 1.0, **_schuttes_times(node)}
        _note_other_curves(node, values["max_isometric_force"])
    if kind == "hill_millard2012":
        for curve, names in MILLARDS_CURVES.items():
            child = node.optional(curve)
            values |= {} if child is None else _read_properties(child, names)
    law = {p.name: p.default for p in MUSCLE_LAWS[kind].parameters}
    complete = {name: values.get(name, default) for name, default in law.items()}
    parameters = {name: value for name, value in complete.items() if value is not None}
    if kind == "hill_millard2012":
        parameters |= _implied_stiffnesses(parameters)
    for name, value in opensim_parameters(kind, parameters).items():
        if value != law[name]:
            yield name, value


def _schuttes_times(node: Node) -> dict[str, float]:
    """Return the parameters of Schutte's law, with time constants instead of rates."""
    scale = node.number("time_scale", 0.1)
    rise, fall = node.number("activation1", 7.667), node.number("activation2", 1.459854)
    if not (scale > 0.0 and fall > 0.0 and rise + fall > 0.0):
        problem = "time_scale, activation2 and activation1 + activation2 must be positive"
        node.error("bad-law-parameter", problem)
        return {}
    return {
        "max_contraction_velocity": 1.0 / scale,
        "activation_time_constant": scale / (rise + fall),
        "deactivation_time_constant": scale / fall,
    }


def _note_other_curves(node: Node, f_max: float) -> None:
    """Report curves that differ from the muscle law, with the difference in force."""
    by_name = {child.attribute("name", ""): child for child in node.all("SimmSpline")}
    for name, curve in SCHUTTES_CURVES.items():
        if name not in by_name:
            problem = f"no {name}: OpenSim uses another curve; the curve of the wrist model is used"
            node.warning("muscle-curves", problem)
            continue
        terms = [f for _, f in read_terms(by_name[name], ["strain"])]
        low, high = RANGES[name]
        fault = "".join(map(function_fault, terms))
        if fault:
            by_name[name].error("bad-function", f"its {name}: {fault}")
        at = [low + k / 200 * (high - low) for k in range(201)]
        off = max(
            abs(sum(function.value(f, x) for f in terms) - function.value(curve, x)) for x in at
        )
        if off > CURVE_TOLERANCE:
            problem = (
                f"its {name} is ignored: the curve of the wrist model is used, which "
                f"differs by up to {off * f_max:.3g} N"
            )
            by_name[name].warning("muscle-curves", problem)


def _implied_stiffnesses(values: Mapping[str, float]) -> dict[str, float]:
    """Return 0 for stiffnesses equal to the default, which follows from the strains."""
    omitted_together = millards_stiffnesses(
        {**values, "passive_stiffness": 0.0, "tendon_stiffness": 0.0}
    )
    return {name: 0.0 for name, value in omitted_together.items() if values[name] == value}


def _read_properties(node: Node, names: Mapping[str, str]) -> dict[str, float]:
    """Return the parameters of an element, by their names in our muscle law."""
    return {name: node.number(tag) for name, tag in names.items() if node.is_given(tag)}
