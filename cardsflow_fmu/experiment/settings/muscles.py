"""Settings of [muscles]: force limits, laws and friction of single muscles."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    create_model,
)
from pydantic_core import CoreSchema, core_schema

from addin_sdfusion.robot import InputError, Muscle, Robot, RobotError, UnknownNameError
from addin_sdfusion.robot.checks.check import check
from addin_sdfusion.robot.checks.muscles import MAX_FRICTION, MAX_PRESLIDING
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from addin_sdfusion.robot.model.laws.law import Parameter
from addin_sdfusion.robot.model.muscle import CableModel, CustomMuscleLaw
from addin_sdfusion.robot.model.muscle_laws import PRESETS
from cardsflow_fmu.cosim.signals.units import SI_UNITS
from cardsflow_fmu.experiment.config.custom_law import (
    CUSTOM_LAW_FORM,
    CUSTOM_LAW_SCHEMA,
    CustomLaw,
)
from cardsflow_fmu.experiment.config.key_path import expand_names
from cardsflow_fmu.experiment.config.messages import SettingError, join_keys
from cardsflow_fmu.experiment.config.table import Context, FromZero, ShortForm, Table, setting

PATH, F_MAX = "path", "f_max"
HILL_FROM_PATH = "hill_from_path"
"""Preset of a Hill-type muscle with optimal fibre length at the pose."""

_HILL_FROM_PATH = {
    "kind": "hill_degroote2016",
    "max_isometric_force": F_MAX,
    "optimal_fibre_length": f"0.6 {PATH}",
    "tendon_slack_length": f"0.4 {PATH}",
}


class _NumberOrExpression:
    """Validator of a parameter that is a number or an expression.

    Args:
        form: Regular expression of the expression.
        words: Description of the expression, for messages.
    """

    def __init__(self, form: str, words: str) -> None:
        self._form, self._words = form, words

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(self._read, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        inner = handler(schema["schema"])
        return {"anyOf": [inner, {"type": "string", "pattern": f"^{self._form}$"}]}

    def _read(self, value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        if not isinstance(value, str):
            return handler(value)
        if not re.fullmatch(self._form, value):
            raise SettingError(f"must be a number or {self._words}, not {value!r}")
        return value


_EXPRESSIONS = {
    "m": _NumberOrExpression(
        rf"(\d+\.?\d* )?{PATH}", f'a multiple of the path length, such as "0.6 {PATH}"'
    ),
    "N": _NumberOrExpression(F_MAX, f'"{F_MAX}"'),
}
"""Validators by the unit of the parameter."""


def _parameters() -> dict[str, Any]:
    """Return the parameters of all laws; a parameter has a lower bound if all its laws share it."""
    parameters: dict[str, Parameter] = {}
    bounds: dict[str, set[float | None]] = {}
    for law in MUSCLE_LAWS.values():
        for parameter in law.parameters:
            parameters.setdefault(parameter.name, parameter)
            bounded = math.isfinite(parameter.low) and not parameter.open_low
            bounds.setdefault(parameter.name, set()).add(parameter.low if bounded else None)
    settings = {}
    for name, parameter in parameters.items():
        low, *others = bounds[name]
        extra: Any = {} if low is None or others else {"minimum": low}
        meaning = parameter.meaning + ("" if parameter.unit == "1" else f", in {parameter.unit}")
        kind: Any = Annotated[float, Field(json_schema_extra=extra)]
        if parameter.unit in _EXPRESSIONS:
            kind = Annotated[kind, _EXPRESSIONS[parameter.unit]]
        settings[name] = (kind, setting(meaning, None))
    return settings


_MODELS = [*MUSCLE_LAWS, *PRESETS, HILL_FROM_PATH]


def _as_table(model: Any) -> Any:
    """Return the table for the name of a law or of a preset."""
    if not isinstance(model, str) or not model:
        return model
    if model in PRESETS or model == HILL_FROM_PATH:
        return {"preset": model}
    return {"kind": _kind(model, _MODELS)}


def _kind(kind: str, kinds: Iterable[str] = MUSCLE_LAWS) -> str:
    if kind not in MUSCLE_LAWS and CustomLaw.of(kind) is None:
        raise SettingError(UnknownNameError("muscle model", kind, [*kinds, CUSTOM_LAW_FORM]))
    return kind


_Preset: Any = Literal[(*PRESETS, HILL_FROM_PATH)]
_Kind: Any = Annotated[
    str,
    AfterValidator(_kind),
    WithJsonSchema({"anyOf": [{"enum": list(MUSCLE_LAWS)}, CUSTOM_LAW_SCHEMA]}),
]
LawSettings: Any = create_model(
    "LawSettings",
    __base__=Table,
    __doc__="Muscle law with parameters.",
    preset=(_Preset, setting("preset that defines the parameters", None)),
    kind=(
        _Kind,
        setting(
            "muscle law; a custom law as `file.py:Class` (default: law of preset or robot)", None
        ),
    ),
    parameters=(
        dict[str, float],
        setting("arguments of a custom law, by name", None),
    ),
    **_parameters(),
)


_NAMES = {"anyOf": [{"enum": _MODELS}, CUSTOM_LAW_SCHEMA]}


class MuscleSettings(Table):
    """Changes of a muscle of the robot."""

    f_min: FromZero = setting("minimum force, in N", None)
    f_max: float = setting("maximum force, in N", None)
    model: Annotated[LawSettings, ShortForm(_as_table, _NAMES)] = setting(
        "muscle law: name of a law or preset, or a table with parameters", None
    )
    friction: Annotated[float, Field(ge=0, le=MAX_FRICTION)] = setting(
        "friction coefficient mu of the cable, for via points and wrap surfaces that specify none",
        None,
    )
    presliding: Annotated[float, Field(gt=0, le=MAX_PRESLIDING)] = setting(
        "presliding distance of the friction, in m", None
    )
    pose: dict[str, float] = setting(
        "pose for lengths relative to the path, by coordinate (default: initial positions)", None
    )


def with_muscle_settings(
    robot: Robot, settings: Mapping[str, MuscleSettings], context: Context
) -> Robot:
    """Return the robot with the force limits, laws and friction of the experiment."""
    muscles = {muscle.name: muscle for muscle in robot.muscles}
    try:
        tables = expand_names(settings, "muscle", muscles, "muscles")
    except InputError as error:
        error.file = context.file
        raise
    together: dict[str, MuscleSettings] = {}
    keys: dict[str, str] = {}
    for key, name, changes in tables:
        values = {field: getattr(changes, field) for field in changes.model_fields_set}
        together[name] = together.get(name, MuscleSettings()).copy_with(**values)
        keys[name] = key
    lengths = _PathLengths(robot)
    for name, changes in together.items():
        try:
            muscles[name] = _apply_settings(muscles[name], changes, lengths, context.file.parent)
        except InputError as error:
            error.file, error.key = error.file or context.file, join_keys(keys[name], error.key)
            raise
    changed = robot.with_muscles(list(muscles.values()))
    wrong = next((finding for finding in check(changed) if finding.is_error), None)
    if wrong is not None:
        failure = RobotError([wrong], file=context.file)
        failure.key = keys.get(wrong.subject.name, "muscles")
        raise failure
    return changed


class _PathLengths:
    """Lengths of the muscle paths; computed once per pose."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._names = [muscle.name for muscle in robot.muscles]
        self._lengths_at: dict[tuple[float, ...], list[float]] = {}

    def at(self, pose: Mapping[str, float], muscle: str) -> float:
        """Return the length of a muscle, in [m].

        Args:
            pose: Positions by coordinate; other coordinates have their initial positions.

        Raises:
            UnknownNameError: A coordinate of the pose does not exist.
        """
        names = [c.name for c in self._robot.coordinates]
        for name in pose:
            if name not in names:
                raise UnknownNameError("coordinate", name, names, key=f"pose.{name}")
        q = tuple(pose.get(c.name, c.initial) for c in self._robot.coordinates)
        if q not in self._lengths_at:
            from sim_dart import MusclePaths

            self._lengths_at[q] = MusclePaths(self._robot).evaluate(q).lengths.tolist()
        return self._lengths_at[q][self._names.index(muscle)]


