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
        axis: Unit vector, as `two` has it: not carried by the joint's motions before it.
        value: Its current value, in [rad] or [m].
        lower, upper: Limits, in [rad] or [m]; None if not enabled.
        role: What the CAD system calls it where a joint has several: `pitch`, `yaw`, `roll`,
            `rotation`, `slide`, `primary_slide`, `secondary_slide`.
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        friction: Coulomb friction, in [N·m] or [N].
        stiffness: Of a spring, in [N·m/rad] or [N/m].
        rest: Where the spring makes no torque or force, in [rad] or [m].
        effort: Largest torque or force of its motor, in [N·m] or [N]; None if not known.
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


@dataclass(frozen=True, slots=True)
class JointSnapshot:
    """A joint, or as-built joint, between two occurrences.

    Attributes:
        name: Its name.
        kind: Its type.
        one, two: Paths of the occurrences; `one` moves relative to `two`. None if the CAD system
            does not say.
        origin_one, origin_two: Where the joint is as `one` and `two` have it, in [m]; None if
            the CAD system does not say.
        motions: In their order from `two` to `one`.
        as_built: Whether it is an as-built joint.
        suppressed: Whether it is switched off in the timeline.
        locked: Whether it is locked.
        problem: What the CAD system says is wrong with it; empty if nothing.
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
        ratio: Without unit, or in [m/rad] or [rad/m].
        offset: In [rad] or [m].
        follower_role, leader_role: Roles of the motions, of joints that have several.
    """

    follower: str
    leader: str
    ratio: float = 1.0
    offset: float = 0.0
    follower_role: str = ""
    leader_role: str = ""
