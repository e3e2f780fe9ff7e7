"""Integrator settings of a plant: rule, step and substeps, and their bounds."""

from __future__ import annotations

from numbers import Real
from typing import Literal, get_args

import numpy as np

from addin_sdfusion.robot import InputError

Rule = Literal["euler", "rk4"]

MOST_SUBSTEPS = 1_000_000
"""The bound of native plants too."""


def check_step(step: float, integrator: str, substeps: int) -> None:
    """Refuse settings out of range.

    Raises:
        InputError: One is wrong.
    """
    if not _is_number(step) or not (np.isfinite(step) and step > 0):
        raise InputError(f"the plant's step must be a positive time in s, not {step!r}")
    if integrator not in get_args(Rule):
        raise InputError(f"integrator {integrator!r} is none of {', '.join(get_args(Rule))}")
    is_whole = _is_number(substeps) and 1 <= substeps <= MOST_SUBSTEPS
    if not is_whole or substeps != int(substeps):
        raise InputError(
            f"substeps must be a whole number from 1 to {MOST_SUBSTEPS}, not {substeps!r}"
        )


def _is_number(value: object) -> bool:
    """Whether it is one that a float can be."""
    try:
        return isinstance(value, Real) and abs(float(value)) >= 0.0
    except OverflowError:
        return False
