"""What an experiment changes of its robot: any number, vector or attachment, by name.

The tables below [robot] are named as the parts of `Robot` are; `points` stands for via points:

    [robot.links.link_1.inertia]
    mass = 2.5
    [robot.muscles.cable_1]
    "points[0]" = { link = "world", position = [0.5, 0.0, 0.1] }
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from addin_sdfusion.robot import Robot, TaskSet
from cardsflow_fmu.config.key_path import PathError, indexed
from cardsflow_fmu.config.table import Table

KINDS = {
    "links": "link",
    "joints": "joint",
    "coordinates": "coordinate",
    "muscles": "muscle",
    "task_frames": "task frame",
    "wrap_surfaces": "wrap surface",
}
"""The tables of changes, and what is named in them."""

ALIASES = {"points": "via_points"}
"""Names of fields in files, where they are others."""

_FIXED = ("name", "motions")  # what other parts, and the order of the coordinates, rest on


def read_changes(table: Table) -> dict[str, Any]:
    """The tables of changes that stand in [robot], as they are given.

    Args:
        table: The table [robot].

    Raises:
        InputError: One is no table.
    """
    given = {kind: table.table(kind) for kind in KINDS}
    return {kind: table.value(kind) for kind, changes in given.items() if not changes.is_empty}


def changed_robot(robot: Robot, changes: Mapping[str, Any], table: Table) -> Robot:
    """The robot with the changes; not checked.

    Args:
        robot: The robot, with the cable set and the operational space that count.
        changes: From `read_changes`.
        table: The table [robot], for messages.

    Raises:
        UnknownNameError: A change is for something that does not exist; the nearest is named.
        InputError: A value does not fit the one that it is for.
    """
    for kind, parts in changes.items():
        items = getattr(robot, kind)
        inner = Table(parts, table.file, table.key(kind))
        changed = {
            index: _changed(items[index], part)
            for index, part in inner.tables([item.name for item in items], KINDS[kind])
        }
        robot = _with(robot, kind, [changed.get(i, item) for i, item in enumerate(items)])
    return robot


def _with(robot: Robot, kind: str, items: Sequence[Any]) -> Robot:
    """The robot with other links, joints, ...: the same number of them, in the same order."""
    if kind == "muscles":
        return robot.with_muscles(items)
    if kind == "task_frames":
        changed = TaskSet(robot.task_set, tuple(items))
        sets = (changed if s.name == robot.task_set else s for s in robot.task_sets)
        return replace(robot, task_sets=tuple(sets))
    if kind == "coordinates":
        left = iter(items)
        joints = (
            replace(joint, coordinates=tuple(next(left) for _ in joint.coordinates))
            for joint in robot.joints
        )
        return replace(robot, joints=tuple(joints))
    whole: dict[str, Any] = {kind: tuple(items)}
    return replace(robot, **whole)


def _changed(item: Any, table: Table) -> Any:
    """A part of the robot with the changes that a table holds."""
    known = {field.name: getattr(item, field.name) for field in dataclasses.fields(item)}
    for fixed in _FIXED:
        known.pop(fixed, None)
    fields = dict(known)
    for key in table:
        name, index = indexed(key)
        name = ALIASES.get(name, name)
        if name not in known:
            names = [next((a for a, n in ALIASES.items() if n == k), k) for k in known]
            raise table.unknown(key, "field", key, names)
        new = _value if index is None else _element
        fields[name] = new(fields[name], table, key)
    return replace(item, **fields)


def _element(old: Any, table: Table, key: str) -> Any:
    """A row with another element, where the key has an index."""
    _, index = indexed(key)
    assert index is not None
    if not isinstance(old, tuple) or index >= len(old):
        size = len(old) if isinstance(old, tuple) else "no"
        raise _no_way(table, key, f"has {size} elements, counted from 0")
    return (*old[:index], _value(old[index], table, key), *old[index + 1 :])


def _value(old: Any, table: Table, key: str) -> Any:
    """The new value, of the kind that the old one is of."""
    if dataclasses.is_dataclass(old):
        return _changed(old, table.table(key))
    if isinstance(old, bool):
        return table.flag(key)
    if isinstance(old, int):
        return table.whole(key)
    if isinstance(old, float):
        return table.number(key)
    if isinstance(old, str):
        return table.text(key)
    if isinstance(old, tuple) and old and all(isinstance(x, int | float) for x in old):
        return table.numbers(key, len(old))
    if is_parameters(old):
        given = table.table(key)
        for name in given:
            if name not in dict(old):
                raise given.unknown(name, "parameter", name, dict(old))
        return tuple((name, _value(x, given, name) if name in given else x) for name, x in old)
    if isinstance(old, tuple) and old:
        raise _no_way(table, key, f"is a row: say which one, such as {key}[0]")
    raise _no_way(table, key, f"{old!r} cannot be changed")


def _no_way(table: Table, key: str, what: str) -> PathError:
    return PathError(what, file=table.file, key=table.key(key))


def is_parameters(old: Any) -> bool:
    """Whether a value is pairs of name and number."""
    if not isinstance(old, tuple) or not old:
        return False
    return all(isinstance(x, tuple) and len(x) == 2 and isinstance(x[0], str) for x in old)
