"""Rare properties of points, wraps and muscles, as JSON texts."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar

from ...errors import InputError
from ...json_text import json_text
from ...model.function import Function, Polynomial
from ...model.muscle import (
    PRESLIDING,
    BasePulley,
    Muscle,
    PulleyKind,
    Quadrant,
    ViaPoint,
    Wrap,
    WrapRule,
)
from ...model.muscle_path import CoordinateTerm, PointCondition, PointMotion
from ...model.pose import Vector3
from ...records import from_plain, to_plain
from ..writing.functions import POINT_KINDS, POLYNOMIAL

Options = TypeVar("Options")


def options_text(options: Any) -> str:
    """Return options as JSON without default values; an empty text if all are default values."""
    plain = to_plain(options)
    return json_text(plain) if plain else ""


def read_options(kind: type[Options], text: str, where: str) -> Options:
    """Return the options in a JSON text.

    Args:
        text: The text; empty for default values.
        where: The object with the options, for messages.

    Raises:
        InputError: The text is not JSON, or a key or value is invalid.
    """
    key = f"{where}: options"
    try:
        plain = json.loads(text) if text else {}
    except (ValueError, RecursionError):
        raise InputError("must be a JSON object", key=key) from None
    return from_plain(kind, plain, key)


@dataclass(frozen=True)
class FunctionRecord:
    """Function of a coordinate: coefficients of a polynomial, or x and y of points."""

    kind: Literal["polynomial", "simm_spline", "piecewise_linear"]
    coefficients: tuple[float, ...] = ()
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()

    @staticmethod
    def of(function: Function) -> FunctionRecord:
        """Return the record of a function."""
        if isinstance(function, Polynomial):
            return FunctionRecord("polynomial", function.coefficients)
        kind = next(kind for kind, type_ in POINT_KINDS.items() if isinstance(function, type_))
        return FunctionRecord(kind, x=function.x, y=function.y)  # type: ignore[arg-type]

    def function(self) -> Function:
        """Return the function."""
        if self.kind == POLYNOMIAL:
            return Polynomial(self.coefficients)
        return POINT_KINDS[self.kind](self.x, self.y)


@dataclass(frozen=True)
class MoveRecord:
    """Motion of a via point; attributes of the robot model's `PointMotion`."""

    axis: Vector3
    coordinate: str
    function: FunctionRecord
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True)
class PointOptions:
    """Rare properties of a via point.

    Attributes:
        when: Condition under which the point is active.
        moves: Motions of the point on its link.
        friction: Coefficient of cable friction; None for the coefficient of the muscle.
        branch: Divisor of the branch that begins at this point; None if the path continues.
    """

    when: PointCondition | None = None
    moves: tuple[MoveRecord, ...] = ()
    friction: float | None = None
    branch: float | None = None

    @staticmethod
    def of(point: ViaPoint, branch: float | None) -> PointOptions:
        """Return the options of a point at which a branch of this divisor begins."""
        moves = tuple(
            MoveRecord(m.axis, m.coordinate, FunctionRecord.of(m.function), m.low, m.high)
            for m in point.moves
        )
        return PointOptions(point.when, moves, point.friction, branch)

    def via_point(self, link: str, position: Vector3) -> ViaPoint:
        """Return a via point with these options."""
        moves = tuple(
            PointMotion(m.axis, m.coordinate, m.function.function(), m.low, m.high)
            for m in self.moves
        )
        return ViaPoint(link, position, self.when, moves, self.friction)


@dataclass(frozen=True)
class SidePoint:
    """Point that defines the side of a wrap, with the rule `mujoco`."""

    link: str
    position: Vector3


@dataclass(frozen=True)
class WrapOptions:
    """Rare properties of a wrap; attributes of the robot model's `Wrap`.

    Attributes:
        rule: Rule of the wrap.
        side_point: Point that defines the side.
        quadrant: Half space in the surface's frame.
        segments: Number of possible segments; None if only one is possible.
        friction: Coefficient of cable friction; None for the coefficient of the muscle.
    """

    rule: WrapRule = "taut"
    side_point: SidePoint | None = None
    quadrant: Quadrant = "all"
    segments: int | None = None
    friction: float | None = None

    @staticmethod
    def of(wrap: Wrap) -> WrapOptions:
        """Return the options of a wrap."""
        point, last = wrap.side_point, wrap.last_segment
        side = None if point is None else SidePoint(point.link, point.position)
        segments = None if last is None else last - wrap.segment + 1
        return WrapOptions(wrap.rule, side, wrap.quadrant, segments, wrap.friction)

    def apply_to(self, wrap: Wrap) -> Wrap:
        """Return a wrap with these options."""
        point, segments = self.side_point, self.segments
        return replace(
            wrap,
            rule=self.rule,
            side_point=None if point is None else ViaPoint(point.link, point.position),
            quadrant=self.quadrant,
            last_segment=None if segments is None else wrap.segment + segments - 1,
            friction=self.friction,
        )


@dataclass(frozen=True)
class PulleyParameter:
    """Parameter of a pulley; a vector has three values."""

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class PulleyRecord:
    """Swivelling pulley at the first point; attributes of the robot model's `BasePulley`."""

    kind: PulleyKind
    parameters: tuple[PulleyParameter, ...] = ()

    @staticmethod
    def of(pulley: BasePulley) -> PulleyRecord:
        """Return the record of a pulley."""
        rows = (PulleyParameter(name, values) for name, values in pulley.parameters)
        return PulleyRecord(pulley.kind, tuple(rows))


@dataclass(frozen=True)
class MuscleOptions:
    """Rare properties of a muscle; attributes of the robot model's `Muscle`."""

    pulley: PulleyRecord | None = None
    terms: tuple[CoordinateTerm, ...] = ()
    friction: float = 0.0
    presliding: float = PRESLIDING

    @staticmethod
    def of(muscle: Muscle) -> MuscleOptions:
        """Return the options of a muscle."""
        pulley = None if muscle.pulley is None else PulleyRecord.of(muscle.pulley)
        return MuscleOptions(pulley, muscle.terms, muscle.friction, muscle.presliding)

    def base_pulley(self) -> BasePulley | None:
        """Return the pulley, or None."""
        if self.pulley is None:
            return None
        rows = tuple((row.name, row.values) for row in self.pulley.parameters)
        return BasePulley(self.pulley.kind, rows)
