"""Robot with every kind of joint, for tests of writers."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
)
from addin_sdfusion.robot.formats.caspr.joints import CASPR_JOINTS

from .wrapped import vector


def every_joint(muscles: int = 4) -> Robot:
    """Return a chain with every CASPR joint in rotated frames, and muscles along it."""
    rng = np.random.default_rng(3)
    links, joints = [], []
    for k, (word, joint) in enumerate(CASPR_JOINTS.items()):
        units = [m.unit for m in sorted(joint.motions, key=lambda m: m.coordinate)]
        links.append(Link(word, Inertia(1.0 + k, (0.1, 0.2, -0.1), 0.5, 0.6, 0.7, 0.1)))
        joints.append(
            Joint(
                f"to {word}",
                WORLD if k == 0 else links[k - 1].name,
                word,
                joint.motions,
                tuple(Coordinate(f"{word}{i}", unit=u) for i, u in enumerate(units)),
                Pose((0.1, 0.0, 0.2), (0.3, -0.2, 0.1 * k)),
                Pose((0.0, 0.1, 0.0), (0.1 * k, 0.2, 0.3)),
            )
        )
    on = [WORLD, *CASPR_JOINTS]
    cables = tuple(
        Muscle(
            f"muscle {m}",
            tuple(ViaPoint(str(rng.choice(on)), vector(rng)) for _ in range(4)),
            1.0,
            50.0,
        )
        for m in range(muscles)
    )
    return Robot("every joint", tuple(links), tuple(joints), (CableSet("all", cables),), "all")
