"""Conversion of build123d joints to records of a snapshot.

The method `relative_to` of a joint returns the pose of one part in the frame of the other part at
any angle and position. The rotation axis is computed from these poses, and the current joint value
from the poses of the parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import InputError, Vector3
from addin_sdfusion.robot.model.rotations import normalized
from addin_sdfusion.robot.model.transform import Transform
from addin_sdfusion.snapshot import JointKind, JointSnapshot, MotionSnapshot

from .assembly import Place
from .kernel import placed

_APART = 1e-6  # in [m] and [rad]: larger deviations mean that a part was moved after connecting
_TIDY = 1e-12


class _Pair(NamedTuple):
    """Two connected joints; part `one` moves relative to part `two`.

    Attributes:
        joint: Joint of part `two`.
        other: Joint of part `one`.
        two, one: Places of the parts.
        unit: Unit of length, in [m].
    """

    joint: Any
    other: Any
    two: Place
    one: Place
    unit: float

    def at(self, **values: float) -> Transform:
        """Return T_two_one at joint values, in degrees and units of length."""
        return placed(self.joint.relative_to(self.other, **values), self.unit)

    def now(self) -> Transform:
        """Return T_two_one for the current poses of the parts."""
        return self.two.T.inverse().compose(self.one.T)


def joint_record(
    name: str,
    joint: Any,
    other: Any,
    places: tuple[Place, Place],
    unit: float,
    values: Mapping[str, Any],
) -> JointSnapshot:
    """Return the record of two connected joints.

    Raises:
        InputError: The type is unknown, or a part was moved after the joints were connected.
    """
    pair = _Pair(joint, other, *places, unit)
    types = type(joint).__name__, type(other).__name__
    if types[0] == "RigidJoint" and types[1] != "RigidJoint":  # the other joint defines the motion
        pair, types = _Pair(other, joint, places[1], places[0], unit), (types[1], types[0])
    entry = _KINDS.get(types)
    if entry is None:
        raise InputError(f"joint {name!r}: {types[0]} to {types[1]} is not supported")
    kind, find = entry
    motions = find(pair)
    _require_in_place(name, pair, kind, motions)
    placed = tuple(
        replace(motion, axis=_tidy(pair.two.T.rotate(motion.axis)), **values) for motion in motions
    )
    origins = _origin(pair.other, pair.one, unit), _origin(pair.joint, pair.two, unit)
    return JointSnapshot(name, kind, pair.one.path, pair.two.path, *origins, placed)


def _origin(joint: Any, place: Place, unit: float) -> Vector3:
    return place.T.apply(placed(_end(joint), unit).p)


def _require_in_place(
    name: str, pair: _Pair, kind: JointKind, motions: tuple[MotionSnapshot, ...]
) -> None:
    """Reject parts whose poses do not match the joint at its current values."""
    if kind == "ball":  # a ball allows any rotation, and the export compares its origins
        return
    values = {}
    for motion in motions:
        if motion.kind == "translation":
            values["position"] = _within(motion.value / pair.unit, pair.joint.linear_range)
        else:
            turning = pair.other if kind == "pin_slot" else pair.joint
            low, high = turning.angular_range
            beyond = (math.degrees(motion.value) - low) % 360.0
            values["angle"] = _within(low + beyond, (low, high))
    expected, now = pair.at(**values), pair.now()
    rotation_error = float(np.max(np.abs(np.subtract(expected.R, now.R))))
    if max(rotation_error, math.dist(expected.p, now.p)) > _APART:
        problem = "its parts were moved after they were connected; connect them after moving them"
        raise InputError(f"joint {name!r}: {problem}")


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])


def _revolute(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    return (_turning(pair, lambda a: pair.at(angle=a), pair.joint.angular_range),)


def _linear(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    return (_sliding(pair, lambda p: pair.at(position=p)),)


def _cylindrical(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Return a rotation and a translation along the same axis."""
    turn, slide = _both(pair, pair.joint.angular_range)
    return turn, slide


