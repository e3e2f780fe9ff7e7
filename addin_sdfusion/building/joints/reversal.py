"""Reversal of coordinates: the user chooses the positive direction of a joint."""

from __future__ import annotations

from dataclasses import replace

from ...snapshot import (
    CouplingSnapshot,
    DesignSnapshot,
    JointSnapshot,
    MotionSnapshot,
    bare_name,
)
from .checks import coordinate_name
from .couplings import coupled_name


def reverse_coordinates(snapshot: DesignSnapshot) -> DesignSnapshot:
    """Return the design with the coordinates that its settings reverse.

    The motion of the parts is unchanged: axis, value, limits and couplings change their signs.
    """
    names = {chosen.joint for chosen in snapshot.settings.of_joints if chosen.reversed}
    if not names:
        return snapshot
    return replace(
        snapshot,
        joints=tuple(_joint(joint, names) for joint in snapshot.joints),
        couplings=tuple(_coupling(coupling, names) for coupling in snapshot.couplings),
    )


def _joint(joint: JointSnapshot, names: set[str]) -> JointSnapshot:
    name, count = bare_name(joint.name), len(joint.motions)
    motions = (
        _reversed(m) if coordinate_name(name, m, count) in names else m for m in joint.motions
    )
    return replace(joint, motions=tuple(motions))


def _reversed(motion: MotionSnapshot) -> MotionSnapshot:
    x, y, z = motion.axis
    return replace(
        motion,
        axis=(0.0 - x, 0.0 - y, 0.0 - z),
        value=0.0 - motion.value,
        lower=None if motion.upper is None else 0.0 - motion.upper,
        upper=None if motion.lower is None else 0.0 - motion.lower,
        rest=0.0 - motion.rest,
    )


def _coupling(c: CouplingSnapshot, names: set[str]) -> CouplingSnapshot:
    follower, leader = (
        -1.0 if coupled_name(joint, role) in names else 1.0
        for joint, role in ((c.follower, c.follower_role), (c.leader, c.leader_role))
    )
    return replace(c, ratio=follower * leader * c.ratio, offset=follower * c.offset + 0.0)
