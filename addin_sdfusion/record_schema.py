"""JSON Schema of records as `records` writes them; the descriptions come from docstrings."""

from __future__ import annotations

import re
import types
import typing
from array import array
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any

from .robot.records import Form

_NUMBER: dict[str, Any] = {"anyOf": [{"type": "number"}, {"enum": ["inf", "-inf"]}]}
_PLAIN: dict[Any, dict[str, Any]] = {
    str: {"type": "string"},
    Path: {"type": "string"},
    bool: {"type": "boolean"},
    int: {"type": "integer"},
    float: _NUMBER,
}
_ITEM = re.compile(r"^    (?P<names>\w+(?:, \w+)*): (?P<text>.*)$")


def record_schema(cls: type) -> dict[str, Any]:
    """Return the schema of a record, including the schemas of nested records."""
    if hasattr(cls, "_fields"):  # a NamedTuple
        return _tuple(tuple(typing.get_type_hints(cls, include_extras=True).values()))
    hints, texts = typing.get_type_hints(cls, include_extras=True), _texts(cls)
    properties = {
        f.name: {**_schema(hints[f.name]), **_description(texts.get(f.name)), **_default(f.default)}
        for f in fields(cls)
    }
    required = [f.name for f in fields(cls) if f.default is f.default_factory is MISSING]
    return {
        **_description((cls.__doc__ or "").partition("\n")[0]),
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _default(value: Any) -> dict[str, Any]:
    is_plain = isinstance(value, str | bool | int | float) and value != ""
    return {"default": value} if is_plain else {}


def _description(text: str | None) -> dict[str, str]:
    return {"description": text} if text else {}


def _texts(cls: type) -> dict[str, str]:
    """Return the description of every attribute from the docstring of a class."""
    _, _, section = (cls.__doc__ or "").partition("Attributes:\n")
    texts: dict[str, str] = {}
    names: list[str] = []
    for line in re.sub(r"^    ", "", section, flags=re.MULTILINE).splitlines():
        item = _ITEM.match(line)
        if item:
            names = item["names"].split(", ")
            texts.update(dict.fromkeys(names, item["text"]))
        elif line.strip():
            texts.update({name: f"{texts[name]} {line.strip()}" for name in names})
    return texts


def _schema(hint: Any) -> dict[str, Any]:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        kind = arguments[1]
        if isinstance(kind, Form):
            return {"type": "string", "pattern": f"^{kind.pattern}$"}
        return _packed(kind)
    if origin is types.UnionType or origin is typing.Union:
        return {
            "anyOf": [_schema(a) if a is not type(None) else {"type": "null"} for a in arguments]
        }
    if origin is typing.Literal:
        return {"enum": list(arguments)}
    if origin is tuple:
        return _tuple(arguments)
    if origin is not None and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _schema(arguments[1])}
    if is_dataclass(hint) or hasattr(hint, "_fields"):
        return record_schema(hint)
    return dict(_PLAIN[hint])


def _tuple(kinds: tuple[Any, ...]) -> dict[str, Any]:
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        return {"type": "array", "items": _schema(kinds[0])}
    size = {"minItems": len(kinds), "maxItems": len(kinds)}
    return {"type": "array", "prefixItems": [_schema(kind) for kind in kinds], **size}


def _packed(typecode: str) -> dict[str, Any]:
    size = array(typecode).itemsize
    return {
        "description": f"Little-endian numbers of {size} bytes, compressed by zlib, in base64.",
        "type": "object",
        "properties": {"type": {"const": typecode}, "zlib": {"type": "string"}},
        "required": ["type", "zlib"],
        "additionalProperties": False,
    }
