"""Conversion of the muscles of a design to the link frames of the robot."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from ..muscles.rows import PointRow, WrapRow
from ..muscles.table import MuscleTable
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import error, unknown, warning
from ..robot.model.muscle import CableSet, Muscle, ViaPoint, Wrap, WrapSurface
from ..robot.model.pose import Pose, Vector3
from ..robot.model.robot import ANGLES, MARKERS, POSITIONS, WORLD, TaskFrame, TaskSet
from ..robot.model.rotations import z_axis_rpy
from ..robot.model.transform import IDENTITY, Transform, tidy
from ..snapshot import WrapUse
from .links.links import in_name_order

CABLE_SET = "muscles"
TASK_SET = "task"

_COINCIDENT = 1e-9  # in [m]


class RobotMuscles(NamedTuple):
    """Muscles, task points, markers and wrap surfaces in the frames of the links.

    Attributes:
        cable_sets: One set with all muscles; empty if there are no muscles.
        task_sets: Sets of the task points and the markers, if any.
    """

    cable_sets: tuple[CableSet, ...]
    task_sets: tuple[TaskSet, ...]
    surfaces: tuple[WrapSurface, ...]
    findings: tuple[Finding, ...]


def robot_muscles(
    table: MuscleTable, T_world_link: Mapping[str, Transform], suppressed: Collection[str] = ()
) -> RobotMuscles:
    """Transform a muscle table to the frames of the links.

    Args:
        table: Muscle table in the world frame, at the pose of the design.
        T_world_link: Poses of the links at that pose.
        suppressed: Links whose rigid group is suppressed, for messages.
    """
    return _Muscles(table, T_world_link, suppressed).all()


class _Muscles:
    def __init__(
        self,
        table: MuscleTable,
        T_world_link: Mapping[str, Transform],
        suppressed: Collection[str],
    ) -> None:
        self._table = table
        self._T_link_world = {link: T.inverse() for link, T in T_world_link.items()}
        self._T_link_world.setdefault(WORLD, IDENTITY)
        self._links = in_name_order(T_world_link)
        self._suppressed = suppressed
        self._findings: list[Finding] = []

    def all(self) -> RobotMuscles:
        surfaces = tuple(
            s for row in self._table.wraps if not row.lost and (s := self._surface(row)) is not None
        )
        names = {surface.name for surface in surfaces}
        points = {
            row.name: [p for p in self._table.points_of(row.name) if not p.lost]
            for row in self._table.rows
        }
        muscles = tuple(
            Muscle(
                row.name,
                tuple(self._via_points(row.name, points[row.name])),
                row.f_min,
                row.f_max,
                row.cable_model,
                wraps=self._segments(
                    points[row.name],
                    [pair for pair in self._table.wraps_of(row.name) if pair[0].name in names],
                ),
            )
            for row in self._table.rows
        )
        sets = [
            TaskSet(name, frames)
            for name, rows in ((TASK_SET, self._table.tasks), (MARKERS, self._table.markers))
            if (frames := tuple(self._frames(rows)))
        ]
        cable_sets = (CableSet(CABLE_SET, muscles),) if muscles else ()
        return RobotMuscles(cable_sets, tuple(sets), surfaces, tuple(self._findings))

    def _via_points(self, muscle: str, points: Sequence[PointRow]) -> Iterable[ViaPoint]:
        subject = Subject("muscle", muscle)
        lost: dict[str, list[int]] = {}
        for point in points:
            if point.link not in self._T_link_world:
                lost.setdefault(point.link, []).append(point.number)
        for link, numbers in lost.items():
            which = f"point{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"
            self._unknown_link(subject, f"its {which}", link)
        for before, after in pairwise(points):
            apart = math.dist(before.position, after.position)
            if before.link != after.link and apart < _COINCIDENT:
                problem = (
                    f"its points {before.number} and {after.number}, on {before.link!r} and "
                    f"{after.link!r}, coincide, so the cable between them has no direction; move "
                    "one of them in Define muscles"
                )
                self._findings.append(warning(subject, "coincident-points", problem))
        return [self._via_point(p) for p in points if p.link in self._T_link_world]

    def _via_point(self, point: PointRow) -> ViaPoint:
        return ViaPoint(point.link, self._local(point.link, point.position))

    def _local(self, link: str, position: Vector3) -> Vector3:
        return tidy(self._T_link_world[link].apply(position))

    def _unknown_link(self, subject: Subject, label: str, link: str) -> None:
        alike = [name for name in self._links if name.casefold() == link.casefold()]
        if link in self._suppressed:
            reason = f"the rigid group of link {link!r} is suppressed; unsuppress it."
        elif alike:
            reason = f"no link {link!r}; names are case-sensitive, did you mean {alike[0]!r}?"
        else:
            reason = f"{unknown('link', link, [*self._links, WORLD])}."
        problem = f"{label} cannot be exported: {reason} Choose its link in Define muscles"
        self._findings.append(error(subject, "unknown-link", problem))

    def _segments(
        self, points: Sequence[PointRow], uses: Iterable[tuple[WrapRow, WrapUse]]
    ) -> tuple[Wrap, ...]:
        """Return the wraps of a muscle without invalid ones, which `table_findings` reports."""
        index = {point.number: i for i, point in reversed(list(enumerate(points)))}
        return tuple(
            Wrap(row.name, index[use.after], use.side, use.turns, use.inside)
            for row, use in uses
            if index.get(use.after, len(points)) < len(points) - 1
        )

    def _surface(self, row: WrapRow) -> WrapSurface | None:
        if row.link not in self._T_link_world:
            self._unknown_link(Subject("wrap_surface", row.name), "it", row.link)
            return None
        face = row.face
        centre = self._local(row.link, face.centre)
        if face.shape == "sphere":
            return WrapSurface(row.name, row.link, "sphere", face.radius, Pose(centre))
        axis = self._T_link_world[row.link].rotate(face.axis)
        length = face.length if face.length > 0.0 else math.inf
        pose = Pose(centre, z_axis_rpy(axis))
        return WrapSurface(row.name, row.link, "cylinder", face.radius, pose, length)

    def _frames(self, rows: Sequence[PointRow]) -> Iterable[TaskFrame]:
        for row in (row for row in rows if not row.lost):
            subject = Subject("task_frame", row.name)
            if row.link == WORLD:
                problem = (
                    "is fixed to the world, so it cannot move; choose its link in Define muscles"
                )
                self._findings.append(error(subject, "task-point-on-world", problem))
            elif row.link not in self._T_link_world:
                self._unknown_link(subject, "it", row.link)
            else:
                axes = row.axes or POSITIONS
                turns = bool(axes) and axes[0] in ANGLES
                position = IDENTITY.p if turns else self._local(row.link, row.position)
                yield TaskFrame(row.name, row.link, position, axes)
