"""Robots and scenes for tests of worlds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

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
    Vector3,
    ViaPoint,
    prismatic,
    revolute,
)
from sim_dart import Plant
from sim_dart.scene import Box, Capsule, Cylinder, LinkShape, MeshShape, Scene, Shape, Sphere

from .robots import one_joint

G = 9.81
SHAPES = ("sphere", "box", "capsule", "cylinder", "mesh", "fine mesh")


def write_box_mesh(folder: Path, size: Vector3 = (0.1, 0.1, 0.1)) -> Path:
    """Write a box as a mesh."""
    name = "_".join(map(str, size))
    return _written(folder / f"box_{name}.stl", trimesh.creation.box(size))


def _written(file: Path, mesh: trimesh.Trimesh) -> Path:
    file.write_bytes(trimesh.exchange.stl.export_stl(mesh))
    return file


def shape(kind: str, folder: Path) -> tuple[Shape, float]:
    """Return a shape with a width of 0.1 m, and half of its height."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    shapes: dict[str, tuple[Shape, float]] = {
        "sphere": (Sphere(0.05), 0.05),
        "box": (Box((0.1, 0.1, 0.1)), 0.05),
        "capsule": (Capsule(0.05, 0.1), 0.1),
        "cylinder": (Cylinder(0.05, 0.1), 0.05),
        "mesh": (MeshShape(write_box_mesh(folder)), 0.05),
        "fine mesh": (MeshShape(_written(folder / "ball.stl", ball)), 0.05),
    }
    return shapes[kind]


def block() -> Robot:
    """Return a robot that is far away from the objects of a scene."""
    far, solid = Pose((50.0, 0.0, 50.0)), Inertia(1.0, ixx=0.1, iyy=0.1, izz=0.1)
    return one_joint("block", prismatic((1.0, 0.0, 0.0)), solid, far, unit="m")


def world_of(scene: Scene, step: float = 1e-3) -> Plant:
    """Return a plant of a robot that is far away from the objects of its scene."""
    return Plant(block(), step, scene=scene)


def let_run(plant: Plant, duration: float, forces: object = None) -> np.ndarray:
    """Run a plant; return the poses of moving objects after each step, shape (steps, k, 7)."""
    f = np.zeros(len(plant.robot.muscles)) if forces is None else forces
    poses = []
    for _ in range(round(duration / plant.step_size)):
        plant.step(f)
        poses.append(plant.world.object_poses())
    return np.array(poses)


def pincers() -> tuple[Robot, tuple[LinkShape, ...]]:
    """Return a lift with two fingers that muscles close along y; coordinates lift, left, right."""
    links = (
        Link("carriage", Inertia(1.0, ixx=0.01, iyy=0.01, izz=0.01)),
        Link("left", Inertia(0.2, ixx=1e-3, iyy=1e-3, izz=1e-3)),
        Link("right", Inertia(0.2, ixx=1e-3, iyy=1e-3, izz=1e-3)),
    )
    up, aside = prismatic((0.0, 0.0, 1.0)), prismatic((0.0, 1.0, 0.0))

    def joint(name: str, parent: str, child: str, motion: object, y: float, **more: float) -> Joint:
        coordinate = Coordinate(name, unit="m", damping=0.1, **more)  # type: ignore[arg-type]
        return Joint(name, parent, child, motion, (coordinate,), Pose((0.0, y, 0.0)))  # type: ignore[arg-type]

    joints = (
        joint("lift", WORLD, "carriage", up, 0.0, lower=0.0, upper=0.5),
        joint("left", "carriage", "left", aside, -0.1, lower=0.0, upper=0.08),
        joint("right", "carriage", "right", aside, 0.1, lower=-0.08, upper=0.0),
    )
    ends = {"left": (0.0, -0.1, 0.0), "right": (0.0, 0.1, 0.0)}
    middle = (0.0, 0.0, 0.0)
    muscles = [Muscle("up", (ViaPoint(WORLD, (0.0, 0.0, 2.0)), ViaPoint("carriage", middle)))]
    for name, end in ends.items():
        inner, outer = ViaPoint("carriage", middle), ViaPoint("carriage", (0.0, 2 * end[1], 0.0))
        muscles.append(Muscle(f"close_{name}", (inner, ViaPoint(name, middle))))
        muscles.append(Muscle(f"open_{name}", (outer, ViaPoint(name, middle))))
    cables = CableSet("all", tuple(muscles))
    pads = tuple(LinkShape(name, Box((0.06, 0.02, 0.06))) for name in ends)
    return Robot("pincers", links, joints, (cables,), "all"), pads


def two_link_arm(name: str = "arm") -> Robot:
    """Return a hanging two-link arm about y with one muscle and links of 0.3 m."""
    links = tuple(
        Link(f"link_{k}", Inertia(1.0, (0.0, 0.0, -0.15), 8e-3, 8e-3, 1e-3), (0.0, 0.0, -0.3))
        for k in (1, 2)
    )
    joints = tuple(
        Joint(
            f"joint_{k}",
            parent,
            f"link_{k}",
            revolute((0.0, 1.0, 0.0)),
            (Coordinate(f"joint_{k}", damping=0.05),),
            Pose((0.0, 0.0, height)),
        )
        for k, parent, height in ((1, WORLD, 0.7), (2, "link_1", -0.3))
    )
    way = (ViaPoint(WORLD, (0.2, 0.0, 0.7)), ViaPoint("link_2", (0.03, 0.0, -0.1)))
    muscle = Muscle("pull", way, 0.0, 100.0)
    return Robot(name, links, joints, (CableSet("all", (muscle,)),), "all")
