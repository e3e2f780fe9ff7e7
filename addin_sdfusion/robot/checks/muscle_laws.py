"""Checks of the parameters of muscle laws: known, complete and consistent."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from ..caspr_vocabulary import CASPR_CABLES
from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, finite, unknown
from ..model.laws import MUSCLE_LAWS
from ..model.laws.law import Parameter
from ..model.muscle import CableModel
from ..model.robot import Robot

_CASPR_PARAMETERS = {
    cable.kind: [item.tag for item in cable.properties] for cable in CASPR_CABLES.values()
}
"""Additional parameters in CASPR's files, such as the diameter, by kind of cable."""


def muscle_laws(robot: Robot) -> Iterator[Finding]:
    """Check the muscle laws of all muscles in every cable set."""
    for subject, muscle in all_muscles(robot):
        yield from law_findings(subject, muscle.model)


def law_findings(subject: Subject, model: CableModel) -> Iterator[Finding]:
    """Check the parameters of a muscle law.

    Args:
        subject: The muscle.
        model: The law and its parameters, which may be invalid.
    """
    law = MUSCLE_LAWS.get(model.kind)
    if law is None:
        return
    parameters = law.parameters
    yield from _names(subject, model, parameters)
    specified = dict(model.parameters)
    for parameter in parameters:
        if parameter.name not in specified and parameter.default is None:
            problem = f"a {model.kind} needs {_described(parameter)}"
            yield error(subject, "missing-law-parameter", problem)
    values = {p.name: specified.get(p.name, p.default) for p in parameters}
    complete = {name: value for name, value in values.items() if value is not None}
    bad = list(_out_of_bounds(parameters, complete))
    if not bad and len(complete) == len(values) and finite(complete.values()):
        broken = law.broken_rule(complete)
        bad = [] if broken is None else [broken]
    for problem in bad:
        yield error(subject, "bad-law-parameter", f"{model.kind}: {problem}")


def _names(
    subject: Subject, model: CableModel, parameters: tuple[Parameter, ...]
) -> Iterator[Finding]:
    names = [parameter.name for parameter in parameters]
    allowed = {*names, *_CASPR_PARAMETERS.get(model.kind, ())}
    counts = Counter(name for name, _ in model.parameters)
    for name, count in counts.items():
        if model.kind != "ideal" and name not in allowed:
            problem = f"{model.kind}: {unknown('parameter', name, names)}"
            yield error(subject, "unknown-law-parameter", problem)
        if count > 1:
            problem = f"{model.kind}: parameter {name!r} is given {count} times; keep one"
            yield error(subject, "repeated-law-parameter", problem)


def _described(parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
    return f"{parameter.name}{unit} ({parameter.meaning})"


def _out_of_bounds(parameters: Iterable[Parameter], values: Mapping[str, float]) -> Iterator[str]:
    """Yield an error text for each finite value out of bounds; see `numbers` for the others."""
    for parameter in parameters:
        value = values.get(parameter.name, math.nan)
        if math.isfinite(value) and not parameter.allows(value):
            yield f"{parameter.name} {value!r} must be {parameter.bounds}"
