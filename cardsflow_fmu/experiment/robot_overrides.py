"""Changes of a robot by an experiment: numbers, vectors and attachments, by name.

The tables below [robot] have the names of the attributes of `Robot`; `points` are via points:

    [robot.links.link_1.inertia]
    mass = 2.5
    [robot.muscles.cable_1]
    "points[0]" = { link = "world", position = [0.5, 0.0, 0.1] }
    [robot.muscles."extensor_*"]
    f_max = 300.0           # of all muscles with matching names
    [robot.joints.elbow]
    motor = true            # one for each of its coordinates
    effort = 30.0           # its maximum torque or force, or [min, max]

A `locked` joint or coordinate does not move. It is not a coordinate of the resulting robot.

    [robot.joints.elbow]
    locked = true  # at its initial value; or a number, or one for each of its coordinates
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
from cardsflow_fmu.experiment.config.key_path import PathError, by_name, indexed
from cardsflow_fmu.experiment.config.messages import joined
from cardsflow_fmu.experiment.config.table import Text, Whole, checked, numbers

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
"""Attributes of parts by key, where the names differ."""

LOCKED = "locked"
_MAY_BE_LOCKED = ("joints", "coordinates")
_WORDS = {"joints": (LOCKED, "motor", "effort"), "coordinates": (LOCKED,)}
"""Additional keys of tables, which are not attributes of the part."""
_FIXED = ("name", "motions")  # other parts and the order of the coordinates depend on these


def with_overrides(robot: Robot, overrides: Mapping[str, Any], file: Path, key: str) -> Robot:
    """Return the robot with changed parts and locked coordinates; not checked."""
    held: dict[str, Any] = {}
    try:
        for kind, parts in overrides.items():
            items = {item.name: item for item in getattr(robot, kind)}
            for key_, name, fields in by_name(parts, KINDS[kind], items, kind):
                if kind in _MAY_BE_LOCKED and isinstance(fields, Mapping) and LOCKED in fields:
                    fields = dict(fields)
                    held |= _held(items[name], fields.pop(LOCKED), f"{key_}.{LOCKED}")
                if kind == "joints":
                    items[name], fields = _with_motor(items[name], fields, key_)
                items[name] = _changed(items[name], fields, key_, _WORDS.get(kind, ()))
            robot = _with(robot, kind, list(items.values()))
        if held:
            robot = lock(robot, _positions(robot, held))
    except InputError as error:
        error.file, error.key = file, joined(key, error.key)
        raise
    return robot


def _with_motor(joint: Joint, fields: Any, key: str) -> tuple[Joint, dict[str, Any]]:
    """Apply `motor` and `effort` to a joint; return it with the other changes."""
    given, words = dict(checked(dict[str, Any], fields, key)), {}
    if "motor" in given:
        words["actuated"] = checked(bool, given.pop("motor"), f"{key}.motor")
    if "effort" in given:
        effort, at = given.pop("effort"), f"{key}.effort"
        if isinstance(effort, list | tuple):
            words["tau_min"], words["tau_max"] = checked(numbers(2), effort, at)
        else:
            words["tau_max"] = checked(float, effort, at)
            words["tau_min"] = -words["tau_max"]
            if words["tau_max"] < 0.0:
                raise PathError(
                    "must not be negative; set the maximum torque, or [min, max]", key=at
                )
    coordinates = tuple(replace(c, **words) for c in joint.coordinates)
    return replace(joint, coordinates=coordinates), given


def _held(item: Joint | Coordinate, value: Any, key: str) -> dict[str, Any]:
    """Return the locked positions of a joint or coordinate, by name; True: initial position."""
    own = item.coordinates if isinstance(item, Joint) else (item,)
    if not own:
        raise PathError("has no coordinates to lock", key=key)
    if isinstance(value, bool):
        return dict.fromkeys((c.name for c in own), True) if value else {}
    if len(own) == 1 and not isinstance(value, list | tuple):
        value = [value]
    values = checked(numbers(len(own)), value, key)
    return {c.name: float(x) for c, x in zip(own, values, strict=True)}


def _positions(robot: Robot, held: Mapping[str, Any]) -> dict[str, float]:
    return {
        c.name: min(max(c.initial, c.lower), c.upper) if held[c.name] is True else held[c.name]
        for c in robot.coordinates
        if c.name in held
    }


def _with(robot: Robot, kind: str, items: Sequence[Any]) -> Robot:
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
    whole: dict[str, Any] = {kind: tuple(items)}
    return replace(robot, **whole)


def _changed(item: Any, fields: Any, key: str, words: Sequence[str] = ()) -> Any:
    """Return a part with changed attributes; `words` are additional keys of its table."""
    known = {field.name: getattr(item, field.name) for field in dataclasses.fields(item)}
    for fixed in _FIXED:
        known.pop(fixed, None)
    changed = dict(known)
    for field, new in checked(dict[str, Any], fields, key).items():
        name, index = indexed(field)
        name, at = ALIASES.get(name, name), f"{key}.{field}"
        if name not in known:
            names = [next((a for a, n in ALIASES.items() if n == k), k) for k in known]
            raise UnknownNameError("field", field, dict.fromkeys([*words, *names]), key=at)
        old = changed[name]
        changed[name] = _value(old, new, at) if index is None else _element(old, index, new, at)
    return replace(item, **changed)


def _element(old: Any, index: int, new: Any, key: str) -> Any:
    """Return a list with one changed element."""
    if not isinstance(old, tuple) or index >= len(old):
        size = len(old) if isinstance(old, tuple) else "no"
        raise PathError(f"has {size} elements; indices begin at 0", key=key)
    return (*old[:index], _value(old[index], new, key), *old[index + 1 :])


def _value(old: Any, new: Any, key: str) -> Any:
    """Return the new value, with the type of the old value."""
    if dataclasses.is_dataclass(old):
        return _changed(old, new, key)
    if isinstance(old, bool):
        return checked(bool, new, key)
    if isinstance(old, int):
        return checked(Whole, new, key)
    if isinstance(old, float):
        return checked(float, new, key)
    if isinstance(old, str):
        return checked(Text, new, key)
    if isinstance(old, tuple) and old and all(isinstance(x, int | float) for x in old):
        return checked(numbers(len(old)), new, key)
    if is_parameters(old):
        given = checked(dict[str, Any], new, key)
        for name in given:
            if name not in dict(old):
                raise UnknownNameError("parameter", name, dict(old), key=f"{key}.{name}")
        return tuple((n, _value(x, given[n], f"{key}.{n}") if n in given else x) for n, x in old)
    if isinstance(old, tuple) and old:
        row = key.rpartition(".")[2]
        raise PathError(f"is a list; add an index, such as {row}[0]", key=key)
    raise PathError(f"{old!r} cannot be changed", key=key)


def is_parameters(old: Any) -> bool:
    """Return whether a value consists of pairs of name and number."""
    if not isinstance(old, tuple) or not old:
        return False
    return all(isinstance(x, tuple) and len(x) == 2 and isinstance(x[0], str) for x in old)
