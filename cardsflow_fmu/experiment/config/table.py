"""Tables of settings: pydantic models with checks, documentation and schema."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    Strict,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, core_schema

from addin_sdfusion.robot import InputError, UnknownNameError

from .file import MAX_INTEGER, TOO_LONG
from .messages import SettingError, settings_error
from .names import Names, Symbol, is_named

T = TypeVar("T", bound="Table")


@dataclass(frozen=True)
class Context:
    """Context of reading a table.

    Attributes:
        file: File of the table; paths are relative to its folder.
        names: Names by kind, for settings by name. None before the robot is read; then the names
            are not checked.
        defaults: Defaults from other tables, by setting.
    """

    file: Path
    names: Mapping[str, Names] | None = None
    defaults: Mapping[str, Any] = field(default_factory=dict)

    def error(self, key: str, problem: str) -> InputError:
        """Return an error with file and full key."""
        return InputError(problem, file=self.file, key=key)

    def require(self, key: str, kind: str, name: str, names: Collection[str]) -> None:
        """Check that a name exists."""
        if name not in names:
            raise UnknownNameError(kind, name, names, file=self.file, key=key)

    @contextlib.contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Add file and full key to errors that are raised in the context."""
        try:
            yield
        except InputError as error:
            error.file, error.key = self.file, key
            raise


