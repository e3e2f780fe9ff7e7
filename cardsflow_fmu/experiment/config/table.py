"""Tables of settings: pydantic models that are record, check, documentation and schema."""

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
    Strict,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, core_schema

from addin_sdfusion.robot import InputError, UnknownNameError

from .file import MAX_INTEGER, TOO_LONG
from .messages import SettingError, explained
from .names import Names, Symbol

T = TypeVar("T", bound="Table")


@dataclass(frozen=True)
class Context:
    """What a table is read with.

    Attributes:
        file: Where the table comes from; paths in it are relative to its folder.
        names: The names that settings by name are for, by their key in `each`; None where the
            robot is not known yet, and only the form of settings by name is checked.
        defaults: Defaults that other tables give, by the setting.
    """

    file: Path
    names: Mapping[str, Names] | None = None
    defaults: Mapping[str, Any] = field(default_factory=dict)

    def error(self, key: str, what: str) -> InputError:
        """An error about a full key of the file."""
        return InputError(what, file=self.file, key=key)

    def require(self, key: str, kind: str, name: str, known: Collection[str]) -> None:
        """Refuse a name under a full key that does not exist."""
        if name not in known:
            raise UnknownNameError(kind, name, known, file=self.file, key=key)

    @contextlib.contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Errors inside are about a full key of the file."""
        try:
            yield
        except InputError as error:
            error.file, error.key = self.file, key
            raise


class Table(BaseModel):
    """A table of settings; frozen.

    Unknown keys, values of other types and numbers that are not finite are refused. Lists of TOML
    become tuples.

    Raises:
        InputError: Something in it is wrong; the message names all of it, a line each.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True
    )

    def __init__(self, **settings: Any) -> None:
        try:
            super().__init__(**settings)
        except ValidationError as error:
            raise explained(error, type(self)) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # tables inside go by it

    @classmethod
    def read(cls, data: Any, context: Context, key: str = "") -> Self:
        """The table from plain data.

        Args:
            data: As TOML or JSON gives it.
            context: What it is read with.
            key: Its full key, for messages; empty for a whole file.

        Raises:
            InputError: Something in it is wrong; file and full key are named.
        """
        try:
            return cls.model_validate(data, context=context)
        except ValidationError as error:
            raise explained(error, cls, context.file, key) from None

    def replaced(self, **changes: Any) -> Self:
        """A copy with other values; not checked."""
        return self.model_copy(update=changes)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """The table as plain data, which reads back as the same.

        Args:
            leave_out: Keys to leave out, beside those without a value or with an infinite one.
        """
        fields = type(self).model_fields
        values = {own.alias or name: getattr(self, name) for name, own in fields.items()}
        return {
            key: plain(value)
            for key, value in values.items()
            if key not in leave_out and value is not None and value != math.inf
        }

    def arrays(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """The values of keys that are arrays in C, by their symbols; also those of tables inside.

        Args:
            leave_out: Keys to leave out, beside those without a value.
        """
        found: dict[str, Any] = {}
        for name, key in type(self).model_fields.items():
            value = getattr(self, name)
            if name in leave_out or value is None:
                continue
            found |= value.arrays() if isinstance(value, Table) else {}
            found |= {
                own.name: value for own in key.metadata if isinstance(own, Symbol) and own.name
            }
        return found

    def require_only(self, allowed: Iterable[str]) -> None:
        """Refuse keys that mean nothing beside the others that are given.

        Args:
            allowed: Keys that mean something.

        Raises:
            SettingError: There are others.
        """
        if errors := self.meaningless(allowed):
            raise SettingError(*errors)

    def meaningless(self, allowed: Iterable[str]) -> list[InputError]:
        """An error for each key that is given and is none of those allowed."""
        keys = {name: own.alias or name for name, own in type(self).model_fields.items()}
        fitting = list(allowed)
        known = [keys[name] for name in fitting]
        given = [name for name in keys if name in self.model_fields_set and name not in fitting]
        return [UnknownNameError("key", keys[name], known, key=keys[name]) for name in given]


def checked(kind: Any, value: Any, key: str, file: Path | None = None) -> Any:
    """A value of a kind, as tables hold it.

    Args:
        kind: Its type, as of a table's key.
        value: The value.
        key: Its full key, for messages.
        file: Where it is given.

    Raises:
        InputError: It is none.
    """
    try:
        return _adapter(kind).validate_python(value)
    except ValidationError as error:
        raise explained(error, Table, file, key) from None


@functools.cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind, config=ConfigDict(strict=True, allow_inf_nan=False))


