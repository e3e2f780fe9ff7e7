"""Selection of the cases of a test that run by default."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import pytest

LONG = pytest.mark.skipif(
    "CARDSFLOW_LONG_TESTS" not in os.environ, reason="takes long: set CARDSFLOW_LONG_TESTS"
)
"""Mark of tests that run only if CARDSFLOW_LONG_TESTS is set."""


def sample_cases(cases: Iterable[Any], count: int = 1) -> list[Any]:
    """Return the cases; mark all except a few evenly spaced ones as slow.

    Args:
        cases: Parameters of each case.
        count: Number of cases that are not slow. The first case is one of them.
    """
    every = list(cases)
    chosen = {k * len(every) // count for k in range(count)}
    return [
        case if k in chosen else with_marks(case, pytest.mark.slow) for k, case in enumerate(every)
    ]


def with_marks(case: Any, *marks: pytest.MarkDecorator) -> Any:
    """Return a case, which is a value or a tuple of values, with marks."""
    values = case if isinstance(case, tuple) and not hasattr(case, "_fields") else (case,)
    return pytest.param(*values, marks=marks)
