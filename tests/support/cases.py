"""A choice among the cases of a test."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def few(cases: Iterable[Any], count: int = 1) -> list[Any]:
    """Some of the cases, evenly spread and the first among them; the others are marked as slow."""
    every = list(cases)
    chosen = {k * len(every) // count for k in range(count)}
    return [case if k in chosen else _slow(case) for k, case in enumerate(every)]


def _slow(case: Any) -> Any:
    values = case if isinstance(case, tuple) and not hasattr(case, "_fields") else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)
