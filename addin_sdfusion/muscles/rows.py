"""Rows of the table of muscles, and the table.

Positions are in the design's root frame at the design's pose, in [m].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..robot.model.muscle import CableModel
from ..robot.model.pose import Vector3
from ..robot.model.robot import Axis
from ..snapshot import DEFAULT_COLOR, F_MAX, F_MIN, MuscleSnapshot, WrapUse
from .point_names import natural_key

_IDEAL = CableModel()

NAMED_COLORS = {
    "Red": DEFAULT_COLOR,
    "Blue": "#1f77b4",
    "Green": "#2ca02c",
    "Orange": "#ff7f0e",
    "Purple": "#9467bd",
    "Cyan": "#17becf",
    "Pink": "#e377c2",
    "Brown": "#8c564b",
    "Olive": "#bcbd22",
    "Grey": "#7f7f7f",
}
COLORS = tuple(NAMED_COLORS.values())
"""Colours that muscles get in turn."""


@dataclass(frozen=True, slots=True)
class MuscleRow:
    """A muscle, without its points.

    Attributes:
        name: Its name.
        color: What it is drawn in, as `#rrggbb`.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite where unknown.
        model: How force, length and stiffness belong together.
    """

    name: str
    color: str = COLORS[0]
    f_min: float = F_MIN
    f_max: float = F_MAX
    model: CableModel = _IDEAL


def muscle_row(m: MuscleSnapshot) -> MuscleRow:
    """The row of a design's muscle."""
    model = CableModel(m.model, tuple(m.parameters.items()))
    return MuscleRow(m.name, m.color.lower(), m.f_min, m.f_max, model)


@dataclass(frozen=True, slots=True)
class ViaPointRow:
    """A point that a muscle passes through.

    Attributes:
        muscle: Name of the muscle.
        number: Place along the muscle; not always without gaps.
        link: Name of the link it is fixed to.
        position: In the root frame, in [m].
        entity: What the CAD system's point is; empty if there is none yet.
        occurrence: Path of the occurrence that holds the point.
        name: The construction point's name; empty if there is none yet.
        made: Whether the add-in made the construction point.
    """

    muscle: str
    number: int
    link: str
    position: Vector3
    entity: str = ""
    occurrence: str = ""
    name: str = ""
    made: bool = False


@dataclass(frozen=True, slots=True)
class PointRow:
    """A named point.

    Attributes:
        name: Its name.
        link: Name of the link it is fixed to.
        position: In the root frame, in [m].
        entity: What the CAD system's point is; empty if there is none yet.
        occurrence: Path of the occurrence that holds the point.
        made: Whether the add-in made the construction point.
    """

    name: str
    link: str
    position: Vector3
    entity: str = ""
    occurrence: str = ""
    made: bool = False


@dataclass(frozen=True, slots=True)
class TaskRow(PointRow):
    """A point whose position is controlled or reported, with the coordinates that count."""

    axes: tuple[Axis, ...] = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class MarkerRow(PointRow):
    """A point that a camera sees."""


@dataclass(frozen=True, slots=True)
class WrapRow:
    """A cylinder or sphere that muscles wrap over.

    Attributes:
        name: Its name.
        link: Name of the link it is fixed to.
        shape: `sphere` or `cylinder`.
        radius: In [m].
        centre: Of the sphere, or of the cylinder's middle, in the root frame, in [m].
        axis: Of the cylinder, a unit vector in the root frame.
        length: Of the cylinder, in [m].
        muscles: Which muscles wrap over it.
        entity: What the CAD system's face is; empty if there is none.
        occurrence: Path of the occurrence that holds the face.
    """

    name: str
    link: str
    shape: Literal["sphere", "cylinder"]
    radius: float
    centre: Vector3
    axis: Vector3 = (0.0, 0.0, 1.0)
    length: float = 0.0
    muscles: tuple[WrapUse, ...] = ()
    entity: str = ""
    occurrence: str = ""


@dataclass(frozen=True, slots=True)
class MuscleTable:
    """All that the user has defined on top of the bodies and joints.

    Attributes:
        rows: The muscles, in order; the names are unique.
        points: Via points: muscles in their order, then by number.
        tasks: Task points, by name.
        markers: Markers, by name.
        wraps: Wrap surfaces, by name.
    """

    rows: tuple[MuscleRow, ...] = ()
    points: tuple[ViaPointRow, ...] = ()
    tasks: tuple[TaskRow, ...] = ()
    markers: tuple[MarkerRow, ...] = ()
    wraps: tuple[WrapRow, ...] = ()

    def points_of(self, muscle: str) -> tuple[ViaPointRow, ...]:
        """The via points of a muscle, in order."""
        return tuple(point for point in self.points if point.muscle == muscle)

    def row(self, muscle: str) -> MuscleRow | None:
        """The muscle of that name; None if there is none."""
        return next((row for row in self.rows if row.name == muscle), None)

    def wraps_of(self, muscle: str) -> tuple[tuple[WrapRow, WrapUse], ...]:
        """The surfaces that a muscle wraps over, in the order of its points."""
        uses = [(row, use) for row in self.wraps for use in row.muscles if use.muscle == muscle]
        return tuple(sorted(uses, key=lambda pair: (pair[1].after, natural_key(pair[0].name))))
