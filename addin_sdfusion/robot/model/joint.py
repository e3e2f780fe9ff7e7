"""Joints: sequences of elementary motions and the coordinates that drive them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

from .function import ITSELF, Function, is_constant, value
from .pose import IDENTITY, Pose, Vector3

MotionKind = Literal["rotation", "translation"]
JointType = Literal[
    "fixed", "revolute", "prismatic", "universal", "ball", "planar", "free", "compound"
]

_UNIT: dict[MotionKind, Literal["rad", "m"]] = {"rotation": "rad", "translation": "m"}
_ORTHOGONAL = 1e-9


@dataclass(frozen=True, slots=True)
class Term:
    """A term of a coupling: a function of another coordinate.

    Attributes:
        coordinate: Name of a coordinate of any joint.
        function: Function of that coordinate's value in [rad] or [m].
    """

    coordinate: str
    function: Function = ITSELF


@dataclass(frozen=True, slots=True)
class LimitForce:
    """OpenSim's coordinate limit force, which grows smoothly outside of a range, with damping.

    f = K_low(q) (low - q) - K_high(q) (q - high) - damping (K_low/k_low + K_high/k_high) q'.
    K(q) is the stiffness times a quintic step over the transition outside of the range.

    With an inertia it is a soft limit as in MuJoCo: f also contains - inertia q'', and only pushes
    into the range. Runge-Kutta steps and robots with joint friction use the formula above instead.

    Attributes:
        low, high: The range, in [rad] or [m].
        stiffness_low, stiffness_high: Stiffness k below and above the range, in [N·m/rad] or [N/m].
        damping: In [N·m·s/rad] or [N·s/m].
        transition: Distance outside of the range at which k is fully reached, in [rad] or [m].
        inertia: In [kg·m²] or [kg]; 0 without one.
    """

    low: float
    high: float
    stiffness_low: float
    stiffness_high: float
    damping: float = 0.0
    transition: float = 0.1
    inertia: float = 0.0


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A generalised coordinate q_i, or a coupled or locked coordinate.

    Coupled and locked coordinates are not part of q; the equations of motion eliminate them.

    Attributes:
        name: Name, unique among the coordinates.
        lower, upper: Joint limits (hard stops), in [rad] or [m]; infinite if unlimited.
        initial: Initial value unless an experiment specifies another one, in [rad] or [m].
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        unit: `rad` or `m`.
        actuated: Whether a motor drives the coordinate, in addition to the muscles.
        stiffness: Stiffness of a joint spring, in [N·m/rad] or [N/m]; 0 without a spring.
        rest: Rest position of the spring, in [rad] or [m].
        friction: Coulomb friction torque or force, in [N·m] or [N].
        tau_min, tau_max: Limits of the motor's torque or force, in [N·m] or [N]; infinite if not
            specified. A file can specify them for a joint without a motor.
        armature: Additional inertia that moves with the coordinate, such as a motor's rotor seen
            through its gear, in [kg·m²] or [kg].
        coupling: Terms whose sum is the value of the coordinate; empty if it is not coupled.
        locked: Whether the coordinate is locked at its initial value.
        limit_force: Force outside of a range, or None.
        max_velocity: Maximum velocity, in [rad/s] or [m/s]; infinite if not specified. It is kept
            in files, but not simulated.
    """

    name: str
    lower: float = -math.inf
    upper: float = math.inf
    initial: float = 0.0
    damping: float = 0.0
    unit: Literal["rad", "m"] = "rad"
    actuated: bool = False
    stiffness: float = 0.0
    rest: float = 0.0
    friction: float = 0.0
    tau_min: float = -math.inf
    tau_max: float = math.inf
    armature: float = 0.0
    coupling: tuple[Term, ...] = ()
    locked: bool = False
    limit_force: LimitForce | None = None
    max_velocity: float = math.inf

    @property
    def is_free(self) -> bool:
        """Whether the coordinate is part of q."""
        return not (self.coupling or self.locked)

    @property
    def is_limited(self) -> bool:
        """Whether the coordinate has a lower or an upper limit."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)

    def range(self, wide: float) -> tuple[float, float]:
        """Return the limits; a missing one is `wide` away from the initial value."""
        lower = self.lower if math.isfinite(self.lower) else min(self.initial, self.upper) - wide
        upper = self.upper if math.isfinite(self.upper) else max(self.initial, lower) + wide
        return lower, upper


@dataclass(frozen=True, slots=True)
class Motion:
    """A rotation about an axis, or a translation along it.

    Attributes:
        kind: `rotation` or `translation`.
        axis: Unit vector in the frame after the joint's preceding motions.
        coordinate: Index of the driving coordinate in the joint; unused if the function is
            constant.
        function: Angle in [rad] or displacement in [m] as a function of the coordinate's value.
    """

    kind: MotionKind
    axis: Vector3
    coordinate: int = 0
    function: Function = ITSELF

    @property
    def unit(self) -> Literal["rad", "m"]:
        """Unit of the angle or displacement."""
        return _UNIT[self.kind]

    @property
    def is_fixed(self) -> bool:
        """Whether the motion is constant."""
        return is_constant(self.function)

    def displacement(self, coordinate: float) -> float:
        """Return the angle in [rad] or displacement in [m] at a value of the coordinate."""
        return coordinate if self.function == ITSELF else value(self.function, coordinate)


def revolute(axis: Vector3) -> tuple[Motion, ...]:
    """Return the motion of a revolute joint: a rotation about a unit vector in the joint frame."""
    return (Motion("rotation", axis),)


def prismatic(axis: Vector3) -> tuple[Motion, ...]:
    """Return the motion of a prismatic joint: a translation along a unit vector in its frame."""
    return (Motion("translation", axis),)


@dataclass(frozen=True, slots=True)
class Joint:
    """A connection between a parent and a child link.

    The child's pose in the parent is
    T_parent_child = T_parent_joint · motion_1(q) · motion_2(q) · ... · T_child_joint⁻¹.

    Attributes:
        name: Name, unique among the joints.
        parent: The parent link, or `WORLD`.
        child: The child link.
        motions: Motions in order from parent to child; empty for a fixed joint.
        coordinates: Coordinates that drive the motions, in the order of q; usually one per motion.
        T_parent_joint: Pose of the joint frame in the parent link's frame.
        T_child_joint: Pose of the frame after the motions in the child link's frame.
    """

    name: str
    parent: str
    child: str
    motions: tuple[Motion, ...] = ()
    coordinates: tuple[Coordinate, ...] = ()
    T_parent_joint: Pose = IDENTITY
    T_child_joint: Pose = IDENTITY

    def map_coordinates(self, change: Callable[[Coordinate], Coordinate]) -> Joint:
        """Return the joint with changed coordinates."""
        return replace(self, coordinates=tuple(map(change, self.coordinates)))

    @property
    def type(self) -> JointType:
        """Type of the joint, see `joint_type`; `compound` if it has functions or couplings."""
        return joint_type(self.motions) if self.is_plain else "compound"

    def main_motion(self, coordinate: int) -> int:
        """Return the index of a coordinate's main motion: the first one with the same unit.

        If no motion has the same unit, return the first one that the coordinate drives.

        Args:
            coordinate: Index of a coordinate that drives at least one motion.
        """
        moved = [
            (motion.unit != self.coordinates[coordinate].unit, index)
            for index, motion in enumerate(self.motions)
            if motion.coordinate == coordinate and not motion.is_fixed
        ]
        return min(moved)[1]

    @property
    def is_plain(self) -> bool:
        """Whether each motion equals a separate free coordinate."""
        return (
            all(motion.function == ITSELF for motion in self.motions)
            and all(coordinate.is_free for coordinate in self.coordinates)
            and len({motion.coordinate for motion in self.motions}) == len(self.motions)
        )


def joint_type(motions: tuple[Motion, ...]) -> JointType:
    """Return the type of a joint with these motions.

    `universal` has two rotations about orthogonal axes. `ball` has three rotations, each axis
    orthogonal to the preceding one. `planar` has two translations and a rotation about their
    normal. `free` has three translations, then a ball. `compound` is any other sequence.
    """
    pattern = "".join(motion.kind[0] for motion in motions)
    if pattern in ("", "r", "t"):
        names: dict[str, JointType] = {"": "fixed", "r": "revolute", "t": "prismatic"}
        return names[pattern]
    if pattern in ("rr", "rrr") and _orthogonal(motions):
        return "universal" if pattern == "rr" else "ball"
    if pattern == "ttr" and _orthogonal(motions) and _orthogonal((motions[0], motions[2])):
        return "planar"
    if pattern == "tttrrr" and _orthogonal(motions[:3]) and _orthogonal(motions[3:]):
        return "free"
    return "compound"


def _orthogonal(motions: tuple[Motion, ...]) -> bool:
    """Return whether each axis is orthogonal to the preceding one."""
    return all(
        abs(sum(a * b for a, b in zip(first.axis, second.axis, strict=True))) <= _ORTHOGONAL
        for first, second in pairwise(motions)
    )
