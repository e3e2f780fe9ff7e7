"""Names that OpenSim accepts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace

from ....finding import Subject
from ....model.robot import WORLD, Robot
from ....transforms.joint_chains import Names
from ....transforms.part_map import PartMap
from ...capability import FeaturePlace

GROUND = "ground"
ILLEGAL = re.compile(r"[\s/\\*+]|^\.+$")
"""Characters that OpenSim forbids in names, and names that mean folders."""

Renaming = dict[str, str]


def with_legal_names(robot: Robot) -> Robot:
    """Return the robot with only its active sets, and with names that OpenSim accepts."""
    renaming = _renamings(robot)
    links = renaming["link"] | {WORLD: WORLD}
    legal = PartMap(
        link=links.__getitem__,
        joint=renaming["joint"].__getitem__,
        coordinate=renaming["coordinate"].__getitem__,
        muscle=renaming["muscle"].__getitem__,
        task_frame=renaming["task frame"].__getitem__,
        surface=renaming["wrap surface"].__getitem__,
    )
    active = replace(
        robot,
        name=renaming["robot"][robot.name],
        cable_sets=tuple(s for s in robot.cable_sets if s.name == robot.cable_set),
        task_sets=tuple(s for s in robot.task_sets if s.name == robot.task_set),
    )
    return legal.apply_to(active)


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
