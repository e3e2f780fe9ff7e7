"""Robots for tests, of known shape."""

from __future__ import annotations

import math
from pathlib import Path

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
    TaskFrame,
    TaskSet,
    ViaPoint,
    read_robot,
    revolute,
)
from addin_sdfusion.robot import prismatic as prismatic_

EXAMPLES = Path(__file__).parents[3] / "examples"
PLANAR_2R = EXAMPLES / "planar_2r"


def planar_2r(cable_set: str | None = None) -> Robot:
    """The paper's two-link arm, from the example's files."""
    return read_robot(PLANAR_2R / "robot", cable_set)


def random_robot(
    seed: int, joints: int = 6, muscles: int = 8, points: int = 4, *, prismatic: bool = True
) -> Robot:
    """A random tree with branches, rotated frames, fixed joints and muscles all over it."""
    rng = np.random.default_rng(seed)
    links, chain, movable = [], [], [WORLD]
    for k in range(joints + joints // 3):
        fixed = k >= joints
        parent = str(rng.choice(movable[-4:]))
        kind = prismatic_(_unit(rng)) if prismatic and rng.random() < 0.3 else revolute(_unit(rng))
        links.append(Link(f"link_{k}", _inertia(rng)))
        chain.append(
            Joint(
                f"joint_{k}",
                parent,
                f"link_{k}",
                () if fixed else kind,
                () if fixed else (Coordinate(f"joint_{k}", unit=kind[0].unit),),
                T_parent_joint=_pose(rng),
                T_child_joint=_pose(rng),
            )
        )
        movable.append(f"link_{k}")
    names = [WORLD, *(link.name for link in links)]
    cables = tuple(
        Muscle(
            f"muscle_{k}",
            tuple(ViaPoint(str(rng.choice(names)), _vector(rng)) for _ in range(points)),
            5.0,
            200.0,
        )
        for k in range(muscles)
    )
    tasks = (
        TaskFrame("hand", links[joints - 1].name, _vector(rng)),
        TaskFrame("elbow", links[joints // 2].name, _vector(rng), ("z", "x")),
        TaskFrame("palm", links[joints - 1].name, axes=("alpha", "gamma", "beta")),
    )
    return Robot(
        f"random_{seed}",
        tuple(links),
        tuple(chain),
        (CableSet("all", cables),),
        "all",
        (TaskSet("both", tasks),),
        "both",
    )


def chain(joints: int = 20, muscles: int = 60, points: int = 4) -> Robot:
    """A hanging chain of revolute joints about alternating axes, muscles over four links each."""
    rng = np.random.default_rng(7)
    links = tuple(
        Link(f"link_{k}", Inertia(0.5, (0.0, 0.0, -0.05), 1e-3, 1e-3, 5e-4)) for k in range(joints)
    )
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    tree = tuple(
        Joint(
            f"joint_{k}",
            WORLD if k == 0 else f"link_{k - 1}",
            f"link_{k}",
            revolute(axes[k % 2]),
            (Coordinate(f"joint_{k}", damping=0.05),),
            Pose((0.0, 0.0, 0.0 if k == 0 else -0.1)),
        )
        for k in range(joints)
    )
    cables = []
    for k in range(muscles):
        first = int(rng.integers(-1, joints - points + 1))
        angle = 2 * math.pi * k / muscles
        offset = (0.03 * math.cos(angle), 0.03 * math.sin(angle))
        over = [WORLD if b < 0 else f"link_{b}" for b in range(first, first + points)]
        cables.append(
            Muscle(f"muscle_{k}", tuple(ViaPoint(b, (*offset, -0.05)) for b in over), 1.0, 100.0)
        )
    return Robot("chain", links, tree, (CableSet("all", tuple(cables)),), "all")


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
    a, b, c = rng.uniform(0.01, 0.1, 3)
    return Inertia(
        float(rng.uniform(0.2, 2.0)), _vector(rng, 0.2), float(b + c), float(a + c), float(a + b)
    )
