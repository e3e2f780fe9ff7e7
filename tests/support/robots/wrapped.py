"""Robots of known or random shape with wrapped muscles."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Muscle,
    Pose,
    Robot,
    Vector3,
    ViaPoint,
    Wrap,
    WrapSurface,
    prismatic,
    revolute,
)

SOLID = Inertia(1.0, (0.0, 0.0, 0.0), 0.1, 0.1, 0.1)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FAR = "link_2"
"""Link with three coordinates along x, y and z."""


def carriage(muscles: list[Muscle], surfaces: list[WrapSurface], *, turning: bool = False) -> Robot:
    """Return a link that translates along, or rotates about, the three axes of the world."""
    motion = revolute if turning else prismatic
    unit = "rad" if turning else "m"
    links = tuple(Link(f"link_{k}", SOLID) for k in range(3))
    joints = tuple(
        Joint(
            f"joint_{k}",
            WORLD if k == 0 else f"link_{k - 1}",
            f"link_{k}",
            motion(axis),
            (Coordinate(f"joint_{k}", unit=unit),),
        )
        for k, axis in enumerate(AXES)
    )
    sets = (CableSet("all", tuple(muscles)),)
    return Robot("carriage", links, joints, sets, "all", wrap_surfaces=tuple(surfaces))


def single_wraps(
    rng: np.random.Generator,
    count: int,
    *,
    sides: tuple[int, ...] = (0,),
    turns: tuple[int, ...] = (0,),
    lengths: tuple[float, ...] = (math.inf,),
) -> Robot:
    """Return a carriage with muscles that each wrap a sphere or cylinder in the world."""
    muscles, surfaces = [], []
    for k in range(count):
        shape = "sphere" if rng.random() < 0.5 else "cylinder"
        length = float(rng.choice(lengths)) if shape == "cylinder" else math.inf
        pose = Pose(vector(rng, 0.2), vector(rng, 3.0))
        surfaces.append(
            WrapSurface(f"surface_{k}", WORLD, shape, float(rng.uniform(0.05, 0.3)), pose, length)
        )
        wrap = Wrap(f"surface_{k}", 0, int(rng.choice(sides)), int(rng.choice(turns)))
        ends = (ViaPoint(WORLD, vector(rng, 0.6)), ViaPoint(FAR, vector(rng, 0.6)))
        muscles.append(Muscle(f"muscle_{k}", ends, 0.0, 10.0, wraps=(wrap,)))
    return carriage(muscles, surfaces)


def sequences(
    rng: np.random.Generator,
    count: int,
    surfaces: int,
    *,
    shapes: tuple[str, ...] = ("sphere", "cylinder"),
    sides: tuple[int, ...] = (0,),
    pulley: bool = False,
) -> Robot:
    """Return muscles along x over several disjoint surfaces in one segment."""
    muscles, placed = [], []
    gap = 1.0 / (surfaces + 1)
    for m in range(count):
        wraps = []
        for k in range(surfaces):
            centre = (-0.5 + gap * (k + 1), *map(float, rng.uniform(-0.08, 0.08, 2)))
            roll, yaw = float(rng.uniform(-3.0, 3.0)), float(rng.uniform(-0.1, 0.1))
            shape = str(rng.choice(shapes))
            radius = float(rng.uniform(0.1, 0.3)) * gap
            name = f"surface_{m}_{k}"
            pose = Pose(centre, (roll, 0.0, yaw))
            placed.append(WrapSurface(name, WORLD, shape, radius, pose))  # type: ignore[arg-type]
            wraps.append(Wrap(name, 0, int(rng.choice(sides))))  # type: ignore[arg-type]
        ends = (
            ViaPoint(WORLD, (-0.6, *map(float, rng.uniform(-0.2, 0.2, 2)))),
            ViaPoint(FAR, (0.6, *map(float, rng.uniform(-0.2, 0.2, 2)))),
        )
        at_base = base_pulley(0.05, vector(rng, 1.0)) if pulley else None
        muscles.append(Muscle(f"muscle_{m}", ends, 0.0, 10.0, pulley=at_base, wraps=tuple(wraps)))
    return carriage(muscles, placed)


def over_ellipsoids() -> Robot:
    """Return a link with three rotations, and muscles over an ellipsoid and over two surfaces."""
    surfaces = [
        WrapSurface(
            "egg", WORLD, "ellipsoid", 0.12, Pose(rpy=(0.3, 0.2, -0.4)), half_axes=(0.1, 0.06)
        ),
        WrapSurface("far", FAR, "ellipsoid", 0.05, Pose((0.3, 0.0, 0.0)), half_axes=(0.04, 0.08)),
        WrapSurface("bar", FAR, "cylinder", 0.04, Pose((0.3, 0.0, 0.3)), 0.4),
    ]

    def muscle(name: str, a: Vector3, b: Vector3, *wraps: Wrap) -> Muscle:
        return Muscle(name, (ViaPoint(WORLD, a), ViaPoint(FAR, b)), 1.0, 100.0, wraps=wraps)

    muscles = [
        muscle("one", (-0.3, 0.02, 0.1), (0.3, 0.05, 0.02), Wrap("egg", 0)),
        muscle("two", (-0.3, -0.1, 0.0), (0.5, -0.03, 0.02), Wrap("egg", 0), Wrap("far", 0)),
        muscle("bar", (-0.3, 0.1, 0.1), (0.5, 0.0, 0.31), Wrap("egg", 0), Wrap("bar", 0)),
        muscle("quadrant", (-0.3, 0.05, -0.1), (0.25, 0.02, -0.05),
               Wrap("egg", 0, rule="opensim", quadrant="-z")),
    ]  # fmt: skip
    robot = carriage(muscles, surfaces, turning=True)
    heavy = replace(robot.links[2], inertia=Inertia(2.0, (0.3, 0.0, 0.1), 0.1, 0.1, 0.1))
    return replace(robot, links=(*robot.links[:2], heavy))


def wrapped_tree(robot: Robot, seed: int) -> Robot:
    """Return a robot with one or two wrap surfaces in every second segment of its muscles."""
    rng = np.random.default_rng(seed)
    names = [WORLD, *(link.name for link in robot.links)]
    muscles, surfaces = [], []
    for muscle in robot.muscles:
        wraps = []
        for segment in range(0, len(muscle.via_points) - 1, 2):
            name = f"{muscle.name}_{segment}"
            shape = "sphere" if rng.random() < 0.5 else "cylinder"
            length = 0.4 if rng.random() < 0.3 and shape == "cylinder" else math.inf
            pose = Pose(vector(rng, 0.4), vector(rng, 3.0))
            radius = float(rng.uniform(0.05, 0.4))
            surfaces.append(
                WrapSurface(name, str(rng.choice(names)), shape, radius, pose, length)  # type: ignore[arg-type]
            )
            wraps.append(
                Wrap(name, segment, int(rng.choice([-1, 0, 1])), int(rng.choice([0, 0, 1])))
            )  # type: ignore[arg-type]
        muscles.append(replace(muscle, wraps=tuple(wraps)))
    return replace(robot.with_muscles(muscles), wrap_surfaces=tuple(surfaces))


def base_pulley(
    radius: float,
    entry: tuple[float, float, float],
    kind: Literal["rotating", "screw"] = "rotating",
) -> BasePulley:
    """Return a swivelling pulley."""
    if kind == "rotating":
        return BasePulley(kind, (("pulley_radius", (radius,)), ("cable_entry_vector", entry)))
    numbers = (
        ("winch_vector", (1.0, 0.0, 0.0)),
        ("cable_pulley_entry_vector", entry),
        ("pulley_radius", (radius,)),
        ("winch_radius", (0.02,)),
        ("winch_groove_width", (0.001,)),
    )
    return BasePulley(kind, numbers)


def vector(rng: np.random.Generator, size: float = 0.5) -> tuple[float, float, float]:
    """Return a random vector in a cube."""
    x, y, z = rng.uniform(-size, size, 3)
    return float(x), float(y), float(z)
