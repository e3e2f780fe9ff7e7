"""A choice among the cases of a test."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import pytest

LONG = pytest.mark.skipif(
    "CARDSFLOW_LONG_TESTS" not in os.environ, reason="takes long: set CARDSFLOW_LONG_TESTS"
)
"""Tests that run only where the environment asks for them."""


def few(cases: Iterable[Any], count: int = 1) -> list[Any]:
    """Some of the cases, evenly spread and the first among them; the others are marked as slow.

    Args:
        cases: The parameters of each.
        count: How many of them are not slow.
    """
    every = list(cases)
    chosen = {k * len(every) // count for k in range(count)}
    return [case if k in chosen else marked(case, pytest.mark.slow) for k, case in enumerate(every)]


def marked(case: Any, *marks: pytest.MarkDecorator) -> Any:
    """A case with marks, of one value or of a tuple of them."""
    values = case if isinstance(case, tuple) and not hasattr(case, "_fields") else (case,)
    return pytest.param(*values, marks=marks)
