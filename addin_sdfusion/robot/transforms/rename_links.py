"""Renaming of links in all parts of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..model.muscle import Muscle, ViaPoint, Wrap
from ..model.robot import Robot


def rename_links(robot: Robot, names: Mapping[str, str]) -> Robot:
    """Return the robot with other names of links.

    Args:
        names: New names by old names; other links keep their names.
    """

    def named(link: str) -> str:
        return names.get(link, link)

    def point(via: ViaPoint) -> ViaPoint:
        return replace(via, link=named(via.link))

    def wrap(old: Wrap) -> Wrap:
        return replace(old, side_point=old.side_point and point(old.side_point))

    def muscle(old: Muscle) -> Muscle:
        points = tuple(map(point, old.via_points))
        return replace(old, via_points=points, wraps=tuple(map(wrap, old.wraps)))

    return replace(
        robot,
        links=tuple(replace(link, name=named(link.name)) for link in robot.links),
        joints=tuple(
            replace(j, parent=named(j.parent), child=named(j.child)) for j in robot.joints
        ),
        loops=tuple(
            replace(loop, parent=named(loop.parent), child=named(loop.child))
            for loop in robot.loops
        ),
        wrap_surfaces=tuple(replace(s, link=named(s.link)) for s in robot.wrap_surfaces),
        cable_sets=tuple(
            replace(group, muscles=tuple(map(muscle, group.muscles))) for group in robot.cable_sets
        ),
        task_sets=tuple(
            replace(group, frames=tuple(replace(f, link=named(f.link)) for f in group.frames))
            for group in robot.task_sets
        ),
    )
