"""Muscles and wrap surfaces of a robot as plain data, for editors and for muscles.csv.

    {"muscles": [{"name", "law", "parameters": {name: number}, "f_min", "f_max",
                  "points": [{"link", "position", "options"}],
                  "wraps": [{"surface", "segment", "side", "turns", "inside", "options"}],
                  "options"}],
     "wraps": [{"name", "link", "shape", "radius", "position", "rpy", "length", "half_axes"}]}

Positions are in link frames. `options` are JSON texts with rare properties, see `options.py`; an
editor copies them without changes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ...model.muscle import (
    CableKind,
    CableModel,
    CableSet,
    Muscle,
    Side,
    ViaPoint,
    Wrap,
    WrapShape,
    WrapSurface,
)
from ...model.muscle_path import Branch
from ...model.pose import Pose, Vector3
from ...model.robot import DEFAULT_SET, Robot
from ...records import from_plain
from .options import MuscleOptions, PointOptions, WrapOptions, options_text, read_options


@dataclass(frozen=True)
class PointRecord:
    """Via point of a muscle.

    Attributes:
        link: Link of the point, or `world`.
        position: In that link's frame, in [m].
        options: JSON text of `PointOptions`; empty for none.
    """

    link: str
    position: Vector3
    options: str = ""


@dataclass(frozen=True)
class WrapRecord:
    """Wrap of a muscle over a surface; `options` is the JSON text of `WrapOptions`.

    The other attributes are those of the robot model's `Wrap`.
    """

    surface: str
    segment: int
    side: Side = 0
    turns: int = 0
    inside: bool = False
    options: str = ""


@dataclass(frozen=True)
class MuscleRecord:
    """Muscle of a robot.

    Attributes:
        name: Name of the muscle.
        law: Muscle law.
        parameters: Parameters of the muscle law by name, in SI units.
        f_min: Minimum force that a controller can command, in [N].
        f_max: Maximum force, in [N]; None if unlimited.
        points: Via points, in order.
        wraps: Wraps over surfaces, in order.
        options: JSON text of `MuscleOptions`; empty for none.
    """

    name: str
    law: CableKind = "ideal"
    parameters: Mapping[str, float] = field(default_factory=dict)
    f_min: float = 0.0
    f_max: float | None = None
    points: tuple[PointRecord, ...] = ()
    wraps: tuple[WrapRecord, ...] = ()
    options: str = ""


@dataclass(frozen=True)
class SurfaceRecord:
    """Wrap surface: attributes of the robot model's `WrapSurface`; `length` None is infinite."""

    name: str
    link: str
    shape: WrapShape
    radius: float
    position: Vector3 = (0.0, 0.0, 0.0)
    rpy: Vector3 = (0.0, 0.0, 0.0)
    length: float | None = None
    half_axes: tuple[float, float] | None = None


