"""Design of the two-link arm of the examples."""

from __future__ import annotations

import json
import random
from pathlib import Path as File
from typing import Any

import numpy as np

from addin_sdfusion.robot.formats.read import read_robot
from addin_sdfusion.robot.model.robot import WORLD, Inertia, Robot

from ..build import Builder, Path
from ..maths import inverse, rotation, translation
from .parts import nested_place, random_motion

PLANAR_2R = File(__file__).parents[4] / "examples/planar_2r/robot"


def kg_cm2(inertia: Inertia) -> list[list[float]]:
    """Return the inertia matrix of a link in [kg·cm²]."""
    return [[1e4 * value for value in row] for row in inertia.matrix]


def two_link_arm(
    *,
    motion: Any = None,
    nesting: int = 0,
    seed: int | None = None,
    groups: bool = True,
    attributes: bool = True,
    as_built: bool = False,
    by_origins: bool = False,
    q: tuple[float, float] = (0.0, 0.0),
    robot: Robot | None = None,
) -> Any:
    """Open a design of the arm of examples/planar_2r.

    Links `base` (1 kg, grounded), `link_1`, `link_2`; joints `joint_1`, `joint_2` about y; the
    cables of the active set as construction points, the task point `tip` on link_2.

    Args:
        motion: A rigid 4x4 motion of the whole design, in [cm].
        nesting: Maximum number of parent components of each link; the number is random.
        seed: Seed of the component frames, the nesting and the order of creation; None to use the
            link frames of the example and the natural order.
        groups: Whether the links are rigid groups `EXPORT_<link>`; otherwise components.
        attributes: Whether points have attributes of the add-in (muscles `cable_1` ...) and the
            design has a muscle table; otherwise old names (`VP_motor0_EXPORT_link_1_1` ...).
        as_built: Whether the joints are as-built.
        by_origins: Whether joint origins define the joints.
        q: Joint coordinates, in [rad].
        robot: Another robot with revolute joints instead of the example.
    """
    robot = robot or read_robot(PLANAR_2R)
    order = random.Random(seed)
    build = Builder("planar_2r")
    whole = np.eye(4) if motion is None else np.array(motion, dtype=float)
    T_root = _link_poses(robot, q, whole)
    paths: dict[str, Path] = {}
    frames: dict[str, np.ndarray] = {}
    for name in T_root:
        T_link_own = np.eye(4) if seed is None else random_motion(order)
        frames[name] = inverse(T_link_own)  # pose of the link in the component
        depth = order.randint(0, nesting) if seed is not None else nesting
        T = T_root[name] @ T_link_own
        paths[name] = nested_place(build, name, T, order, depth, grounded=name == "base")
        if name == "base":
            build.explicit(paths[name], 1.0, inertia=np.eye(3), T=frames[name])
            continue
        inertia = robot.link(name).inertia
        com = [100.0 * v for v in inertia.com]
        build.explicit(paths[name], inertia.mass, com, kg_cm2(inertia), frames[name])
    for joint, value in zip(robot.joints, q, strict=True):
        _draw_joint(build, joint, value, paths, T_root, as_built, by_origins)
    _draw_points(build, robot, paths, frames, attributes)
    if groups:
        for name, path in paths.items():
            build.rigid_group(f"EXPORT_{name}", [path])
    if seed is not None:
        build.shuffle(order)
    return build.done()


def _link_poses(robot: Robot, q: Any, whole: np.ndarray) -> dict[str, np.ndarray]:
    """Return the poses of the links in the root frame, in [cm]; joint frames are child frames."""
    found = {"base": whole}
    for joint, value in zip(robot.joints, q, strict=True):
        parent = "base" if joint.parent == WORLD else joint.parent
        (motion,) = joint.motions
        T = translation([100.0 * v for v in joint.T_parent_joint.position])
        found[joint.child] = found[parent] @ T @ rotation(value, motion.axis)
    return found


def _draw_joint(
    build: Builder,
    joint: Any,
    value: float,
    paths: dict[str, Path],
    T_root: dict[str, np.ndarray],
    as_built: bool,
    by_origins: bool,
) -> None:
    parent = "base" if joint.parent == WORLD else joint.parent
    (motion,), (coordinate,) = joint.motions, joint.coordinates
    R = T_root[parent][:3, :3]
    build.joint(
        joint.name,
        "revolute",
        paths[joint.child],
        paths[parent],
        T_root[joint.child][:3, 3],
        R @ np.array(motion.axis),
        R @ np.array((1.0, 0.0, 0.0)),
        values=(value,),
        limits=((coordinate.lower, coordinate.upper),),
        as_built=as_built,
        by_origins=by_origins,
    )


def _draw_points(
    build: Builder,
    robot: Robot,
    paths: dict[str, Path],
    frames: dict[str, np.ndarray],
    attributes: bool,
) -> None:
    rows = []
    for i, muscle in enumerate(robot.muscles):
        for k, via in enumerate(muscle.via_points):
            link = "base" if via.link == WORLD else via.link
            place = _moved(frames[link], via.position)
            text = {"role": "via", "muscle": muscle.name, "number": k, "link": link}
            held = {"point": json.dumps(text)} if attributes else None
            build.point(paths[link], place, f"VP_motor{i}_EXPORT_{link}_{k}", held)
        limits = {"f_min": muscle.f_min, "f_max": muscle.f_max}
        rows.append({"name": muscle.name, "color": "#c03030", **limits})
    for task in robot.task_frames:
        text = {"role": "task", "name": task.name, "link": task.link, "axes": list(task.axes)}
        place = _moved(frames[task.link], task.position)
        held = {"point": json.dumps(text)} if attributes else None
        build.point(paths[task.link], place, f"EE_{task.link}", held)
    if attributes:
        for row in rows:
            row |= {"model": "ideal", "parameters": {}}
        build.design.attributes["CARDSFlow", "muscles"] = json.dumps(rows)


def _moved(T: np.ndarray, metres: Any) -> np.ndarray:
    return T[:3, :3] @ (100.0 * np.array(metres)) + T[:3, 3]
