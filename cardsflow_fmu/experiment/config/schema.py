"""JSON Schema of settings, for editors and documentation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from .table import Table

_NO_DEFAULT: tuple[Any, ...] = (None, "", [], {}, math.inf)


def json_schema(table: type[Table]) -> dict[str, Any]:
    """Return the JSON Schema of a table, without references."""
    schema = table.model_json_schema()
    return _plain(schema, schema.get("$defs", {}))


def _plain(schema: Mapping[str, Any], models: Mapping[str, Any]) -> dict[str, Any]:
    """Return a part of a schema without titles, references, and null."""
    if "$ref" in schema:
        inner = models[schema["$ref"].rpartition("/")[2]]
        schema = {**inner, **{key: own for key, own in schema.items() if key != "$ref"}}
    kept = {k: v for k, v in schema.items() if k not in ("$defs", "title", "additionalProperties")}
    if kept.get("default") in _NO_DEFAULT:
        kept.pop("default", None)
    if "properties" in kept:
        kept["properties"] = {k: _plain(v, models) for k, v in kept["properties"].items()}
    more = schema.get("additionalProperties")
    if more is not None:
        kept["additionalProperties"] = _plain(more, models) if isinstance(more, dict) else more
    if "items" in kept:
        kept["items"] = _plain(kept["items"], models)
    if "anyOf" in kept:
        forms = [_plain(own, models) for own in kept.pop("anyOf") if own != {"type": "null"}]
        kept = forms[0] | kept if len(forms) == 1 else {"anyOf": forms} | kept
    return kept
