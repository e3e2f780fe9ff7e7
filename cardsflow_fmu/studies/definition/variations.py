"""Variations: each maps a number from 0 to 1 to a value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from scipy.special import ndtri

from .nominal_values import Nominal

Relative = Literal["factor", "offset"]

_EDGE = 2.0**-53  # a normal distribution has no value at 0 and 1


class Range(Protocol):
    """The values of a variation."""

    def at(self, u: float) -> Any:
        """Return the value at the part u, from 0 to 1, of the range."""


@dataclass(frozen=True, slots=True)
class Listed:
    """Values one by one."""

    values: tuple[Any, ...]

    def at(self, u: float) -> Any:
        """Return the value whose equal share of [0, 1) holds u."""
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True, slots=True)
class Uniform:
    """Every number between two is as likely as another."""

    lower: float
    upper: float

    def at(self, u: float) -> float:
        """Return the quantile."""
        return self.lower + u * (self.upper - self.lower)


@dataclass(frozen=True, slots=True)
class LogUniform:
    """Every number of digits between two is as likely as another."""

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
    """A whole number of its own for every run, from the seed of the study."""

    def at(self, u: float) -> int:
        """Any; runs get theirs from their index in the study."""
        return int(u * 2**32)


@dataclass(frozen=True, slots=True)
class Variation:
    """Something that is varied.

    Attributes:
        name: Its column in the table.
        paths: Full keys of the settings that take the value.
        range: Its values.
        relative: Whether values are factors on what the experiment has, or added to it; None if
            they stand for themselves.
        nominal: What the experiment has at every path, where values are relative.
    """

    name: str
    paths: tuple[str, ...]
    range: Range
    relative: Relative | None = None
    nominal: tuple[Nominal, ...] = ()

    def settings(self, value: Any) -> dict[str, Any]:
        """Return the settings, by full key, that a value makes.

        Args:
            value: From the range, or the seed of a run.
        """
        if self.relative is None:
            return dict.fromkeys(self.paths, value)
        pairs = zip(self.paths, self.nominal, strict=True)
        return {path: self._applied(nominal, value) for path, nominal in pairs}

    def _applied(self, nominal: Nominal, value: float) -> Any:
        if isinstance(nominal, tuple):
            return [self._applied(number, value) for number in nominal]
        return nominal * value if self.relative == "factor" else nominal + value

    @property
    def is_listed(self) -> bool:
        """Whether its values stand one by one."""
        return isinstance(self.range, Listed)

    @property
    def is_seed(self) -> bool:
        """Whether every run has its own."""
        return isinstance(self.range, Seed)

    @property
    def listed(self) -> Sequence[Any]:
        """The values one by one."""
        assert isinstance(self.range, Listed)
        return self.range.values
