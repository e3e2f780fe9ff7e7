"""Error messages of settings: one line per error, with file and full key."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from addin_sdfusion.robot import InputError, UnknownNameError

from .key_path import PathError

Place = tuple[str | int, ...]


class SettingError(ValueError):
    """Error of a check in a table.

    Args:
        errors: Errors with keys relative to the checked value, or texts.
        key: Key of a text.
    """

    def __init__(self, *errors: InputError | str, key: str | None = None) -> None:
        self.errors = [InputError(e, key=key) if isinstance(e, str) else e for e in errors]
        super().__init__("; ".join(error.problem for error in self.errors))


def settings_error(
    error: ValidationError, model: type[BaseModel], file: Path | None = None, key: str = ""
) -> InputError:
    """Convert a pydantic error to an error that lists all errors of a table, unknown keys first."""
    errors = [
        (each["type"] != "extra_forbidden", one)
        for each in _drop_consequential_errors(error.errors(include_url=False))
        for one in _convert_error(each, model)
    ]
    first, *others = [one for _, one in sorted(errors, key=lambda pair: pair[0])]
    for one in (first, *others):
        one.file = file
        one.key = join_keys(key, one.key)
    first.more = tuple(others)
    return first


def element_errors(error: ValidationError, keys: Sequence[str]) -> SettingError:
    """Convert a pydantic error of list elements; given keys replace the indices."""
    errors = []
    for each in error.errors(include_url=False):
        row, *place = each["loc"]
        for one in _convert_error({**each, "loc": place}, BaseModel):
            one.key = join_keys(keys[int(row)], one.key)
            errors.append(one)
    return SettingError(*errors)


def spelling_hint(key: str, present: Iterable[str]) -> str:
    """Return a suggestion for a missing key if a given key is similar."""
    near = difflib.get_close_matches(key, present, n=1, cutoff=0.5)
    return f"; did you misspell it as {near[0]!r}?" if near else ""


def join_keys(key: str, inner: str | None) -> str | None:
    """Join the full key of a table and a key in it."""
    if not key or not inner:
        return key or inner or None
    return f"{key}{inner}" if inner.startswith("[") else f"{key}.{inner}"


def key_of(place: Iterable[str | int]) -> str:
    """Return the full key of a location: names with dots, indices in brackets."""
    key = ""
    for part in place:
        key += f"[{part}]" if isinstance(part, int) else f".{part}" if key else part
    return key


def _drop_consequential_errors(errors: Sequence[Any]) -> list[Any]:
    """Remove errors that are consequences of other errors.

    An unknown key may be the misspelt name of a missing key. A list may be too short because it has
    invalid elements.
    """
    misspelt = {e["loc"][:-1] for e in errors if e["type"] == "extra_forbidden"}
    broken = {e["loc"][:k] for e in errors for k in range(len(e["loc"]))}
    return [
        e
        for e in errors
        if not (e["type"] == "missing" and e["loc"][:-1] in misspelt)
        and not (e["type"] == "too_short" and e["loc"] in broken)
    ]


def _convert_error(error: Mapping[str, Any], model: type[BaseModel]) -> list[InputError]:
    """Convert a pydantic error; keys are relative to the model."""
    place, value = error["loc"], error["input"]
    key, cause = key_of(place), error.get("ctx", {}).get("error")
    if isinstance(cause, SettingError):
        for one in cause.errors:
            one.key = join_keys(key, one.key)
        return cause.errors
    if error["type"] == "extra_forbidden":
        keys = keys_of(_table_at(model, place[:-1]))
        return [UnknownNameError("key", str(place[-1]), keys, key=key)]
    if error["type"] == "literal_error":
        return [_choice_error(value, _field_at(model, place), key)]
    if error["type"] == "float_type" and isinstance(value, dict):
        problem = "must be a number, not a table; put names with a dot in quotes"
        return [PathError(problem, key=key)]
    if error["type"] in ("tuple_type", "too_short"):
        rows = _element_kind(_field_at(model, place).annotation)
        minimum = {1: f"at least one {rows[:-1]}", 2: f"at least two {rows}"}
        content = minimum[error["ctx"]["min_length"]] if error["type"] == "too_short" else rows
        return [InputError(f"must be a list of {content}, not {value!r}", key=key)]
    return [InputError(_describe(error), key=key)]


def _choice_error(value: Any, field: FieldInfo, key: str) -> InputError:
    choices = _choices(field.annotation)
    is_named = isinstance(choices[0], str)
    if not is_named or not isinstance(value, str) or not value:
        words = " or ".join(map(repr, choices)) if is_named else "true"
        return InputError(f"must be {words}, not {value!r}", key=key)
    kind = field.title or key.rpartition(".")[2].replace("_", " ")
    return UnknownNameError(kind, value, choices, key=key)


def _describe(error: Mapping[str, Any]) -> str:
    value, ctx = error["input"], error.get("ctx", {})
    bound = ctx.get("gt", ctx.get("ge", ctx.get("le")))
    match error["type"]:
        case "missing":
            present = value if isinstance(value, dict) else ()
            return f"missing{spelling_hint(error['loc'][-1], present)}"
        case "float_type" if type(value) is int:
            return "must be a finite number, not inf"
        case "float_type" | "int_type" if not isinstance(value, float):
            return f"must be a number, not {value!r}"
        case "int_type" if math.isfinite(value):
            return f"must be a whole number, not {value!r}"
        case "finite_number" | "int_type":
            return f"must be a finite number, not {value!r}"
        case "greater_than":
            return f"must be above {bound:.16g}, not {value!r}"
        case "greater_than_equal" if bound == 0:
            return f"must not be negative: {value!r}"
        case "greater_than_equal":
            return f"must be at least {bound:.16g}, not {value!r}"
        case "less_than_equal":
            return f"must be at most {bound:.16g}, not {value!r}"
        case "bool_type":
            return f"must be true or false, not {value!r}"
        case "string_type" | "string_too_short" | "string_unicode":
            return f"must be a text, not {value!r}"
        case "model_type" | "dict_type" | "model_attributes_type":
            return f"must be a table, not {value!r}"
    return f"{error['msg']}, not {value!r}"


def keys_of(model: type[BaseModel]) -> list[str]:
    """Return the keys of a table, as in files."""
    return [field.alias or name for name, field in model.model_fields.items()]


def _table_at(annotation: Any, place: Sequence[str | int]) -> type[BaseModel]:
    """Return the model of the table at a location in a table, dictionary or list."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return (
            _table_at(_field_at(annotation, place[:1]).annotation, place[1:])
            if place
            else annotation
        )
    inner = [arg for arg in get_args(annotation) if arg not in (str, type(None), ...)]
    return _table_at(inner[0], place[1:] if get_origin(annotation) in (dict, tuple) else place)


def _field_at(model: type[BaseModel], place: Sequence[str | int]) -> FieldInfo:
    """Return the field at a location; for a list element, the field of the list."""
    while isinstance(place[-1], int):
        place = place[:-1]
    table = _table_at(model, place[:-1])
    return next(f for name, f in table.model_fields.items() if place[-1] in (f.alias, name))


def _element_kind(annotation: Any) -> str:
    """Return the kind of the elements of a list, for messages."""
    row = (*get_args(annotation), Any)[0]
    while get_origin(row) is Annotated:
        row = get_args(row)[0]
    if isinstance(row, type) and issubclass(row, BaseModel):
        return "tables"
    words = {str: "names", float: "numbers", int: "whole numbers", tuple: "lists"}
    return words.get(get_origin(row) or row, "values")


def _choices(annotation: Any) -> list[Any]:
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    return [name for each in get_args(annotation) for name in _choices(each)]
