"""Variations, which map a number from 0 to 1 to a value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from scipy.special import ndtri

from cardsflow_fmu.simulation.nominal_values import Nominal

Relative = Literal["factor", "offset"]

_EDGE = 2.0**-53  # the quantiles of a normal distribution at 0 and 1 are infinite


class Range(Protocol):
    """Range of the values of a variation."""

    def at(self, u: float) -> Any:
        """Return the value at u, from 0 to 1."""


@dataclass(frozen=True, slots=True)
class Listed:
    """A list of values."""

    values: tuple[Any, ...]

    def at(self, u: float) -> Any:
        """Return the value at u; each value has an equal share of [0, 1)."""
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True, slots=True)
class Uniform:
    """A uniform distribution."""

    lower: float
    upper: float

    def at(self, u: float) -> float:
        """Return the quantile."""
        return self.lower + u * (self.upper - self.lower)


@dataclass(frozen=True, slots=True)
class LogUniform:
    """A log-uniform distribution."""

    lower: float
    upper: float

    def at(self, u: float) -> float:
        """Return the quantile."""
        return math.exp(Uniform(math.log(self.lower), math.log(self.upper)).at(u))


@dataclass(frozen=True, slots=True)
class Normal:
    """A normal distribution."""

    mean: float
    deviation: float

    def at(self, u: float) -> float:
        """Return the quantile."""
        return self.mean + self.deviation * float(ndtri(min(max(u, _EDGE), 1.0 - _EDGE)))


@dataclass(frozen=True, slots=True)
class Seed:
    """A different integer for every run, from the seed of the study."""

    def at(self, u: float) -> int:
        """Return an arbitrary seed, for checks; `make_run` sets the seed of each run."""
        return int(u * 2**32)


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
        return isinstance(self.range, Listed)

    @property
    def is_seed(self) -> bool:
        """Whether the variation is a seed, which differs in every run."""
        return isinstance(self.range, Seed)

    @property
    def listed(self) -> Sequence[Any]:
        """The list of values."""
        assert isinstance(self.range, Listed)
        return self.range.values
