"""Changes of a robot by an experiment: numbers, vectors and attachments, by name.

The tables below [robot] have the names of the attributes of `Robot`; `points` are via points:

    [robot.links.link_1.inertia]
    mass = 2.5
    [robot.muscles.cable_1]
    "points[0]" = { link = "world", position = [0.5, 0.0, 0.1] }
    [robot.muscles."extensor_*"]
    f_max = 300.0           # of all muscles with matching names
    [robot.joints.elbow]
    motor = true            # one motor per coordinate
    effort = 30.0           # maximum torque or force, or [min, max]

A `locked` joint or coordinate does not move. The resulting robot does not have this coordinate.

    [robot.joints.elbow]
    locked = true  # at the initial position; or a position, or one position per coordinate
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Joint, Robot, TaskSet, UnknownNameError
from addin_sdfusion.robot.model.joint import Coordinate
from addin_sdfusion.robot.transforms.lock import lock
from cardsflow_fmu.experiment.config.key_path import PathError, expand_names, split_index
from cardsflow_fmu.experiment.config.messages import join_keys
from cardsflow_fmu.experiment.config.table import Text, Whole, numbers, validated

KINDS = {
    "links": "link",
    "joints": "joint",
    "coordinates": "coordinate",
    "muscles": "muscle",
    "task_frames": "task frame",
    "wrap_surfaces": "wrap surface",
}
"""Kinds of parts by table."""

ALIASES = {"points": "via_points"}
"""Attributes of parts by key, for keys that differ from the attribute."""

LOCKED = "locked"
_MAY_BE_LOCKED = ("joints", "coordinates")
_EXTRA_KEYS = {"joints": (LOCKED, "motor", "effort"), "coordinates": (LOCKED,)}
"""Additional keys of tables that are not attributes of the part."""
_FIXED = ("name", "motions")  # other parts and the order of the coordinates depend on these


def with_overrides(robot: Robot, overrides: Mapping[str, Any], file: Path, key: str) -> Robot:
    """Return the robot with changed parts and locked coordinates, without checks of the result.

    Raises:
        InputError: A change is invalid.
    """
    locked: dict[str, Any] = {}
    try:
        for kind, parts in overrides.items():
            items = {item.name: item for item in getattr(robot, kind)}
            for key_, name, fields in expand_names(parts, KINDS[kind], items, kind):
                if kind in _MAY_BE_LOCKED and isinstance(fields, Mapping) and LOCKED in fields:
                    fields = dict(fields)
                    locked |= _locked_positions(items[name], fields.pop(LOCKED), f"{key_}.{LOCKED}")
                if kind == "joints":
                    items[name], fields = _apply_motor_settings(items[name], fields, key_)
                items[name] = _change_part(items[name], fields, key_, _EXTRA_KEYS.get(kind, ()))
            robot = _replace_parts(robot, kind, list(items.values()))
        if locked:
            robot = lock(robot, _lock_positions(robot, locked))
    except InputError as error:
        error.file, error.key = file, join_keys(key, error.key)
        raise
    return robot


def _apply_motor_settings(joint: Joint, fields: Any, key: str) -> tuple[Joint, dict[str, Any]]:
    """Apply `motor` and `effort` to a joint; return it with the other changes."""
    others, changes = dict(validated(dict[str, Any], fields, key)), {}
    if "motor" in others:
        changes["actuated"] = validated(bool, others.pop("motor"), f"{key}.motor")
    if "effort" in others:
        effort, at = others.pop("effort"), f"{key}.effort"
        if isinstance(effort, list | tuple):
            changes["tau_min"], changes["tau_max"] = validated(numbers(2), effort, at)
        else:
            changes["tau_max"] = validated(float, effort, at)
            changes["tau_min"] = -changes["tau_max"]
            if changes["tau_max"] < 0.0:
                raise PathError(
                    "must not be negative; set the maximum torque, or [min, max]", key=at
                )
    coordinates = tuple(replace(c, **changes) for c in joint.coordinates)
    return replace(joint, coordinates=coordinates), others


def _locked_positions(item: Joint | Coordinate, value: Any, key: str) -> dict[str, Any]:
    """Return the locked positions of a joint or coordinate, by name; True: initial position."""
    coordinates = item.coordinates if isinstance(item, Joint) else (item,)
    if not coordinates:
        raise PathError("has no coordinates to lock", key=key)
    if isinstance(value, bool):
        return dict.fromkeys((c.name for c in coordinates), True) if value else {}
    if len(coordinates) == 1 and not isinstance(value, list | tuple):
        value = [value]
    values = validated(numbers(len(coordinates)), value, key)
    return {c.name: float(x) for c, x in zip(coordinates, values, strict=True)}


def _lock_positions(robot: Robot, locked: Mapping[str, Any]) -> dict[str, float]:
    return {
        c.name: min(max(c.initial, c.lower), c.upper) if locked[c.name] is True else locked[c.name]
        for c in robot.coordinates
        if c.name in locked
    }


def _replace_parts(robot: Robot, kind: str, items: Sequence[Any]) -> Robot:
    """Return the robot with changed parts of a kind; number and order are unchanged."""
    if kind == "muscles":
        return robot.with_muscles(items)
    if kind == "task_frames":
        changed = TaskSet(robot.task_set, tuple(items))
        sets = (changed if s.name == robot.task_set else s for s in robot.task_sets)
        return replace(robot, task_sets=tuple(sets))
    if kind == "coordinates":
        left = iter(items)
        joints = (
            replace(
                joint,
                coordinates=tuple(next(left) if c.is_free else c for c in joint.coordinates),
            )
            for joint in robot.joints
        )
        return replace(robot, joints=tuple(joints))
    changes: dict[str, Any] = {kind: tuple(items)}
    return replace(robot, **changes)


def _change_part(item: Any, fields: Any, key: str, extra_keys: Sequence[str] = ()) -> Any:
    """Return a part with changed attributes."""
    values = {field.name: getattr(item, field.name) for field in dataclasses.fields(item)}
    for fixed in _FIXED:
        values.pop(fixed, None)
    changed = dict(values)
    for field, new in validated(dict[str, Any], fields, key).items():
        name, index = split_index(field)
        name, at = ALIASES.get(name, name), f"{key}.{field}"
        if name not in values:
            names = [next((a for a, n in ALIASES.items() if n == k), k) for k in values]
            raise UnknownNameError("field", field, dict.fromkeys([*extra_keys, *names]), key=at)
        old = changed[name]
        changed[name] = (
            _new_value(old, new, at) if index is None else _replace_element(old, index, new, at)
        )
    return replace(item, **changed)


def _replace_element(old: Any, index: int, new: Any, key: str) -> Any:
    """Return a list with one changed element."""
    if not isinstance(old, tuple) or index >= len(old):
        size = len(old) if isinstance(old, tuple) else "no"
        raise PathError(f"has {size} elements; indices begin at 0", key=key)
    return (*old[:index], _new_value(old[index], new, key), *old[index + 1 :])


def _new_value(old: Any, new: Any, key: str) -> Any:
    """Return the new value, with the type of the old value."""
    if dataclasses.is_dataclass(old):
        return _change_part(old, new, key)
    if isinstance(old, bool):
        return validated(bool, new, key)
    if isinstance(old, int):
        return validated(Whole, new, key)
    if isinstance(old, float):
        return validated(float, new, key)
    if isinstance(old, str):
        return validated(Text, new, key)
    if isinstance(old, tuple) and old and all(isinstance(x, int | float) for x in old):
        return validated(numbers(len(old)), new, key)
    if is_parameters(old):
        table = validated(dict[str, Any], new, key)
        for name in table:
            if name not in dict(old):
                raise UnknownNameError("parameter", name, dict(old), key=f"{key}.{name}")
        return tuple(
            (n, _new_value(x, table[n], f"{key}.{n}") if n in table else x) for n, x in old
        )
    if isinstance(old, tuple) and old:
        row = key.rpartition(".")[2]
        raise PathError(f"is a list; add an index, such as {row}[0]", key=key)
    raise PathError(f"{old!r} cannot be changed", key=key)


def is_parameters(old: Any) -> bool:
    """Return whether a value consists of pairs of name and number."""
    if not isinstance(old, tuple) or not old:
        return False
    return all(isinstance(x, tuple) and len(x) == 2 and isinstance(x[0], str) for x in old)
