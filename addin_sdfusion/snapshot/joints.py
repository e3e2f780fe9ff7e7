"""Joints of a design, and couplings between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..robot.model.pose import Vector3

JointKind = Literal[
    "rigid", "revolute", "slider", "cylindrical", "pin_slot", "planar", "ball", "inferred"
]


@dataclass(frozen=True, slots=True)
class MotionSnapshot:
    """One degree of freedom of a joint.

    Attributes:
        kind: `rotation` or `translation`, of `one` relative to `two`.
        axis: Unit vector fixed to `two`: the preceding motions of the joint do not move it.
        value: Current value, in [rad] or [m].
        lower, upper: Limits, in [rad] or [m]; None if not enabled.
        role: Name of the motion in the CAD system if a joint has several: `pitch`, `yaw`, `roll`,
            `rotation`, `slide`, `primary_slide`, `secondary_slide`.
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        friction: Coulomb friction, in [N·m] or [N].
        stiffness: Spring stiffness, in [N·m/rad] or [N/m].
        rest: Value at which the spring is relaxed, in [rad] or [m].
        effort: Maximum torque or force of the motor, in [N·m] or [N]; None if unknown.
        velocity: Maximum velocity, in [rad/s] or [m/s]; None if unknown.
    """

    kind: Literal["rotation", "translation"]
    axis: Vector3
    value: float = 0.0
    lower: float | None = None
    upper: float | None = None
    role: str = ""
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    effort: float | None = None
    velocity: float | None = None


@dataclass(frozen=True, slots=True)
class JointSnapshot:
    """A joint, or as-built joint, between two occurrences.

    Attributes:
        name: Name of the joint.
        kind: Type of the joint.
        one, two: Paths of the occurrences; `one` moves relative to `two`. None if unknown.
        origin_one, origin_two: Position of the joint on `one` and on `two`, in [m]; None if
            unknown.
        motions: Motions, ordered from `two` to `one`.
        as_built: Whether it is an as-built joint.
        suppressed: Whether it is suppressed in the timeline.
        locked: Whether it is locked.
        problem: Error that the CAD system reports for the joint; empty if it reports no error.
    """

    name: str
    kind: JointKind
    one: str | None
    two: str | None
    origin_one: Vector3 | None = None
    origin_two: Vector3 | None = None
    motions: tuple[MotionSnapshot, ...] = ()
    as_built: bool = False
    suppressed: bool = False
    locked: bool = False
    problem: str = ""


@dataclass(frozen=True, slots=True)
class CouplingSnapshot:
    """A motion that follows another one: follower = ratio · leader + offset.

    Attributes:
        follower, leader: Names of the joints.
        ratio: Dimensionless, or in [m/rad] or [rad/m].
        offset: In [rad] or [m].
        follower_role, leader_role: Roles of the motions, for joints with several motions.
    """

    follower: str
    leader: str
    ratio: float = 1.0
    offset: float = 0.0
    follower_role: str = ""
    leader_role: str = ""
