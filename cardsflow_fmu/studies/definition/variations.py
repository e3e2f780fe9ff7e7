"""Variations, which map a number from 0 to 1 to a value."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

from scipy.special import ndtri

from cardsflow_fmu.simulation.nominal_values import Nominal

Relative = Literal["factor", "offset"]
Kind = Literal["values", "uniform", "loguniform", "normal", "seed"]

_EDGE = 2.0**-53  # the quantiles of a normal distribution at 0 and 1 are infinite


@dataclass(frozen=True, slots=True)
class Range:
    """Range of the values of a variation.

    Attributes:
        kind: A list of values, a distribution, or a different integer for every run, from the seed
            of the study.
        values: The list, or the two parameters of the distribution.
    """

    kind: Kind
    values: tuple[Any, ...] = ()

    def at(self, u: float) -> Any:
        """Return the value at u, from 0 to 1: a quantile; values have equal shares of [0, 1).

        For a seed, it is arbitrary, for checks; `make_run` sets the seed of each run.
        """
        if self.kind == "values":
            return self.values[min(int(u * len(self.values)), len(self.values) - 1)]
        if self.kind == "seed":
            return int(u * 2**32)
        a, b = self.values
        if self.kind == "normal":
            return a + b * float(ndtri(min(max(u, _EDGE), 1.0 - _EDGE)))
        if self.kind == "loguniform":
            return math.exp(math.log(a) + u * (math.log(b) - math.log(a)))
        return a + u * (b - a)


@dataclass(frozen=True, slots=True)
class Variation:
    """A variation of one or several settings.

    Attributes:
        name: Name of its column in the table.
        paths: Full keys of the settings.
        relative: Whether values are factors of the nominal values or offsets from them; None for
            absolute values.
        nominal: Nominal value at every path; empty for absolute values.
    """

    name: str
    paths: tuple[str, ...]
    range: Range
    relative: Relative | None = None
    nominal: tuple[Nominal, ...] = ()

    def settings(self, value: Any) -> dict[str, Any]:
        """Return the settings for a value, by full key.

        Args:
            value: A value from the range, or the seed of a run.
        """
        if self.relative is None:
            return dict.fromkeys(self.paths, value)
        pairs = zip(self.paths, self.nominal, strict=True)
        return {path: self._apply(nominal, value) for path, nominal in pairs}

    def _apply(self, nominal: Nominal, value: float) -> Any:
        if isinstance(nominal, tuple):
            return [self._apply(number, value) for number in nominal]
        return nominal * value if self.relative == "factor" else nominal + value

    @property
    def is_listed(self) -> bool:
        """Whether the values are a list."""
        return self.range.kind == "values"

    @property
    def is_seed(self) -> bool:
        """Whether the variation is a seed, which differs in every run."""
        return self.range.kind == "seed"

    @property
    def has_range(self) -> bool:
        """Whether it has more than one value and is not a seed."""
        return not self.is_seed and not (self.is_listed and len(self.range.values) == 1)