@functools.cache
def numbers(count: int) -> Any:
    """The type of a list of so many numbers."""
    return Annotated[tuple[float, ...], Numbers(count)]


def plain(value: Any) -> Any:
    """A value of a table as JSON and TOML have it."""
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
    """A key of a table.

    Args:
        meaning: For people, with the unit.
        default: Of the key; none where it must be given. With None or an empty text it may
            be left out, and what that means is for the table's owner to say.
        alias: The key, where the attribute has another name.
        kind: Of a choice, what is chosen, for messages; the key where it is None.
        symbol: The array in C that it is, if any; see `Table.arrays`.
    """
    checked = default not in (None, "", math.inf)
    own = Field(default, description=meaning, alias=alias, title=kind, validate_default=checked)
    own.metadata.append(Symbol(symbol))
    return own


def _whole(value: Any) -> Any:
    """Numbers without a fraction count as whole ones."""
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
        raise SettingError(f"must be the path of a file, not {value!r}: no path holds a zero")
    return info.context.file.parent / value if info.context else Path(value)


def _fraction(value: float) -> float:
    if not 0 <= value <= 1:
        raise SettingError(f"must be from 0 to 1, not {value!r}")
    return value


class _File:
    """Of a path: relative to the file that it is given in."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(_path)

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        return {"type": "string", "minLength": 1}


class Numbers:
    """Of a tuple: so many numbers, or names, in a list."""

    def __init__(self, count: int, what: str = "numbers") -> None:
        self._count, self._what = count, what

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._listed, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        count, item = self._count, {"type": "number" if self._what == "numbers" else "string"}
        return {"type": "array", "items": item, "minItems": count, "maxItems": count}

    def _listed(self, value: Any) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple) or len(value) != self._count:
            raise SettingError(f"must be a list of {self._count} {self._what}, not {value!r}")
        return tuple(value)


class Short:
    """Of a table or a list: short forms.

    Args:
        written_out: Gives what a short form means; any other value as it is.
        schema: Of these values.
    """

    def __init__(self, written_out: Callable[[Any], Any], schema: Mapping[str, Any]) -> None:
        self._written_out, self._schema = written_out, schema

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._written_out, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> Any:
        inner = handler(schema["schema"])
        return {"anyOf": [self._schema, *inner.get("anyOf", [inner])]}


OR_FALSE = Short(lambda value: None if value is False else value, {"const": False})
"""Of what may be None: false for nothing."""

Positive = Annotated[float, Field(gt=0)]
FromZero = Annotated[float, Field(ge=0)]
Fraction = Annotated[
    float,
    AfterValidator(_fraction),
    WithJsonSchema({"type": "number", "minimum": 0, "maximum": 1}),
]
AS_WHOLE = BeforeValidator(_whole)
"""Of a whole number, behind its bounds: numbers without a fraction count as one."""
Whole = Annotated[int, AS_WHOLE]
Text = Annotated[str, Field(min_length=1)]
File = Annotated[Path, _File()]
Vector3 = Annotated[tuple[float, float, float], Numbers(3)]
Pair = Annotated[tuple[float, float], Numbers(2)]
Listed = Strict(False)
"""Of a tuple: a list in the file."""
