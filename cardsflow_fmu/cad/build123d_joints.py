"""Joints of build123d as a snapshot has them.

What a joint does is asked of it: `relative_to` gives the place of one part in the other's frame at
any angle and position, from which follow the axis it turns about and, with the parts' places, its
value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Vector3
from addin_sdfusion.robot.model.rotations import normalized
from addin_sdfusion.robot.model.transform import Transform
from addin_sdfusion.snapshot import JointKind, JointSnapshot, MotionSnapshot
from cardsflow_fmu.utils.arrays import FloatArray

from .assembly import Place
from .kernel import transform

_APART = 1e-6  # in [m] and [rad]: parts that are farther from where their joint has them were moved
_TIDY = 1e-12


class _Pair(NamedTuple):
    """A joint and the other one that it is connected to, such that `one` moves relative to `two`.

    Attributes:
        joint: Of `two`.
        other: Of `one`.
        two, one: The parts' places.
        unit: Of length, in [m].
    """

    joint: Any
    other: Any
    two: Place
    one: Place
    unit: float

    def at(self, **values: float) -> Transform:
        """T_two_one at values of the joint, in degrees and units of length."""
        return transform(
            self.joint.relative_to(self.other, **values).wrapped.Transformation(), self.unit
        )

    def now(self) -> Transform:
        """T_two_one as the parts are."""
        return self.two.T.inverse().compose(self.one.T)


def joint_record(
    name: str,
    joint: Any,
    other: Any,
    places: tuple[Place, Place],
    unit: float,
    values: Mapping[str, Any],
) -> JointSnapshot:
    """Return the record of a joint that is connected to another one.

    Args:
        name: What to call it.
        joint: The one whose `connect_to` was called.
        other: The one it was called with.
        places: Of their parts.
        unit: Of length, in [m].
        values: Damping and the like of its motions.

    Raises:
        InputError: It is of a type that is not known, or a part was moved after it was connected.
    """
    pair = _Pair(joint, other, *places, unit)
    types = type(joint).__name__, type(other).__name__
    if types[0] == "RigidJoint" and types[1] != "RigidJoint":  # then the other one says how
        pair, types = _Pair(other, joint, places[1], places[0], unit), (types[1], types[0])
    known = _KINDS.get(types)
    if known is None:
        raise InputError(f"joint {name!r}: {types[0]} to {types[1]} cannot be imported")
    kind, find = known
    motions = find(pair)
    _require_in_place(name, pair, kind, motions)
    placed = tuple(
        replace(motion, axis=_tidy(pair.two.T.rotate(motion.axis)), **values) for motion in motions
    )
    origins = _origin(pair.other, pair.one, unit), _origin(pair.joint, pair.two, unit)
    return JointSnapshot(name, kind, pair.one.path, pair.two.path, *origins, placed)


def _origin(joint: Any, place: Place, unit: float) -> Vector3:
    return place.T.apply(transform(_end(joint).wrapped.Transformation(), unit).p)


def _require_in_place(
    name: str, pair: _Pair, kind: JointKind, motions: tuple[MotionSnapshot, ...]
) -> None:
    """Reject parts that are not where the joint has them, at the values that were found."""
    if kind == "ball":  # any turn is one of its own, and its sides are compared by the export
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
    meant, now = pair.at(**values), pair.now()
    apart = max(float(np.max(np.abs(np.subtract(meant.R, now.R)))), math.dist(meant.p, now.p))
    if apart > _APART:
        what = "its parts are not where it has them; connect them after they were moved"
        raise InputError(f"joint {name!r}: {what}")


def _within(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])


def _none(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    return ()


def _revolute(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    return (_turning(pair, lambda a: pair.at(angle=a), pair.joint.angular_range),)


def _linear(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    return (_sliding(pair, lambda p: pair.at(position=p)),)


def _cylindrical(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Return a rotation, and a slide along the same axis."""
    turn, slide = _both(pair, pair.joint.angular_range)
    return turn, slide