def muscle_data(muscle: Muscle) -> dict[str, Any]:
    """Return the table [muscles.<name>] of a muscle; reading it returns an equal muscle."""
    data: dict[str, Any] = {"f_min": muscle.f_min}
    if muscle.friction or muscle.bend_friction:
        data |= {"friction": muscle.friction, "presliding": muscle.presliding}
    if math.isfinite(muscle.f_max):
        data["f_max"] = muscle.f_max
    if (custom := muscle.model.custom) is not None:
        law = str(CustomLaw(Path(custom.file), custom.name))
        data["model"] = {"kind": law, "parameters": dict(muscle.model.parameters)}
    elif muscle.model.kind in MUSCLE_LAWS:
        data["model"] = {"kind": muscle.model.kind, **dict(muscle.model.parameters)}
    return data


def _apply_settings(
    muscle: Muscle, changes: MuscleSettings, lengths: _PathLengths, folder: Path
) -> Muscle:
    f_min = muscle.f_min if changes.f_min is None else changes.f_min
    f_max = muscle.f_max if changes.f_max is None else changes.f_max
    if f_min > f_max:
        raise InputError(f"f_min must be at most f_max, not {f_min!r} N with f_max {f_max!r} N")
    model = muscle.model
    if changes.model is not None:
        values = changes.model.data()
        custom = CustomLaw.of(values.get("kind", ""))
        if custom is not None:
            model = _custom_model(custom._replace(file=folder / custom.file), values)
        else:
            if "parameters" in values:
                problem = (
                    f"is only for custom laws ({CUSTOM_LAW_FORM}); set parameters as keys of model"
                )
                raise InputError(problem, key="model.parameters")
            values = _resolve_expressions(values, replace(muscle, f_max=f_max), changes, lengths)
            model = _model(values, muscle.model)
    values = {"friction": changes.friction, "presliding": changes.presliding}
    friction = {key: value for key, value in values.items() if value is not None}
    return replace(muscle, f_min=f_min, f_max=f_max, model=model, **friction)