class Table(BaseModel):
    """Table of settings; frozen.

    Unknown keys, values of other types and numbers that are not finite are errors. TOML lists
    become tuples.

    Raises:
        InputError: The table is invalid; the message lists all errors, one per line.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True
    )

    def __init__(self, **settings: Any) -> None:
        try:
            super().__init__(**settings)
        except ValidationError as error:
            raise settings_error(error, type(self)) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # also for tables inside

    @classmethod
    def read(cls, data: Any, context: Context, key: str = "") -> Self:
        """Create the table from plain data.

        Args:
            data: Content of a TOML or JSON file.
            context: File and names.
            key: Full key of the table, for messages; empty for a whole file.

        Raises:
            InputError: The table is invalid; the message names file and full key.
        """
        try:
            return cls.model_validate(data, context=context)
        except ValidationError as error:
            raise settings_error(error, cls, context.file, key) from None

    def copy_with(self, **changes: Any) -> Self:
        """Return a copy with other values, without validation."""
        return self.model_copy(update=changes)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data; reading the data returns an equal table.

        Args:
            leave_out: Keys to omit, in addition to keys without a value or a finite value.
        """
        fields = type(self).model_fields
        values = {info.alias or name: getattr(self, name) for name, info in fields.items()}
        named = {info.alias or name for name, info in fields.items() if is_named(info)}
        return {
            key: plain(value)
            for key, value in values.items()
            if key not in leave_out
            and value is not None
            and value != math.inf
            and not (value == () and key in named)
        }

    def arrays(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the values of keys with C arrays, by symbol, including tables inside.

        Args:
            leave_out: Keys to omit, in addition to keys without a value.
        """
        arrays: dict[str, Any] = {}
        for name, key in type(self).model_fields.items():
            value = getattr(self, name)
            if name in leave_out or value is None:
                continue
            arrays |= value.arrays() if isinstance(value, Table) else {}
            arrays |= {
                meta.name: value for meta in key.metadata if isinstance(meta, Symbol) and meta.name
            }
        return arrays

    def require_only(self, allowed: Iterable[str]) -> None:
        """Check that only keys that apply are set.

        Raises:
            SettingError: Another key is set.
        """
        if errors := self.inapplicable_keys(allowed):
            raise SettingError(*errors)

    def inapplicable_keys(self, allowed: Iterable[str]) -> list[InputError]:
        """Return an error for each key that is set but does not apply."""
        keys = {name: info.alias or name for name, info in type(self).model_fields.items()}
        fitting = list(allowed)
        allowed_keys = [keys[name] for name in fitting]
        extra = [name for name in keys if name in self.model_fields_set and name not in fitting]
        return [UnknownNameError("key", keys[name], allowed_keys, key=keys[name]) for name in extra]


def validated(kind: Any, value: Any, key: str, file: Path | None = None) -> Any:
    """Validate a value as a key of a table.

    Raises:
        InputError: The value is invalid.
    """
    try:
        return _adapter(kind).validate_python(value)
    except ValidationError as error:
        raise settings_error(error, Table, file, key) from None


@functools.cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))


@functools.cache
def numbers(count: int) -> Any:
    """Return the type of a list with a fixed count of numbers."""
    return Annotated[tuple[float, ...], list_of(count)]


def plain(value: Any) -> Any:
    """Convert a value of a table to plain data."""
    if isinstance(value, Table):
        return value.data()
    if isinstance(value, tuple):
        return [plain(each) for each in value]
    return str(value) if isinstance(value, Path) else value


def setting(
    meaning: str,
    default: Any = ...,
    *,
    alias: str | None = None,
    kind: str | None = None,
    symbol: str | None = None,
) -> Any:
    """Define a key of a table.

    Args:
        meaning: Description with unit.
        default: Default; omitted for a required key. None and empty text are replaced by the reader
            of the table.
        alias: Key in files (default: name of the attribute).
        kind: Name of a choice, for messages (default: the key).
        symbol: Name of the C array, see `Table.arrays` (default: none).
    """
    validated = default not in (None, "", math.inf)
    info = Field(default, description=meaning, alias=alias, title=kind, validate_default=validated)
    info.metadata.append(Symbol(symbol))
    return info


def _whole(value: Any) -> Any:
    """Convert floating-point numbers without a fraction to integers."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        raise SettingError(TOO_LONG)
    return value


def _path(value: Any, info: ValidationInfo) -> Path:
    if isinstance(value, Path):
        return value
    if not isinstance(value, str) or not value:
        raise SettingError(f"must be a text, not {value!r}")
    if "\0" in value:
        raise SettingError(f"must be the path of a file without null characters, not {value!r}")
    return info.context.file.parent / value if info.context else Path(value)


def _fraction(value: float) -> float:
    if not 0 <= value <= 1:
        raise SettingError(f"must be from 0 to 1, not {value!r}")
    return value


def list_of(count: int, kind: str = "numbers") -> BeforeValidator:
    """Return the annotation of a list with a fixed count of numbers or names."""

    def to_tuple(value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or len(value) != count:
            raise SettingError(f"must be a list of {count} {kind}, not {value!r}")
        return tuple(value)

    item = {"type": "number" if kind == "numbers" else "string"}
    schema = {"type": "array", "items": item, "minItems": count, "maxItems": count}
    return BeforeValidator(to_tuple, json_schema_input_type=Annotated[Any, WithJsonSchema(schema)])


class ShortForm:
    """Annotation of a table or list that has a short form.

    Args:
        expand: Converts the short form; returns other values unchanged.
        schema: JSON Schema of the short form.
    """

    def __init__(self, expand: Callable[[Any], Any], schema: Mapping[str, Any]) -> None:
        self._expand, self._schema = expand, schema

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._expand, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        inner = handler(schema["schema"])
        return {"anyOf": [self._schema, *inner.get("anyOf", [inner])]}


OR_FALSE = ShortForm(lambda value: None if value is False else value, {"const": False})
"""Annotation of an optional value: false for None."""

Positive = Annotated[float, Field(gt=0)]
FromZero = Annotated[float, Field(ge=0)]
Fraction = Annotated[
    float,
    AfterValidator(_fraction),
    WithJsonSchema({"type": "number", "minimum": 0, "maximum": 1}),
]
AS_WHOLE = BeforeValidator(_whole)
"""Annotation of an integer: numbers without a fraction are accepted. It must follow the bounds."""
Whole = Annotated[int, AS_WHOLE]
Text = Annotated[str, Field(min_length=1)]
File = Annotated[Path, PlainValidator(_path, json_schema_input_type=Text)]
"""Path that is relative to the folder of the settings file."""
Vector3 = Annotated[tuple[float, float, float], list_of(3)]
Pair = Annotated[tuple[float, float], list_of(2)]
Listed = Strict(False)
"""Annotation of a tuple that is a list in files."""
