"""Mechanisms with closed loops."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from support.oracles.loop_model import link_poses, pose_matrix, rotation

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    LoopJoint,
    Muscle,
    Pose,
    Robot,
    TaskFrame,
    TaskSet,
    Vector3,
    ViaPoint,
    check,
    prismatic,
    revolute,
)
from addin_sdfusion.robot.model.loop import AXES, LOOP_TYPES, LoopType
from addin_sdfusion.robot.model.rotations import rpy

from .random_robots import random_state, random_tree
from .wrapped import vector

Y = (0.0, 1.0, 0.0)


def bar(name: str, length: float) -> Link:
    """Return a rod along x from the origin of its frame, with 1 kg/m."""
    mass = length
    across = mass * length**2 / 12.0
    return Link(name, Inertia(mass, (0.5 * length, 0.0, 0.0), 1e-6, across, across))


def hinge(name: str, parent: str, child: str, x: float, initial: float = 0.0) -> Joint:
    """Return a hinge about y at a position on the x axis of the parent."""
    coordinate = Coordinate(name, initial=initial)
    return Joint(name, parent, child, revolute(Y), (coordinate,), Pose((x, 0.0, 0.0)))


def four_bar(
    lengths: tuple[float, float, float, float] = (0.2, 0.5, 0.4, 0.5), crank: float = 1.0
) -> Robot:
    """Return a planar four-bar linkage of crank, coupler, rocker and ground, initially closed.

    Angles are negative rotations about y, so that positive angles lift the bars.

    Args:
        lengths: Lengths of crank, coupler, rocker and ground, in [m].
        crank: Initial angle of the crank above the ground, in [rad].
    """
    a, b, c, d = lengths
    coupler, rocker = four_bar_angles(lengths, crank)
    joints = (
        hinge("crank", WORLD, "crank_bar", 0.0, -crank),
        hinge("coupler", "crank_bar", "coupler_bar", a, -(coupler - crank)),
        hinge("rocker", WORLD, "rocker_bar", d, -rocker),
    )
    links = (bar("crank_bar", a), bar("coupler_bar", b), bar("rocker_bar", c))
    loop = LoopJoint(
        "closing", "coupler_bar", "rocker_bar", "revolute", (Y,), Pose((b, 0, 0)), Pose((c, 0, 0))
    )
    muscles = tuple(
        Muscle(f"cable_{k}", (ViaPoint(WORLD, (x, 0.0, -0.3)), ViaPoint(link, (0.1, 0.0, 0.0))))
        for k, (x, link) in enumerate([(-0.1, "crank_bar"), (0.6, "rocker_bar")])
    )
    return Robot("four_bar", links, joints, (CableSet("all", muscles),), "all", loops=(loop,))


def four_bar_angles(
    lengths: tuple[float, float, float, float], crank: float
) -> tuple[float, float]:
    """Return the angles of coupler and rocker above the ground on the open branch, in [rad]."""
    a, b, c, d = lengths
    x, z = d - a * math.cos(crank), -a * math.sin(crank)
    r, towards = math.hypot(x, z), math.atan2(z, x)
    coupler = towards + math.acos((r * r + b * b - c * c) / (2.0 * r * b))
    rocker = math.atan2(
        a * math.sin(crank) + b * math.sin(coupler), a * math.cos(crank) + b * math.cos(coupler) - d
    )
    return coupler, rocker


def slider_crank(crank: float = 0.2, rod: float = 0.5, angle: float = 1.0) -> Robot:
    """Return a crank, a rod and a slider along x; a hinge connects rod and slider."""
    swing = math.asin(crank * math.sin(angle) / rod)
    place = crank * math.cos(angle) + rod * math.cos(swing)
    slide = Coordinate("slide", initial=place, unit="m")
    joints = (
        hinge("crank", WORLD, "crank_bar", 0.0, -angle),
        hinge("rod", "crank_bar", "rod_bar", crank, swing + angle),
        Joint("slide", WORLD, "slider", prismatic((1.0, 0.0, 0.0)), (slide,)),
    )
    block = Link("slider", Inertia(0.3, ixx=1e-4, iyy=1e-4, izz=1e-4))
    links = (bar("crank_bar", crank), bar("rod_bar", rod), block)
    loop = LoopJoint("pin", "rod_bar", "slider", "revolute", (Y,), Pose((rod, 0.0, 0.0)))
    return Robot("slider_crank", links, joints, loops=(loop,))


def five_bar() -> Robot:
    """Return two cranks and two connected bars, with four cables at the tip.

    Two of its four coordinates depend on the others.
    """
    apart, crank, rod = 0.3, 0.25, 0.3
    lean = 2.0  # angle of the left crank above x; the right crank is its mirror image
    tip_x = 0.5 * apart
    end = crank * np.array([math.cos(lean), math.sin(lean)])
    up = math.sqrt(rod**2 - (tip_x - end[0]) ** 2)
    left = math.atan2(up, tip_x - end[0])
    joints = (
        hinge("crank_1", WORLD, "crank_bar_1", 0.0, -lean),
        hinge("rod_1", "crank_bar_1", "rod_bar_1", crank, lean - left),
        hinge("crank_2", WORLD, "crank_bar_2", apart, -(math.pi - lean)),
        hinge("rod_2", "crank_bar_2", "rod_bar_2", crank, left - lean),
    )
    links = tuple(
        bar(f"{kind}_{k}", length)
        for k in (1, 2)
        for kind, length in (("crank_bar", crank), ("rod_bar", rod))
    )
    tip = (rod, 0.0, 0.0)
    meeting = Pose(tip)
    loop = LoopJoint("tip", "rod_bar_1", "rod_bar_2", "revolute", (Y,), meeting, meeting)
    corners = [(-0.5, 0.0), (0.8, 0.0), (-0.5, 0.9), (0.8, 0.9)]
    muscles = tuple(
        Muscle(
            f"cable_{k}", (ViaPoint(WORLD, (x, 0.0, z)), ViaPoint("rod_bar_1", tip)), f_max=500.0
        )
        for k, (x, z) in enumerate(corners)
    )
    frame = TaskFrame("tip_point", "rod_bar_1", tip, axes=("x", "z"))
    return Robot(
        "five_bar",
        links,
        joints,
        (CableSet("all", muscles),),
        "all",
        (TaskSet("tip", (frame,)),),
        "tip",
        loops=(loop,),
    )


def with_loop(robot: Robot, **changes: object) -> Robot:
    """Return the robot with changed fields of its only loop joint."""
    return replace(robot, loops=(replace(robot.loops[0], **changes),))  # type: ignore[arg-type]


def random_loops(
    seed: int, kinds: Sequence[LoopType] = LOOP_TYPES
) -> tuple[Robot, NDArray[np.float64]]:
    """Return a random tree with up to three loops of given types, and a pose that closes them."""
    rng = np.random.default_rng(seed)
    while True:
        tree = random_tree(int(rng.integers(1_000_000)))
        q = random_state(tree, rng)[0]
        poses = {name: T.real for name, T in link_poses(tree, q.astype(complex)).items()}
        loops = []
        for k in range(int(rng.integers(1, 4))):
            parent, child = (str(name) for name in rng.choice(list(poses), 2, replace=False))
            if child == WORLD:
                parent, child = child, parent
            kind = kinds[rng.integers(len(kinds))]
            loops.append(_closed_loop(rng, f"loop_{k}", kind, parent, child, poses))
        robot = replace(tree, loops=tuple(loops))
        if not any(finding.is_error for finding in check(robot)):
            return robot, q


def closed_chain(kind: LoopType, seed: int = 0) -> tuple[Robot, NDArray[np.float64]]:
    """Return a chain of seven bars whose end is connected to the world, and a closed pose."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, 7)
    joints, links = [], []
    for k in range(7):
        a, *_ = np.linalg.qr(rng.normal(size=(3, 3)))[0].T
        parent = f"link_{k - 1}" if k else WORLD
        at = Pose(vector(rng, 0.3), vector(rng))
        joints.append(
            Joint(
                f"q{k}",
                parent,
                f"link_{k}",
                revolute(_three(a)),
                (Coordinate(f"q{k}", initial=float(q[k])),),
                at,
            )
        )
        body = bar(f"link_{k}", float(rng.uniform(0.2, 0.4)))
        links.append(replace(body, inertia=replace(body.inertia, ixx=1e-3)))
    robot = Robot("chain", tuple(links), tuple(joints))
    poses = {name: T.real for name, T in link_poses(robot, q.astype(complex)).items()}
    loop = _closed_loop(rng, "closing", kind, WORLD, "link_6", poses)
    return replace(robot, loops=(loop,)), q


