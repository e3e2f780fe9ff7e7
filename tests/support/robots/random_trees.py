"""Random trees with every kind of joint that a robot may have."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Motion,
    Muscle,
    Pose,
    Robot,
    TaskFrame,
    TaskSet,
    ViaPoint,
    prismatic,
    revolute,
)
from addin_sdfusion.robot.writers.caspr.joints import CASPR_JOINTS

FREE = CASPR_JOINTS["SPATIAL_EULER_XYZ"].motions


def random_tree(seed: int, damping: float = 0.0) -> Robot:
    """A tree of up to seven links: branches, fixed joints, and in a third of all a free base.

    Its task frames are a point, `hand`, and the angles of the link before it, `palm`.

    Args:
        seed: What it is made of.
        damping: Of every coordinate, in [N·m·s/rad] or [N·s/m].
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 8))
    links, joints, names = [], [], [WORLD]
    for k in range(count):
        motions = FREE if k == 0 and seed % 3 == 0 else _motions(rng, k)
        name = f"link_{k}"
        links.append(Link(name, _inertia(rng)))
        joints.append(
            Joint(
                f"joint_{k}",
                str(rng.choice(names[-3:])) if k else WORLD,
                name,
                motions,
                _coordinates(k, motions, damping),
                _pose(rng),
                _pose(rng),
            )
        )
        names.append(name)
    muscles = tuple(
        Muscle(
            f"muscle_{m}",
            tuple(ViaPoint(str(rng.choice(names)), _vector(rng)) for _ in range(3)),
            0.0,
            100.0,
        )
        for m in range(4)
    )
    tasks = (
        TaskFrame("hand", names[-1], _vector(rng)),
        TaskFrame("palm", names[-2] if count > 1 else names[-1], axes=("alpha", "beta", "gamma")),
    )
    return Robot(
        f"tree {seed}",
        tuple(links),
        tuple(joints),
        (CableSet("all", muscles),),
        "all",
        (TaskSet("both", tasks),),
        "both",
    )


def random_state(robot: Robot, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Some q, qd and muscle forces."""
    n, m = len(robot.coordinates), len(robot.muscles)
    return rng.uniform(-1.2, 1.2, n), rng.uniform(-1.0, 1.0, n), rng.uniform(0.0, 100.0, m)


def _motions(rng: np.random.Generator, k: int) -> tuple[Motion, ...]:
    """A joint about an axis of its own, one of CASPR's kinds, or, but for the first, none."""
    kind = rng.random()
    if kind < 0.3:
        return revolute(_unit(rng))
    if kind < 0.4:
        return prismatic(_unit(rng))
    if kind < 0.5 and k > 0:
        return ()
    words = [word for word in CASPR_JOINTS if word != "SPATIAL_EULER_XYZ"]
    return CASPR_JOINTS[str(rng.choice(words))].motions


def _coordinates(k: int, motions: tuple[Motion, ...], damping: float) -> tuple[Coordinate, ...]:
    ordered = sorted(motions, key=lambda motion: motion.coordinate)
    return tuple(
        Coordinate(f"q_{k}_{i}", unit=motion.unit, damping=damping)
        for i, motion in enumerate(ordered)
    )


def _vector(rng: np.random.Generator, size: float = 0.5) -> tuple[float, float, float]:
    x, y, z = rng.uniform(-size, size, 3)
    return float(x), float(y), float(z)


def _unit(rng: np.random.Generator) -> tuple[float, float, float]:
    v = rng.normal(size=3)
    x, y, z = v / np.linalg.norm(v)
    return float(x), float(y), float(z)


def _pose(rng: np.random.Generator) -> Pose:
    return Pose(_vector(rng), _vector(rng, 3.0))


def _inertia(rng: np.random.Generator) -> Inertia:
    """Mass properties that a body can have."""
    a, b, c = (float(x) for x in rng.uniform(0.02, 0.2, 3))
    mass, ab = float(rng.uniform(0.5, 2.0)), float(rng.uniform(-0.01, 0.01))
    return Inertia(mass, _vector(rng, 0.2), b + c, a + c, a + b, ab)
