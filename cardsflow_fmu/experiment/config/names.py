"""Settings by name: one value for all muscles, coordinates or links, a list, or a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from addin_sdfusion.robot import InputError, UnknownNameError

from .key_path import EVERY_OTHER
from .messages import SettingError, element_errors

_NOT_SET: tuple[float, ...] = ()


@dataclass(frozen=True)
class Names:
    """Names of parts of a robot that have settings.

    Attributes:
        kind: Kind of the parts, for messages.
        names: Names in order.
        groups: Names of groups, with their members.
        missing: What to do if a robot has none of these parts, but settings of them.
    """

    kind: str
    names: Sequence[str]
    groups: Mapping[str, Sequence[str]] = field(default_factory=dict)
    missing: str = ""


@dataclass(frozen=True)
class Symbol:
    """Name of the C array of a setting, in the metadata of its field."""

    name: str | None


def named_setting(
    names: str,
    meaning: str,
    default: Any = ...,
    *,
    others: Any = None,
    word: str | None = None,
    alias: str | None = None,
    symbol: str | None = None,
) -> Any:
    """Define a key like `setting`, with one value per name, as a tuple in the order of the names.

    Args:
        names: Kind of names, a key of `Context.names`.
        default: Default of every value; omitted for a required key; None for an empty tuple.
        others: Value of names that a table omits (default: `default`). Vectors are only allowed in
            tables.
        word: Text that is allowed instead of values; read as None.
    """
    info: Any = Field(
        ... if default is ... else _NOT_SET,
        description=meaning,
        alias=alias,
        json_schema_extra={"default": None if default is ... else default},
    )
    validator = _NamedValues(names, default, default if others is None else others, word)
    info.metadata += [validator, Symbol(symbol)]
    return info


def is_named(field: FieldInfo) -> bool:
    """Return whether a field has one value per name; it is empty if no value is set."""
    return any(isinstance(each, _NamedValues) for each in field.metadata)


class _NamedValues:
    """Validator of `named_setting`."""

    def __init__(self, names: str, default: Any, others: Any, word: str | None) -> None:
        self._names, self._default, self._others, self._word = names, default, others, word

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_wrap_validator_function(self._read, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        inner = handler(schema["schema"])
        rows = next(form for form in inner.get("anyOf", [inner]) if form.get("type") == "array")
        item = rows["items"]
        forms = [item, rows, {"type": "object", "additionalProperties": item}]
        if isinstance(self._others, tuple):
            return forms[-1]
        return {"anyOf": [*forms, *([{"const": self._word}] if self._word else [])]}

    def _read(self, value: Any, handler: ValidatorFunctionWrapHandler, info: Any) -> Any:
        if self._word is not None and value in (self._word, None):
            return None
        names: Names | None = info.context.names[self._names] if _has_names(info) else None
        if isinstance(value, list) and None in value:  # JSON has no NaN, see Table.data
            labels = (
                names.names
                if names and len(names.names) == len(value)
                else map(str, range(len(value)))
            )
            elements = zip(labels, value, strict=True)
            value = {name: element for name, element in elements if element is not None}
        if value == {} and self._default is not ...:
            value = _NOT_SET
        if value == _NOT_SET and isinstance(value, tuple):
            return self._default_values(names, info)
        if names is not None and names.missing:
            raise SettingError(f"the robot has no {names.kind}s; {names.missing}")
        if isinstance(value, dict):
            numbers = dict(zip(value, _validate(handler, value.values(), value), strict=True))
            return tuple(numbers.values()) if names is None else self._expand(numbers, names, info)
        if isinstance(self._others, tuple):
            raise SettingError(f"must be a table, not {value!r}")
        if not isinstance(value, list | tuple):
            (number,) = _validate(handler, [value], [""])
            return (number,) * (1 if names is None else len(names.names))
        if names is not None and len(value) != len(names.names):
            raise SettingError(f"must have {len(names.names)} values, one per {names.kind}")
        return _validate(handler, value, [f"[{k}]" for k in range(len(value))])

    def _default_values(self, names: Names | None, info: Any) -> tuple[Any, ...]:
        if names is None:
            return ()
        default = info.context.defaults.get(info.field_name, self._default)
        if isinstance(default, tuple):
            return default
        return () if default is None else (default,) * len(names.names)

    def _expand(self, numbers: Mapping[str, Any], names: Names, info: Any) -> tuple[Any, ...]:
        """Return a value for every name from a table with names, groups, and `*`."""
        together = {**{name: [name] for name in names.names}, EVERY_OTHER: names.names}
        together = {**names.groups, **together}
        errors: list[InputError] = [
            UnknownNameError(names.kind, name, [*names.groups, *names.names], key=name)
            for name in numbers
            if name not in together
        ]
        spread = dict.fromkeys(names.names, numbers[EVERY_OTHER]) if EVERY_OTHER in numbers else {}
        for name, number in numbers.items():
            if name != EVERY_OTHER:
                spread |= {one: numbers.get(one, number) for one in together.get(name, ())}
        usual = info.context.defaults.get(info.field_name, self._others)
        if isinstance(usual, tuple) and info.field_name in info.context.defaults:
            spread = dict(zip(names.names, usual, strict=True)) | spread
        elif not errors and (usual is None or usual is ...):
            missing = [name for name in names.names if name not in spread]
            errors += [InputError("missing", key=name) for name in missing]
        if errors:
            raise SettingError(*errors)
        return tuple(spread.get(name, usual) for name in names.names)


def _has_names(info: Any) -> bool:
    return info.context is not None and info.context.names is not None


def _validate(
    handler: ValidatorFunctionWrapHandler, values: Iterable[Any], keys: Iterable[str]
) -> tuple[Any, ...]:
    """Validate values; errors have the keys of the values."""
    try:
        checked: tuple[Any, ...] = handler(tuple(values))
    except ValidationError as error:
        raise element_errors(error, list(keys)) from None
    return checked