def _slot(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Return a translation, followed by a rotation."""
    turn, slide = _both(pair, pair.other.angular_range)
    return slide, turn


def _both(pair: _Pair, angles: tuple[float, float]) -> tuple[MotionSnapshot, MotionSnapshot]:
    place = _within(0.0, pair.joint.linear_range)
    turn = _turning(pair, lambda a: pair.at(position=place, angle=a), angles, "rotation")
    return turn, _sliding(pair, lambda p: pair.at(position=p, angle=angles[0]), "slide")


def _ball(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Return rotations about x, y and z of the joint, in that order: R = Rx Ry Rz."""
    joint = pair.joint
    L, reference, end = (
        placed(location, pair.unit)
        for location in (
            joint.relative_location,
            joint.angle_reference.location,
            pair.other.relative_location,
        )
    )
    R = L.inverse().compose(pair.now()).compose(end).compose(reference.inverse()).R
    motions = []
    angles = Rotation.from_matrix(R).as_euler("XYZ").tolist()
    for number, (role, value) in enumerate(zip("xyz", angles, strict=True)):
        lower, upper = _limits(joint.angular_range[number])
        axis = _tidy(L.axis(number))
        motions.append(MotionSnapshot("rotation", axis, _small(value), lower, upper, role))
    return tuple(motions)


def _turning(
    pair: _Pair,
    at: Callable[[float], Transform],
    angles: tuple[float, float],
    role: str = "",
) -> MotionSnapshot:
    """Return the rotation of a joint; its axis is computed from two poses."""
    low, high = angles
    first, span = at(low), min(high - low, 90.0)
    if span > 0.0:
        axis = normalized(_tidy(_rotation_vector(at(low + span), first)))
    else:
        axis = _vector(pair.joint.relative_axis.direction)
    beyond = _small(float(np.dot(axis, _rotation_vector(pair.now(), first))))
    lower, upper = _limits(angles)
    if lower is None:  # the number of full turns is unknown; use the angle closest to 0
        value = math.remainder(math.radians(low) + beyond, math.tau)
    else:
        value = lower + beyond % math.tau
    return MotionSnapshot("rotation", axis, _small(value), lower, upper, role)


def _sliding(pair: _Pair, at: Callable[[float], Transform], role: str = "") -> MotionSnapshot:
    """Return the translation of a joint, from the displacement of the other part on its axis."""
    low, high = (float(limit) for limit in pair.joint.linear_range)
    start, axis = _within(0.0, (low, high)), _vector(pair.joint.relative_axis.direction)
    end = placed(_end(pair.other), pair.unit).p
    moved = np.subtract(pair.now().apply(end), at(start).apply(end))
    value = pair.unit * start + float(np.dot(axis, moved))
    lower, upper = (None if math.isinf(x) else pair.unit * x for x in (low, high))
    return MotionSnapshot("translation", axis, _small(value), lower, upper, role)


def _end(joint: Any) -> Any:
    """Return the pose of a joint in the frame of its part."""
    has_place = hasattr(joint, "relative_location")
    return joint.relative_location if has_place else joint.relative_axis.location


def _limits(angles: tuple[float, float]) -> tuple[float | None, float | None]:
    """Return limits in [rad], or None for both if the joint allows full turns."""
    low, high = angles
    return (None, None) if high - low >= 360.0 else (math.radians(low), math.radians(high))


def _rotation_vector(T: Transform, before: Transform) -> Vector3:
    """Return angle times axis of the rotation from one pose to another."""
    x, y, z = Rotation.from_matrix(np.array(T.R) @ np.array(before.R).T).as_rotvec().tolist()
    return x, y, z


def _vector(v: Any) -> Vector3:
    return float(v.X), float(v.Y), float(v.Z)


def _small(value: float) -> float:
    return 0.0 if abs(value) < _TIDY else value


def _tidy(v: Vector3) -> Vector3:
    x, y, z = v
    return _small(x), _small(y), _small(z)


_KINDS: dict[tuple[str, str], tuple[JointKind, Callable[[_Pair], tuple[MotionSnapshot, ...]]]] = {
    ("RigidJoint", "RigidJoint"): ("rigid", lambda _: ()),
    ("RevoluteJoint", "RigidJoint"): ("revolute", _revolute),
    ("LinearJoint", "RigidJoint"): ("slider", _linear),
    ("LinearJoint", "RevoluteJoint"): ("pin_slot", _slot),
    ("CylindricalJoint", "RigidJoint"): ("cylindrical", _cylindrical),
    ("BallJoint", "RigidJoint"): ("ball", _ball),
}
"""Kind in a snapshot and motions, by the types of the two connected joints."""