def _closed_loop(
    rng: np.random.Generator,
    name: str,
    kind: LoopType,
    parent: str,
    child: str,
    poses: dict[str, NDArray[np.float64]],
) -> LoopJoint:
    """Return a loop joint at random values of its free motions."""
    a, b, c = np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    way, turn = rng.normal(size=3), rng.uniform(-1.5, 1.5, 3)
    free = np.eye(4)
    if kind in ("revolute", "cylindrical", "planar", "universal", "ball"):
        free[:3, :3] = rotation(a, turn[0])
    if kind in ("universal", "ball"):
        free[:3, :3] = free[:3, :3] @ rotation(b, turn[1])
    if kind == "ball":
        free[:3, :3] = free[:3, :3] @ rotation(c, turn[2])
    if kind in ("prismatic", "cylindrical"):
        free[:3, 3] = way[0] * a
    if kind == "planar":
        free[:3, 3] = way[1] * b + way[2] * c
    on_parent = Pose(vector(rng), vector(rng))
    T = np.linalg.inv(poses[child]) @ poses[parent] @ pose_matrix(on_parent) @ free
    x, y, z = (_three(row) for row in T[:3, :3])
    on_child = Pose(_three(T[:3, 3]), rpy((x, y, z)))
    axes = (_three(a), _three(b))[: AXES[kind]]
    return LoopJoint(name, parent, child, kind, axes, on_parent, on_child)


def _three(values: NDArray[np.float64]) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
