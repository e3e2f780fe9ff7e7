"""Parts of designs."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..build import Builder, Path
from ..maths import inverse, rotation, translation


def random_motion(order: random.Random, reach: float = 30.0) -> np.ndarray:
    """Return a random rigid motion with uniformly distributed rotation; translation in [cm]."""
    q = np.array([order.gauss(0.0, 1.0) for _ in range(4)])
    angle = 2.0 * np.arctan2(np.linalg.norm(q[1:]), q[0])
    T = rotation(angle, q[1:])
    T[:3, 3] = [order.uniform(-reach, reach) for _ in range(3)]
    return T


def nested_place(
    build: Builder,
    name: str,
    T_root: Any,
    order: random.Random | None = None,
    depth: int = 0,
    **more: Any,
) -> Path:
    """Place a new component at a pose in the root frame, below `depth` random components."""
    above: Path = ()
    T_above = np.eye(4)
    for k in range(depth):
        T = random_motion(order or random.Random(k))
        above = build.place(f"{name} holder {k}", T, above=above)
        T_above = T_above @ T
    return build.place(name, inverse(T_above) @ np.asarray(T_root), above=above, **more)


def chain(
    build: Builder,
    names: Sequence[str] = ("base", "upper", "lower"),
    *,
    joints: Sequence[str] = (),
    groups: bool = True,
    length: float = 10.0,
    limits: tuple[float | None, float | None] = (-1.0, 1.5),
    as_built: bool = False,
    by_origins: bool = False,
) -> list[Path]:
    """Draw a chain of boxes along z, connected by revolute joints about y.

    Args:
        build: Builder of the design.
        names: Names of components and links; the first one is grounded.
        joints: Names of the joints (default: `<link>_joint`).
        groups: Whether the links are rigid groups.
        length: Length of a link, in [cm]; the component origin is at its lower end.
        limits: Limits of the joints, in [rad].
        as_built: Whether the joints are as-built.
        by_origins: Whether joint origins define the joints.
    """
    paths = []
    for i, name in enumerate(names):
        path = build.place(name, translation((0.0, 0.0, i * length)), grounded=i == 0)
        build.box(path, (2.0, 3.0, length), translation((0.0, 0.0, length / 2.0)))
        paths.append(path)
    for i in range(1, len(names)):
        build.joint(
            joints[i - 1] if joints else f"{names[i]}_joint",
            "revolute",
            paths[i],
            paths[i - 1],
            (0.0, 0.0, i * length),
            (0.0, 1.0, 0.0),
            (1.0, 0.0, 0.0),
            limits=(limits,),
            as_built=as_built,
            by_origins=by_origins,
        )
    if groups:
        for name, path in zip(names, paths, strict=True):
            build.rigid_group(f"EXPORT_{name}", [path])
    return paths


def muscle(
    build: Builder,
    number: int,
    links: Sequence[tuple[str, Path]],
    side: float = 1.0,
) -> None:
    """Draw a muscle by old names: one via point per link, at the centre of a face of its box."""
    for k, (link, path) in enumerate(links):
        build.point(path, (side, 0.0, 5.0), f"VP_motor{number}_EXPORT_{link}_{k}")
