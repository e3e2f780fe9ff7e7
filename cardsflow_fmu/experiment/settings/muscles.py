"""[muscles]: force bounds and models of single muscles, instead of the robot's own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, cast

from pydantic import Field, create_model

from addin_sdfusion.robot import InputError, Muscle, Robot, UnknownNameError
from addin_sdfusion.robot.checks.check import require_valid
from addin_sdfusion.robot.model.muscle import CableKind, CableModel
from addin_sdfusion.robot.model.tension_laws import PRESETS, TENSION_LAWS
from addin_sdfusion.robot.model.tension_parameters import Parameter
from cardsflow_fmu.config.messages import SettingError, joined
from cardsflow_fmu.config.table import Context, FromZero, Short, Table, setting


def _parameters() -> dict[str, Any]:
    """The parameters of all laws; a bound counts where all laws that share a name have it."""
    found: dict[str, Parameter] = {}
    bounds: dict[str, set[float | None]] = {}
    for law in TENSION_LAWS.values():
        for own in law.parameters:
            found.setdefault(own.name, own)
            bounded = math.isfinite(own.low) and not own.open_low
            bounds.setdefault(own.name, set()).add(own.low if bounded else None)
    settings = {}
    for name, own in found.items():
        low, *others = bounds[name]
        extra: Any = {} if low is None or others else {"minimum": low}
        meaning = own.meaning + ("" if own.unit == "1" else f", in {own.unit}")
        settings[name] = (Annotated[float, Field(json_schema_extra=extra)], setting(meaning, None))
    return settings


def _written_out(model: Any) -> Any:
    """A law or a preset by its name alone."""
    if not isinstance(model, str) or not model:
        return model
    if model not in TENSION_LAWS and model not in PRESETS:
        raise SettingError(UnknownNameError("muscle model", model, [*TENSION_LAWS, *PRESETS]))
    return {"kind": model} if model in TENSION_LAWS else {"preset": model}


_Preset: Any = Literal[tuple(PRESETS)]
_Kind: Any = Literal[tuple(TENSION_LAWS)]
LawSettings: Any = create_model(
    "LawSettings",
    __base__=Table,
    __doc__="A law with parameters.",
    preset=(_Preset, setting("where the parameters come from", None)),
    kind=(
        _Kind,
        setting("the law; that of the preset or of the robot", None, kind="muscle model"),
    ),
    **_parameters(),
)


class MuscleSettings(Table):
    """A muscle, where it is to differ from the robot's."""

    f_min: FromZero = setting("smallest force, in N", None)
    f_max: float = setting("largest force, in N", None)
    model: Annotated[LawSettings, Short(_written_out, {"enum": [*TENSION_LAWS, *PRESETS]})] = (
        setting("how it pulls: a law or a preset by its name, or a table with parameters", None)
    )


def with_muscle_settings(
    robot: Robot, settings: Mapping[str, MuscleSettings], context: Context
) -> Robot:
    """The robot with the force bounds and models that the experiment changes."""
    muscles = {muscle.name: muscle for muscle in robot.muscles}
    for name, changes in settings.items():
        context.require(f"muscles.{name}", "muscle", name, muscles)
        try:
            muscles[name] = _changed(muscles[name], changes)
        except InputError as error:
            error.file, error.key = context.file, joined(f"muscles.{name}", error.key)
            raise
    changed = robot.with_muscles(list(muscles.values()))
    require_valid(changed)
    return changed


def muscle_data(muscle: Muscle) -> dict[str, Any]:
    """What [muscles.<name>] says of a muscle, which reads back as the same."""
    data: dict[str, Any] = {"f_min": muscle.f_min}
    if math.isfinite(muscle.f_max):
        data["f_max"] = muscle.f_max
    if muscle.model.kind in TENSION_LAWS:
        data["model"] = {"kind": muscle.model.kind, **dict(muscle.model.parameters)}
    return data


def _changed(muscle: Muscle, changes: MuscleSettings) -> Muscle:
    f_min = muscle.f_min if changes.f_min is None else changes.f_min
    f_max = muscle.f_max if changes.f_max is None else changes.f_max
    if f_min > f_max:
        raise InputError(f"f_min {f_min!r} N is above f_max {f_max!r} N")
    given = None if changes.model is None else changes.model.data()
    model = muscle.model if given is None else _model(given, muscle.model)
    return replace(muscle, f_min=f_min, f_max=f_max, model=model)


def _model(given: dict[str, Any], own: CableModel) -> CableModel:
    """A law with parameters.

    Parameters that are not given are the preset's, the robot's own if it has the same law, or the
    law's defaults.
    """
    preset = given.pop("preset", None)
    kind = given.pop("kind", PRESETS[preset].kind if preset else own.kind)
    base = PRESETS[preset] if preset else own if own.kind == kind else CableModel(kind)
    if kind not in TENSION_LAWS:
        raise UnknownNameError("muscle model", kind, TENSION_LAWS, key="model.kind")
    if kind != base.kind:
        raise InputError(f"{preset!r} is a {base.kind}, not a {kind}", key="model.preset")
    known = [parameter.name for parameter in TENSION_LAWS[kind].parameters]
    for name in given:
        if name not in known:
            raise UnknownNameError("key", name, ["preset", "kind", *known], key=f"model.{name}")
    parameters = dict(base.parameters) | given
    for parameter in TENSION_LAWS[kind].parameters:
        _check(parameter, parameters.get(parameter.name, parameter.default), kind)
    return CableModel(cast(CableKind, kind), tuple(parameters.items()))


def _check(parameter: Parameter, value: float | None, kind: str) -> None:
    """Refuse a parameter that is missing or out of bounds."""
    key = f"model.{parameter.name}"
    if value is None:
        unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
        what = f"missing: {kind} needs {parameter.name}{unit}: {parameter.meaning}"
        raise InputError(what, key=key)
    too_low = value < parameter.low or (parameter.open_low and value == parameter.low)
    if too_low or value > parameter.high:
        words = []
        if math.isfinite(parameter.low):
            words.append(f"{'above' if parameter.open_low else 'at least'} {parameter.low:g}")
        if math.isfinite(parameter.high):
            words.append(f"at most {parameter.high:g}")
        what = f"{parameter.name} must be {' and '.join(words)}, not {value!r}"
        raise InputError(what, key=key)