def _resolve_expressions(
    values: dict[str, Any], muscle: Muscle, changes: MuscleSettings, lengths: _PathLengths
) -> dict[str, Any]:
    """Return the parameters with numbers instead of expressions in path length and f_max."""
    if values.get("preset") == HILL_FROM_PATH:
        values = _HILL_FROM_PATH | {k: v for k, v in values.items() if k != "preset"}
    for name, value in values.items():
        if name in ("preset", "kind") or not isinstance(value, str):
            continue
        if value == F_MAX:
            if not math.isfinite(muscle.f_max):
                raise InputError("requires f_max; set it", key=f"model.{name}")
            values[name] = muscle.f_max
        else:
            factor, _, _ = value.rpartition(PATH)
            values[name] = float(factor or "1") * lengths.at(changes.pose or {}, muscle.name)
    return values


def _model(values: dict[str, Any], current: CableModel) -> CableModel:
    """Return a muscle law with parameters.

    Missing parameters come from the preset, from the robot if it has the same law, or from the
    defaults of the law.
    """
    preset = values.pop("preset", None)
    kind = values.pop("kind", PRESETS[preset].kind if preset else current.kind)
    base = PRESETS[preset] if preset else current if current.kind == kind else CableModel(kind)
    if kind not in MUSCLE_LAWS:
        raise UnknownNameError("muscle model", kind, MUSCLE_LAWS, key="model.kind")
    if kind != base.kind:
        raise InputError(f"{preset!r} has the law {base.kind!r}, not {kind!r}", key="model.preset")
    names = [parameter.name for parameter in MUSCLE_LAWS[kind].parameters]
    for name in values:
        if name not in names:
            raise UnknownNameError("key", name, ["preset", "kind", *names], key=f"model.{name}")
    parameters = dict(base.parameters) | values
    for parameter in MUSCLE_LAWS[kind].parameters:
        _check_parameter(parameter, parameters.get(parameter.name, parameter.default), kind)
    return CableModel(kind, tuple(parameters.items()))


def _custom_model(law: CustomLaw, values: Mapping[str, Any]) -> CableModel:
    """Return a custom law; its file is read but not executed."""
    for name in values:
        if name not in ("kind", "parameters"):
            problem = "is not for custom laws; set it in model.parameters"
            raise InputError(problem, key=f"model.{name}")
    parameters = tuple(values.get("parameters", {}).items())
    return CableModel("ideal", parameters, CustomMuscleLaw(str(law.file), law.name, _command(law)))


def _command(law: CustomLaw) -> tuple[str, str, float, float] | None:
    """Return the command of a custom law: name, unit and range; None for a passive law."""
    lines = [
        line
        for line in law.require().body
        if isinstance(line, ast.Assign | ast.AnnAssign)
        and any(isinstance(t, ast.Name) and t.id == "command" for t in _targets(line))
    ]
    if not lines or lines[-1].value is None:
        return None
    try:
        command = ast.literal_eval(lines[-1].value)
        if command is None:
            return None
        name, unit, low, high = command
        low, high = float(low), float(high)
    except (ValueError, TypeError):
        command = name = None
    if not (isinstance(name, str) and name.isidentifier() and math.isfinite(high - low)):
        problem = 'must be a literal (name, unit, min, max), such as ("rest_length", "m", 0.0, 2.0)'
        raise InputError(f"{law.name}.command {problem}", file=law.file, line=lines[-1].lineno)
    if unit not in SI_UNITS:
        error = UnknownNameError("unit", str(unit), SI_UNITS)
        raise InputError(f"{law.name}.command: {error}", file=law.file, line=lines[-1].lineno)
    if not low < high:
        problem = f"{law.name}.command: the minimum {low!r} must be below the maximum {high!r}"
        raise InputError(problem, file=law.file, line=lines[-1].lineno)
    return name, unit, low, high


def _targets(line: ast.Assign | ast.AnnAssign) -> list[ast.expr]:
    return line.targets if isinstance(line, ast.Assign) else [line.target]


def _check_parameter(parameter: Parameter, value: float | None, kind: str) -> None:
    """Check that a parameter exists and is within its bounds."""
    key = f"model.{parameter.name}"
    if value is None:
        unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
        problem = f"missing; {kind} requires {parameter.name}{unit}: {parameter.meaning}"
        raise InputError(problem, key=key)
    too_low = value < parameter.low or (parameter.open_low and value == parameter.low)
    if too_low or value > parameter.high:
        words = []
        if math.isfinite(parameter.low):
            words.append(f"{'above' if parameter.open_low else 'at least'} {parameter.low:g}")
        if math.isfinite(parameter.high):
            words.append(f"at most {parameter.high:g}")
        problem = f"{parameter.name} must be {' and '.join(words)}, not {value!r}"
        raise InputError(problem, key=key)
