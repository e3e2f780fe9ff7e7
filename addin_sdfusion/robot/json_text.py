"""Standard JSON, which does not support NaN and infinity."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any


def json_text(value: Any, **style: Any) -> str:
    """Return a value as JSON, with null for numbers that are not finite.

    Args:
        value: Plain data.
        style: Arguments of `json.dumps`, such as `indent`.
    """
    try:
        return json.dumps(value, allow_nan=False, **style)
    except ValueError:
        return json.dumps(finite(value), allow_nan=False, **style)


def finite(value: Any) -> Any:
    """Return plain data with None instead of numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