@dataclass(frozen=True)
class MuscleDocument:
    """Muscles and wrap surfaces of a robot."""

    muscles: tuple[MuscleRecord, ...] = ()
    wraps: tuple[SurfaceRecord, ...] = ()

    @staticmethod
    def of(robot: Robot) -> MuscleDocument:
        """Return the active muscles of a robot, without custom laws, and its wrap surfaces."""
        muscles = tuple(_muscle_record(muscle) for muscle in robot.muscles)
        return MuscleDocument(muscles, tuple(_surface_record(s) for s in robot.wrap_surfaces))

    @staticmethod
    def from_plain(plain: Any) -> MuscleDocument:
        """Return the document in plain data, such as parsed JSON.

        Raises:
            InputError: A key is unknown or missing, or a value has the wrong type.
        """
        return from_plain(MuscleDocument, plain, "document")

    def to_plain(self) -> dict[str, Any]:
        """Return the document as plain data with all keys."""
        plain: dict[str, Any] = _plain(asdict(self))
        return plain

    def apply_to(self, robot: Robot) -> Robot:
        """Return the robot with the muscles of its active cable set replaced.

        Wrap surfaces are also replaced, except those that only other cable sets use.

        Raises:
            InputError: A text of `options` is invalid.
        """
        name = robot.cable_set or DEFAULT_SET
        cable_set = CableSet(name, tuple(_muscle(record) for record in self.muscles))
        names = [group.name for group in robot.cable_sets]
        sets = tuple(cable_set if s.name == name else s for s in robot.cable_sets)
        surfaces = (*(_surface(s) for s in self.wraps), *self._other_surfaces(robot, name))
        return replace(
            robot,
            cable_sets=sets if name in names else (*sets, cable_set),
            cable_set=name,
            wrap_surfaces=surfaces,
        )

    def _other_surfaces(self, robot: Robot, cable_set: str) -> Iterator[WrapSurface]:
        used = {
            wrap.surface
            for group in robot.cable_sets
            if group.name != cable_set
            for muscle in group.muscles
            for wrap in muscle.wraps
        }
        names = {surface.name for surface in self.wraps}
        for surface in robot.wrap_surfaces:
            if surface.name in used - names:
                yield surface


def _plain(value: Any) -> Any:
    """Return plain data with lists instead of tuples, as from JSON."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def _muscle_record(muscle: Muscle) -> MuscleRecord:
    divisors = {branch.point: branch.divisor for branch in muscle.branches}
    return MuscleRecord(
        muscle.name,
        muscle.model.kind,
        dict(muscle.model.parameters),
        muscle.f_min,
        None if muscle.f_max == math.inf else muscle.f_max,
        tuple(
            PointRecord(p.link, p.position, options_text(PointOptions.of(p, divisors.get(k))))
            for k, p in enumerate(muscle.via_points)
        ),
        tuple(
            WrapRecord(
                w.surface, w.segment, w.side, w.turns, w.inside, options_text(WrapOptions.of(w))
            )
            for w in muscle.wraps
        ),
        options_text(MuscleOptions.of(muscle)),
    )


def _surface_record(surface: WrapSurface) -> SurfaceRecord:
    length = None if surface.length == math.inf else surface.length
    pose = surface.pose.position, surface.pose.rpy
    where = surface.name, surface.link, surface.shape, surface.radius
    return SurfaceRecord(*where, *pose, length, surface.half_axes)


def _muscle(record: MuscleRecord) -> Muscle:
    where = f"muscle {record.name!r}"
    points, branches = _points(record.points, where)
    options = read_options(MuscleOptions, record.options, where)
    return Muscle(
        record.name,
        points,
        record.f_min,
        math.inf if record.f_max is None else record.f_max,
        CableModel(record.law, tuple(record.parameters.items())),
        options.base_pulley(),
        tuple(_wrap(wrap, f"{where}, wrap {k}") for k, wrap in enumerate(record.wraps)),
        branches,
        options.terms,
        options.friction,
        options.presliding,
    )


def _points(
    records: Sequence[PointRecord], where: str
) -> tuple[tuple[ViaPoint, ...], tuple[Branch, ...]]:
    """Return via points, and the branches that begin at them."""
    points, branches = [], []
    for k, record in enumerate(records):
        options = read_options(PointOptions, record.options, f"{where}, point {k}")
        points.append(options.via_point(record.link, record.position))
        if options.branch is not None:
            branches.append(Branch(k, options.branch))
    return tuple(points), tuple(branches)


def _wrap(record: WrapRecord, where: str) -> Wrap:
    options = read_options(WrapOptions, record.options, where)
    wrap = Wrap(record.surface, record.segment, record.side, record.turns, record.inside)
    return options.apply_to(wrap)


def _surface(record: SurfaceRecord) -> WrapSurface:
    return WrapSurface(
        record.name,
        record.link,
        record.shape,
        record.radius,
        Pose(record.position, record.rpy),
        math.inf if record.length is None else record.length,
        record.half_axes,
    )
