"""Conversion of frozen dataclasses to and from JSON data; every value is checked."""

from __future__ import annotations

import base64
import binascii
import math
import re
import sys
import types
import typing
import zlib
from array import array
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from . import limits
from .errors import InputError

if TYPE_CHECKING:
    Samples = array[Any]
else:  # Python 3.11 has no array[...]
    Samples = array
"""Sequence of numbers; a field has the type `Annotated[Samples, "d"]` (floats) or "i" (indices)."""


@dataclass(frozen=True)
class Form:
    """Format of a text, used as `Annotated[str, Form("#rrggbb", "#[0-9a-f]{6}")]`.

    Attributes:
        text: Name of the format in messages.
        pattern: Regular expression that the whole text must match.
    """

    text: str
    pattern: str


Record = TypeVar("Record")

_INFINITIES = {"inf": math.inf, "-inf": -math.inf}
_PART = limits.MIB


def to_plain(value: Any) -> Any:
    """Return a record as plain data without the fields that have their default value.

    Args:
        value: A dataclass, or the value of one of its fields.
    """
    if isinstance(value, array):
        return _pack(value)
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return [to_plain(item) for item in value]
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, Mapping):
        return {key: to_plain(item) for key, item in value.items()}
    if is_dataclass(value):
        pairs = ((f, getattr(value, f.name)) for f in fields(value))
        return {f.name: to_plain(item) for f, item in pairs if item != _default(f)}
    return value


def from_plain(cls: type[Record], plain: Any, where: str) -> Record:
    """Return a record from plain data.

    Args:
        plain: Data returned by `to_plain`, or read from an untrusted file.
        where: Key of the data, used in messages.

    Raises:
        InputError: A key is unknown or missing, or a value has the wrong type.
    """
    return _record(cls, plain, where, _Budget(limits.SNAPSHOT_UNPACKED))


@dataclass
class _Budget:
    """Number of bytes that the packed numbers of a record may still expand to."""

    remaining: int


def _record(cls: type[Record], plain: Any, where: str, budget: _Budget) -> Record:
    if not isinstance(plain, dict):
        raise InputError(f"must hold an object, not {type(plain).__name__}", key=where)
    hints = _hints(typing.cast(type, cls))
    for key in plain:
        if key not in hints:
            raise InputError(f"unknown key {key!r} (known: {', '.join(hints)})", key=where)
    missing = [f.name for f in fields(cls) if _default(f) is MISSING and f.name not in plain]  # type: ignore[arg-type]
    if missing:
        raise InputError(f"key {missing[0]!r} is missing", key=where)
    items = plain.items()
    return cls(**{key: _value(hints[key], item, f"{where}.{key}", budget) for key, item in items})


def _default(f: Any) -> Any:
    if f.default is not MISSING:
        return f.default
    return f.default_factory() if f.default_factory is not MISSING else MISSING


@cache
def _hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls, include_extras=True)


def _value(hint: Any, plain: Any, where: str, budget: _Budget) -> Any:
    """Return the value of a field with this type hint."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated and isinstance(arguments[1], Form):
        return _check_format(arguments[1], plain, where)
    if origin is typing.Annotated:
        return _unpack(arguments[1], plain, where, budget)
    if origin is types.UnionType or origin is typing.Union:
        if plain is None and type(None) in arguments:
            return None
        (hint,) = (a for a in arguments if a is not type(None))
        return _value(hint, plain, where, budget)
    if origin is typing.Literal:
        if plain not in arguments or isinstance(plain, (list, dict)):
            choices = ", ".join(map(str, arguments))
            raise InputError(f"must be one of {choices}, not {plain!r}", key=where)
        return plain
    if origin is tuple:
        return _tuple(arguments, plain, where, budget)
    if isinstance(hint, type) and hasattr(hint, "_fields"):  # a NamedTuple
        return hint(*_tuple(tuple(_hints(hint).values()), plain, where, budget))
    if is_dataclass(hint):
        return _record(typing.cast(type, hint), plain, where, budget)
    if origin is not None and issubclass(origin, Mapping):
        return _mapping(arguments[1], plain, where)
    return _scalar(hint, plain, where)


def _tuple(kinds: tuple[Any, ...], plain: Any, where: str, budget: _Budget) -> tuple[Any, ...]:
    if not isinstance(plain, list):
        raise InputError(f"must hold a list, not {type(plain).__name__}", key=where)
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(plain)
    if len(kinds) != len(plain):
        raise InputError(f"must hold {len(kinds)} values, not {len(plain)}", key=where)
    return tuple(
        _value(kind, item, f"{where}[{i}]", budget)
        for i, (kind, item) in enumerate(zip(kinds, plain, strict=True))
    )


def _mapping(hint: Any, plain: Any, where: str) -> dict[str, Any]:
    if not isinstance(plain, dict):
        raise InputError(f"must hold an object, not {type(plain).__name__}", key=where)
    return {key: _scalar(hint, item, f"{where}.{key}") for key, item in plain.items()}


def _check_format(form: Form, plain: Any, where: str) -> str:
    if not isinstance(plain, str) or not re.fullmatch(form.pattern, plain, re.ASCII):
        raise InputError(f"must be {form.text}, not {plain!r}", key=where)
    return plain


def _scalar(hint: Any, plain: Any, where: str) -> Any:
    if hint is float:
        if isinstance(plain, str) and plain in _INFINITIES:
            return _INFINITIES[plain]
        if isinstance(plain, (int, float)) and not isinstance(plain, bool):
            number = float(plain) if abs(plain) < sys.float_info.max else math.inf
            if math.isfinite(number):
                return number
        raise InputError(f"must be a number, not {plain!r}", key=where)
    if hint is Path and isinstance(plain, str):
        return Path(plain)
    if type(plain) is not hint:
        raise InputError(f"must be of type {hint.__name__}, not {plain!r}", key=where)
    return plain


def _pack(samples: array[Any]) -> dict[str, str]:
    """Return numbers as compressed little-endian bytes in base64.

    A mesh written as decimal digits would be five times as long.
    """
    if sys.byteorder == "big":
        samples = array(samples.typecode, samples)
        samples.byteswap()
    data = base64.b64encode(zlib.compress(samples.tobytes(), 6)).decode("ascii")
    return {"type": samples.typecode, "zlib": data}


def _inflate(packed: bytes, samples: array[Any], budget: _Budget) -> None:
    """Decompress packed numbers in parts and append them to the samples."""
    stream = zlib.decompressobj()
    while not stream.eof:
        data = stream.decompress(packed, _PART)
        packed = stream.unconsumed_tail
        budget.remaining -= len(data)
        if budget.remaining < 0 or not (data or packed or stream.eof):
            raise ValueError("truncated, or too many numbers")
        samples.frombytes(data)


def _unpack(typecode: str, plain: Any, where: str, budget: _Budget) -> array[Any]:
    if not isinstance(plain, dict) or plain.keys() != {"type", "zlib"}:
        raise InputError("must hold packed numbers", key=where)
    if plain["type"] != typecode or not isinstance(plain["zlib"], str):
        content = "floats (d)" if typecode == "d" else "indices (i)"
        raise InputError(f"must hold packed {content}", key=where)
    samples = array(typecode)
    try:
        _inflate(base64.b64decode(plain["zlib"], validate=True), samples, budget)
    except (ValueError, binascii.Error, zlib.error) as error:
        raise InputError(f"packed numbers cannot be read: {error}", key=where) from None
    if sys.byteorder == "big":
        samples.byteswap()
    return samples