def _slot(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Return a slide, and a rotation where it has led."""
    turn, slide = _both(pair, pair.other.angular_range)
    return slide, turn


def _both(pair: _Pair, angles: tuple[float, float]) -> tuple[MotionSnapshot, MotionSnapshot]:
    place = _within(0.0, pair.joint.linear_range)
    turn = _turning(pair, lambda a: pair.at(position=place, angle=a), angles, "rotation")
    return turn, _sliding(pair, lambda p: pair.at(position=p, angle=angles[0]), "slide")


def _ball(pair: _Pair) -> tuple[MotionSnapshot, ...]:
    """Rotations about x, y and z of the joint, in that order: R = Rx Ry Rz."""
    joint = pair.joint
    L, reference, end = (
        transform(location.wrapped.Transformation(), pair.unit)
        for location in (
            joint.relative_location,
            joint.angle_reference.location,
            pair.other.relative_location,
        )
    )
    R = np.array(L.inverse().compose(pair.now()).compose(end).compose(reference.inverse()).R)
    y = math.asin(max(-1.0, min(1.0, R[0, 2])))
    x, z = math.atan2(-R[1, 2], R[2, 2]), math.atan2(-R[0, 1], R[0, 0])
    motions = []
    for number, (role, value) in enumerate(zip("xyz", (x, y, z), strict=True)):
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
    """Return the rotation of a joint, whose axis is that between two of its poses."""
    low, high = angles
    first, span = np.array(at(low).R), min(high - low, 90.0)
    if span > 0.0:
        axis = normalized(_tidy(_skew(np.array(at(low + span).R) @ first.T)))
    else:
        axis = _vector(pair.joint.relative_axis.direction)
    turned = np.array(pair.now().R) @ first.T
    cosine = (np.trace(turned) - 1.0) / 2.0
    beyond = _small(math.atan2(float(np.dot(axis, _skew(turned))), cosine))
    lower, upper = _limits(angles)
    if lower is None:  # nothing says which of its turns it is in: the nearest to 0
        value = math.remainder(math.radians(low) + beyond, math.tau)
    else:
        value = lower + beyond % math.tau
    return MotionSnapshot("rotation", axis, _small(value), lower, upper, role)


def _sliding(pair: _Pair, at: Callable[[float], Transform], role: str = "") -> MotionSnapshot:
    """Return the slide of a joint, by how far the other side has moved along its axis."""
    low, high = (float(limit) for limit in pair.joint.linear_range)
    start, axis = _within(0.0, (low, high)), _vector(pair.joint.relative_axis.direction)
    end = transform(_end(pair.other).wrapped.Transformation(), pair.unit).p
    moved = np.subtract(pair.now().apply(end), at(start).apply(end))
    value = pair.unit * start + float(np.dot(axis, moved))
    lower, upper = (None if math.isinf(x) else pair.unit * x for x in (low, high))
    return MotionSnapshot("translation", axis, _small(value), lower, upper, role)


def _end(joint: Any) -> Any:
    """Where a joint is in the frame of its part."""
    has_place = hasattr(joint, "relative_location")
    return joint.relative_location if has_place else joint.relative_axis.location


def _limits(angles: tuple[float, float]) -> tuple[float | None, float | None]:
    """In [rad]; none if it can turn all the way round."""
    low, high = angles
    return (None, None) if high - low >= 360.0 else (math.radians(low), math.radians(high))


def _skew(R: FloatArray) -> Vector3:
    """sin(angle) times the axis of a rotation."""
    return (
        float(R[2, 1] - R[1, 2]) / 2.0,
        float(R[0, 2] - R[2, 0]) / 2.0,
        float(R[1, 0] - R[0, 1]) / 2.0,
    )


def _vector(v: Any) -> Vector3:
    return float(v.X), float(v.Y), float(v.Z)


def _small(value: float) -> float:
    return 0.0 if abs(value) < _TIDY else value


def _tidy(v: Vector3) -> Vector3:
    x, y, z = v
    return _small(x), _small(y), _small(z)


_KINDS: dict[tuple[str, str], tuple[JointKind, Callable[[_Pair], tuple[MotionSnapshot, ...]]]] = {
    ("RigidJoint", "RigidJoint"): ("rigid", _none),
    ("RevoluteJoint", "RigidJoint"): ("revolute", _revolute),
    ("LinearJoint", "RigidJoint"): ("slider", _linear),
    ("LinearJoint", "RevoluteJoint"): ("pin_slot", _slot),
    ("CylindricalJoint", "RigidJoint"): ("cylindrical", _cylindrical),
    ("BallJoint", "RigidJoint"): ("ball", _ball),
}
"""Types of the joint and the other one: what a snapshot calls it, and its motions."""
