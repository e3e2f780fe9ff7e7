"""Reading [muscles]: force bounds and models of single muscles, instead of the robot's own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.checks.check import require_valid
from addin_sdfusion.robot.model.muscle import CableKind, CableModel
from addin_sdfusion.robot.model.tension_laws import PRESETS, TENSION_LAWS, TensionLaw
from addin_sdfusion.robot.model.tension_parameters import Parameter
from cardsflow_fmu.config.table import Table


def with_muscle_settings(robot: Robot, table: Table) -> Robot:
    """The robot with the force bounds and models that the experiment changes.

    Args:
        robot: The robot as its files have it.
        table: The table [muscles].

    Raises:
        InputError: Something in it is wrong; the message names file and key.
    """
    muscles = list(robot.muscles)
    for index, changes in table.tables([muscle.name for muscle in muscles], "muscle"):
        muscles[index] = _changed(muscles[index], changes)
    changed = robot.with_muscles(muscles)
    require_valid(changed)
    return changed


def model_data(model: CableModel) -> dict[str, Any]:
    """What [muscles.<name>] says of a model, which reads back as the same.

    Args:
        model: The model of a muscle; what CASPR alone knows stays in the robot's files.
    """
    if model.kind not in TENSION_LAWS:
        return {}
    return {"model": {"kind": model.kind, **dict(model.parameters)}}


def _changed(muscle: Muscle, table: Table) -> Muscle:
    f_min = table.number("f_min", muscle.f_min)
    f_max = table.number("f_max") if "f_max" in table else muscle.f_max
    table.value("f_max", None)
    model = _model(table, muscle.model) if "model" in table else muscle.model
    table.value("model", None)
    table.close()
    if f_min < 0:
        raise table.error("f_min", f"must not be negative: {f_min!r}")
    if f_min > f_max:
        raise InputError(
            f"f_min {f_min!r} N is above f_max {f_max!r} N", file=table.file, key=table.path
        )
    return replace(muscle, f_min=f_min, f_max=f_max, model=model)


def _model(table: Table, own: CableModel) -> CableModel:
    """A law or a preset by its name, or a table with parameters.

    Parameters that are not given are the preset's, the robot's own if it has the same law, or the
    law's defaults.
    """
    known = [*TENSION_LAWS, *PRESETS]
    if not isinstance(table.value("model"), dict):
        name = table.choice("model", "muscle model", known)
        base = PRESETS.get(name) or _base(name, own)
        _check(table, "model", TENSION_LAWS[base.kind], dict(base.parameters))
        return base
    given = table.table("model")
    preset = given.choice("preset", "preset", list(PRESETS)) if "preset" in given else ""
    given.value("preset", None)
    usual = PRESETS[preset].kind if preset else own.kind
    kind = given.choice("kind", "muscle model", list(TENSION_LAWS), usual)
    base = PRESETS[preset] if preset else _base(kind, own)
    if kind != base.kind:
        raise given.error("preset", f"{preset!r} is a {base.kind}, not a {kind}")
    parameters, law = dict(base.parameters), TENSION_LAWS[kind]
    for parameter in law.parameters:
        if parameter.name in given:
            parameters[parameter.name] = given.number(parameter.name)
        given.value(parameter.name, None)
    given.close()
    _check(given, "", law, parameters)
    return CableModel(base.kind, tuple(parameters.items()))


def _base(kind: str, own: CableModel) -> CableModel:
    """The robot's own model if it is of that kind, else one with nothing given."""
    return own if own.kind == kind else CableModel(cast(CableKind, kind))


def _check(table: Table, key: str, law: TensionLaw, given: dict[str, float]) -> None:
    """Refuse parameters that are missing or out of bounds."""
    for parameter in law.parameters:
        value = given.get(parameter.name, parameter.default)
        at = key or parameter.name
        if value is None:
            unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
            what = f"{law.kind} needs {parameter.name}{unit}: {parameter.meaning}"
            raise table.error(at, f"missing: {what}")
        if not _fits(parameter, value):
            what = f"{parameter.name} must be {_bounds(parameter)}, not {value!r}"
            raise table.error(at, what)


def _fits(parameter: Parameter, value: float) -> bool:
    if parameter.open_low and value == parameter.low:
        return False
    return parameter.low <= value <= parameter.high


def _bounds(parameter: Parameter) -> str:
    words = []
    if math.isfinite(parameter.low):
        words.append(f"{'above' if parameter.open_low else 'at least'} {parameter.low:g}")
    if math.isfinite(parameter.high):
        words.append(f"at most {parameter.high:g}")
    return " and ".join(words)
