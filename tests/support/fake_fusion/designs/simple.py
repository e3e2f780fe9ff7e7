"""Simple designs: a cube, shoulders, one joint of every type, and a large design."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..build import Builder, Path
from ..maths import frame, inverse, rotation, translation
from .parts import nested_place, random_motion


def single_cube(size: float = 1.0, density: float = 1e-3) -> Any:
    """A cube in the root component without groups and joints; the original could not export it."""
    build = Builder("cube")
    build.box((), (size, size, size), density=density)
    return build.done()


def shoulder_with_gimbal(
    *,
    ball: bool = True,
    values: Sequence[float] = (0.3, -0.4, 0.5),
    seed: int | None = 7,
    groups: bool = True,
) -> Any:
    """A torso and an arm with three rotations between them, with limits, at a nonzero pose.

    The rotations are pitch, yaw, roll about z, x, y of the joint frame, in this order from torso
    to arm. The joint is at (5, 0, 30) cm in the frame of the torso, rotated about x.

    Args:
        ball: Whether to use a ball joint `shoulder`; otherwise revolute joints `shoulder_pitch`,
            `_yaw`, `_roll` through links `gimbal_1`, `gimbal_2` in a nested, rotated assembly.
        values: Values of the three rotations, in [rad].
        seed: Seed of the poses of torso and components; None for poses without rotation.
        groups: Whether the links are rigid groups.
    """
    build = Builder("shoulder")
    order = random.Random(seed)
    T_torso = np.eye(4) if seed is None else random_motion(order)
    torso = build.place("torso", T_torso, grounded=True)
    build.box(torso, (20.0, 10.0, 40.0), translation((0.0, 0.0, 20.0)))
    above = torso[:0]
    T_above = np.eye(4)
    if not ball and seed is not None:
        T_above = random_motion(order)
        above = build.place("shoulder assembly", T_above)
    T_joint = T_torso @ frame((5.0, 0.0, 30.0), (0.0, -0.5, 0.8), (1.0, 0.0, 0.0))
    axes = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    turned = [T_joint @ _gimbal(axes, values, k) for k in range(4)]
    paths = {"torso": torso}
    if not ball:
        for k in (1, 2):
            path = build.place(f"gimbal_{k}", inverse(T_above) @ turned[k], above=above)
            build.sphere(path, 1.0)
            paths[f"gimbal_{k}"] = path
    arm = build.place("arm", inverse(T_above) @ turned[3], above=above)
    build.cylinder(arm, 2.0, 30.0, translation((0.0, 0.0, -15.0)))
    paths["arm"] = arm
    bounds = ((-1.0, 1.2), (-0.9, 0.8), (-0.7, 0.6))
    if ball:
        build.joint("shoulder", "ball", arm, torso, T=T_joint, values=values, limits=bounds)
    else:
        links = list(paths.values())
        for k, name in enumerate(("pitch", "yaw", "roll")):
            build.joint(
                f"shoulder_{name}",
                "revolute",
                links[k + 1],
                links[k],
                T=turned[k],
                axes=(axes[k],),
                values=(values[k],),
                limits=(bounds[k],),
            )
    build.point(torso, (8.0, 0.0, 25.0), "VP_motor0_EXPORT_torso_0")
    build.point(arm, (2.0, 0.0, -10.0), "VP_motor0_EXPORT_arm_1")
    if groups:
        for name, path in paths.items():
            build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()


def _gimbal(axes: Any, values: Sequence[float], count: int) -> np.ndarray:
    """Return the product of the first rotations."""
    T = np.eye(4)
    for axis, value in zip(axes[:count], values[:count], strict=True):
        T = T @ rotation(value, axis)
    return T


def every_joint_type(*, as_built: bool = False, seed: int = 3, displaced: bool = True) -> Any:
    """A base with one child for each joint type except `inferred`, at random poses.

    Args:
        as_built: Whether the joints are as-built.
        seed: Seed of the poses and values.
        displaced: Whether the joint values are nonzero.
    """
    build = Builder("every joint")
    order = random.Random(seed)
    base = build.place("base", random_motion(order), grounded=True)
    build.box(base, (10.0, 10.0, 2.0))
    count = {
        "rigid": 0,
        "revolute": 1,
        "slider": 1,
        "cylindrical": 2,
        "pin_slot": 2,
        "planar": 3,
        "ball": 3,
    }
    links = {"base": base}
    for kind, n in count.items():
        path = nested_place(build, kind, random_motion(order), order, order.randint(0, 2))
        build.cylinder(path, 1.0, 5.0)
        values = [order.uniform(-0.8, 0.8) if displaced else 0.0 for _ in range(n)]
        T = random_motion(order)
        limits = [(v - 0.5, v + 0.25) for v in values]
        build.joint(
            f"{kind}_joint", kind, path, base, T=T, values=values, limits=limits, as_built=as_built
        )
        links[kind] = path
    for name, path in links.items():
        build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()


def many_links(links: int = 200, via_points: int = 400) -> Any:
    """A chain of boxes with muscles by name, for speed tests.

    Args:
        links: Number of links, including the base.
        via_points: Number of via points, two per muscle on consecutive links.
    """
    build = Builder("many links")
    paths: list[Path] = []
    for i in range(links):
        T = translation((0.0, 0.0, 5.0 * i)) @ rotation(0.01 * i, (0.0, 0.0, 1.0))
        path = build.place(f"link_{i}", T, grounded=i == 0)
        build.box(path, (2.0, 2.0, 5.0), translation((0.0, 0.0, 2.5)))
        build.rigid_group(f"EXPORT_link_{i}", [path])
        if i:
            build.joint(
                f"joint_{i}",
                "revolute",
                path,
                paths[-1],
                (0.0, 0.0, 5.0 * i),
                (math.cos(i), math.sin(i), 0.0),
                limits=((-1.0, 1.0),),
            )
        paths.append(path)
    for k in range(via_points):
        muscle, number = divmod(k, 2)
        i = (muscle + number) % links
        place = (1.0, 0.1 * (muscle % 10), 2.0 + number)
        build.point(paths[i], place, f"VP_motor{muscle}_EXPORT_link_{i}_{number}")
    return build.done()
