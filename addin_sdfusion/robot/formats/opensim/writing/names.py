"""Names that OpenSim accepts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace

from ....finding import Subject
from ....model.joint import rename_coordinate
from ....model.muscle import CableSet, ViaPoint
from ....model.robot import WORLD, Robot
from ....transforms.joint_chains import Names
from ...capability import FeaturePlace

GROUND = "ground"
ILLEGAL = re.compile(r"[\s/\\*+]|^\.+$")
"""Characters that OpenSim forbids in names, and names that mean folders."""

Renaming = dict[str, str]


def with_legal_names(robot: Robot) -> Robot:
    """Return the robot with only its active sets, and with names that OpenSim accepts."""
    renaming = _renamings(robot)
    links, joints = renaming["link"] | {WORLD: WORLD}, renaming["joint"]
    coordinates, surfaces = renaming["coordinate"], renaming["wrap surface"]
    legal = replace(
        robot,
        name=renaming["robot"][robot.name],
        links=tuple(replace(link, name=links[link.name]) for link in robot.links),
        joints=tuple(
            replace(
                joint,
                name=joints[joint.name],
                parent=links[joint.parent],
                child=links[joint.child],
                coordinates=tuple(
                    rename_coordinate(c, coordinates.__getitem__) for c in joint.coordinates
                ),
            )
            for joint in robot.joints
        ),
        loops=tuple(
            replace(
                loop, name=joints[loop.name], parent=links[loop.parent], child=links[loop.child]
            )
            for loop in robot.loops
        ),
        wrap_surfaces=tuple(
            replace(surface, name=surfaces[surface.name], link=links[surface.link])
            for surface in robot.wrap_surfaces
        ),
    )
    return _with_legal_sets(legal, renaming, links)


def renamed_objects(robot: Robot) -> Iterator[FeaturePlace]:
    """Report the names that are changed."""
    for kind, renaming in _renamings(robot).items():
        for name, new_name in renaming.items():
            if new_name != name:
                yield FeaturePlace(Subject(kind.replace(" ", "_"), name), {"given": new_name})


def _renamings(robot: Robot) -> dict[str, Renaming]:
    return {
        "robot": _legal([robot.name], ()),
        "link": _legal((link.name for link in robot.links), (WORLD, GROUND)),
        "joint": _legal([*(j.name for j in robot.joints), *(j.name for j in robot.loops)], ()),
        "coordinate": _legal((coordinate.name for coordinate in robot.all_coordinates), ()),
        "muscle": _legal((muscle.name for muscle in robot.muscles), ()),
        "task frame": _legal((frame.name for frame in robot.task_frames), ()),
        "wrap surface": _legal((surface.name for surface in robot.wrap_surfaces), ()),
    }


def _legal(names: Iterable[str], used_names: Iterable[str]) -> Renaming:
    """Return a legal name for each name; names that are already legal do not change."""
    safe = {name: ILLEGAL.sub("_", name) for name in names}
    free = Names(used_names)
    unchanged = [name for name, legal in safe.items() if name == legal]
    changed = [name for name, legal in safe.items() if name != legal]
    return {name: free.unique(safe[name]) for name in (*unchanged, *changed)}


def _with_legal_sets(robot: Robot, renaming: dict[str, Renaming], links: Renaming) -> Robot:
    surfaces, coordinates = renaming["wrap surface"], renaming["coordinate"]
    muscles = tuple(
        replace(
            muscle,
            name=renaming["muscle"][muscle.name],
            via_points=tuple(_point(p, links, coordinates) for p in muscle.via_points),
            wraps=tuple(replace(wrap, surface=surfaces[wrap.surface]) for wrap in muscle.wraps),
            terms=tuple(replace(t, coordinate=coordinates[t.coordinate]) for t in muscle.terms),
        )
        for muscle in robot.muscles
    )
    frames = tuple(
        replace(frame, name=renaming["task frame"][frame.name], link=links[frame.link])
        for frame in robot.task_frames
    )
    cable_sets = (CableSet(robot.cable_set, muscles),) if robot.cable_set else ()
    task_sets = tuple(
        replace(group, frames=frames) for group in robot.task_sets if group.name == robot.task_set
    )
    return replace(robot, cable_sets=cable_sets, task_sets=task_sets)


def _point(point: ViaPoint, links: Renaming, coordinates: Renaming) -> ViaPoint:
    when = point.when
    when = when and replace(when, coordinate=coordinates[when.coordinate])
    moves = tuple(replace(m, coordinate=coordinates[m.coordinate]) for m in point.moves)
    return replace(point, link=links[point.link], when=when, moves=moves)
