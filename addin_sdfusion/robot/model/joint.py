"""Joints: elementary motions one after another, and the coordinates that drive them."""

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
        coordinate: Its name; of any joint.
        function: Of that coordinate's value, in [rad] or [m].
    """

    coordinate: str
    function: Function = ITSELF


@dataclass(frozen=True, slots=True)
class LimitForce:
    """A force that grows smoothly beyond a range, with damping there: OpenSim's.

    f = K_low(q) (low - q) - K_high(q) (q - high) - damping (K_low/k_low + K_high/k_high) q',
    K(q) the stiffness times a quintic step over the transition beyond that end of the range.

    Attributes:
        low, high: The range, in [rad] or [m].
        stiffness_low, stiffness_high: k beyond each end, in [N·m/rad] or [N/m].
        damping: In [N·m·s/rad] or [N·s/m].
        transition: How far beyond an end the stiffness is whole, in [rad] or [m].
    """

    low: float
    high: float
    stiffness_low: float
    stiffness_high: float
    damping: float = 0.0
    transition: float = 0.1


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One generalised coordinate q_i, or one that follows others, or stands still.

    What is coupled or locked is none of the robot's coordinates q: it is eliminated exactly.

    Attributes:
        name: Its name, unique among the coordinates.
        lower, upper: Limits, in [rad] or [m]; infinite if unlimited.
        initial: The value at the start unless an experiment says otherwise, in [rad] or [m].
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        unit: `rad` or `m`.
        actuated: Whether a motor of its own drives it, next to the muscles.
        stiffness: Of a spring in the joint, in [N·m/rad] or [N/m]; 0 for none.
        rest: Where the spring makes no torque, in [rad] or [m].
        friction: Coulomb friction: the torque or force that holds it at rest, and that slows it
            when it moves, in [N·m] or [N].
        tau_min, tau_max: Bounds of its motor's torque or force, in [N·m] or [N]; infinite if
            there is none. A file may give them for a joint without a motor.
        armature: Inertia of what turns with it besides the links, as a motor's rotor behind its
            gear, in [kg·m²] or [kg].
        coupling: Its value is the sum of these terms; empty if it moves freely.
        locked: Whether it is held at its initial value.
        limit_force: A force beyond a range, None for none. The limits are hard stops.
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

    @property
    def is_free(self) -> bool:
        """Whether it is one of q."""
        return not (self.coupling or self.locked)


def renamed(coordinate: Coordinate, named: Callable[[str], str]) -> Coordinate:
    """Return the coordinate under another name, and what it follows as well.

    Args:
        coordinate: The coordinate.
        named: The new name of each old one.
    """
    coupling = tuple(replace(t, coordinate=named(t.coordinate)) for t in coordinate.coupling)
    return replace(coordinate, name=named(coordinate.name), coupling=coupling)


@dataclass(frozen=True, slots=True)
class Motion:
    """A rotation about an axis, or a translation along it.

    Attributes:
        kind: `rotation` or `translation`.
        axis: Unit vector in the frame that the joint's motions before this one have led to.
        coordinate: Index of the coordinate that drives it, among those of the joint; of no meaning
            where the function is constant.
        function: The angle in [rad], or the way in [m], of the coordinate's value.
    """

    kind: MotionKind
    axis: Vector3
    coordinate: int = 0
    function: Function = ITSELF

    @property
    def unit(self) -> Literal["rad", "m"]:
        """Unit of the angle or the way."""
        return _UNIT[self.kind]

    @property
    def is_fixed(self) -> bool:
        """Whether it stands still, as its function is constant."""
        return is_constant(self.function)

    def way(self, coordinate: float) -> float:
        """How far it goes at a value of its coordinate, in [rad] or [m]."""
        return coordinate if self.function == ITSELF else value(self.function, coordinate)


def revolute(axis: Vector3) -> tuple[Motion, ...]:
    """Return the motion of a revolute joint: a rotation about a unit vector in the joint frame."""
    return (Motion("rotation", axis),)


def prismatic(axis: Vector3) -> tuple[Motion, ...]:
    """The motion of a prismatic joint: a translation along a unit vector in the joint frame."""
    return (Motion("translation", axis),)


@dataclass(frozen=True, slots=True)
class Joint:
    """A connection between a parent and a child link.

    The child's pose in the parent is
    T_parent_child = T_parent_joint · motion_1(q) · motion_2(q) · ... · T_child_joint⁻¹.

    Attributes:
        name: Its name, unique among the joints.
        parent: The parent link, or `WORLD`.
        child: The child link.
        motions: The motions in their order from the parent to the child; none for a fixed joint.
        coordinates: What drives the motions, in the order of q; as a rule one each.
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

    @property
    def type(self) -> JointType:
        """What the field calls a joint with these motions."""
        return joint_type(self.motions) if self.is_plain else "compound"

    def home(self, coordinate: int) -> int:
        """Return the motion that is a coordinate's own, or nearest to it: the first in its unit.

        Args:
            coordinate: Index of one that moves something.
        """
        moved = [
            (motion.unit != self.coordinates[coordinate].unit, place)
            for place, motion in enumerate(self.motions)
            if motion.coordinate == coordinate and not motion.is_fixed
        ]
        return min(moved)[1]

    @property
    def is_plain(self) -> bool:
        """Whether each motion is a free coordinate of its own."""
        return (
            all(motion.function == ITSELF for motion in self.motions)
            and all(coordinate.is_free for coordinate in self.coordinates)
            and len({motion.coordinate for motion in self.motions}) == len(self.motions)
        )


def joint_type(motions: tuple[Motion, ...]) -> JointType:
    """What the field calls a joint.

    `universal` is two rotations about orthogonal axes, `ball` three, each orthogonal to the one
    before, `planar` two translations and a rotation about their normal, `free` three translations
    and then a ball; `compound` is any other sequence.
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
    """Return whether each axis is orthogonal to the one before."""
    return all(
        abs(sum(a * b for a, b in zip(first.axis, second.axis, strict=True))) <= _ORTHOGONAL
        for first, second in pairwise(motions)
    )
