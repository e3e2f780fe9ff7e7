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
        schema = {**inner, **{key: value for key, value in schema.items() if key != "$ref"}}
    form = {k: v for k, v in schema.items() if k not in ("$defs", "title", "additionalProperties")}
    if form.get("default") in _NO_DEFAULT:
        form.pop("default", None)
    if "properties" in form:
        form["properties"] = {k: _plain(v, models) for k, v in form["properties"].items()}
    more = schema.get("additionalProperties")
    if more is not None:
        form["additionalProperties"] = _plain(more, models) if isinstance(more, dict) else more
    if "items" in form:
        form["items"] = _plain(form["items"], models)
    if "anyOf" in form:
        forms = [_plain(one, models) for one in form.pop("anyOf") if one != {"type": "null"}]
        form = forms[0] | form if len(forms) == 1 else {"anyOf": forms} | form
    return form
