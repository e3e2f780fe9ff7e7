"""Conversion of a compiled MuJoCo model to a robot: its tree without masses, and its tendons."""

from __future__ import annotations

import mujoco
import numpy as np

from addin_sdfusion.robot import (
    IDENTITY,
    WORLD,
    Branch,
    CableSet,
    Coordinate,
    CoordinateTerm,
    Inertia,
    Joint,
    Link,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
    prismatic,
    revolute,
)
from addin_sdfusion.robot.model.rotations import axis_rotation, compose, rpy
from sim_dart.core.arrays import FloatArray

SOLID = Inertia(1.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)


def robot_of_tendons(model: mujoco.MjModel) -> Robot:
    """Return a robot with a muscle for every tendon; its coordinates have the order of qpos."""
    surfaces: dict[str, WrapSurface] = {}
    links, joints = _tree(model)
    muscles = tuple(_tendon(model, t, surfaces) for t in range(model.ntendon))
    sets = (CableSet("all", muscles),)
    wrapped = tuple(surfaces.values())
    return Robot("tendons", tuple(links), tuple(joints), sets, "all", wrap_surfaces=wrapped)


def _tree(model: mujoco.MjModel) -> tuple[list[Link], list[Joint]]:
    """Return the tree; a joint turns about a point: Trans(p) R(axis, q - qpos0) Trans(-p)."""
    links, joints = [], []
    for b in range(1, model.nbody):
        parent, T = _body(model.body_parentid[b]), _pose(model.body_pos[b], model.body_quat[b])
        own = range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b])
        if not own:
            links.append(Link(_body(b), SOLID))
            joints.append(Joint(f"weld_{b}", parent, _body(b), (), (), T))
        for j in own:
            child = _body(b) if j == own[-1] else f"{_body(b)}_{j}"
            position, axis = _vector(model.jnt_pos[j]), _vector(model.jnt_axis[j])
            start = float(model.qpos0[model.jnt_qposadr[j]])
            turns = model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE
            back = (
                Pose(rpy=rpy(axis_rotation(axis, -start)))
                if turns
                else Pose(_vector(-start * np.array(axis)))
            )
            at = compose(compose(T, Pose(position)), back)
            motion, unit = (revolute(axis), "rad") if turns else (prismatic(axis), "m")
            coordinate = Coordinate(model.joint(j).name or f"q_{j}", unit=unit)  # type: ignore[arg-type]
            name = f"joint {j}"
            joints.append(Joint(name, parent, child, motion, (coordinate,), at, Pose(position)))
            links.append(Link(child, SOLID))
            parent, T = child, IDENTITY
    return links, joints


def _tendon(model: mujoco.MjModel, t: int, surfaces: dict[str, WrapSurface]) -> Muscle:
    kinds = mujoco.mjtWrap
    points: list[ViaPoint] = []
    wraps, branches, terms = [], [], []
    for k in range(model.tendon_adr[t], model.tendon_adr[t] + model.tendon_num[t]):
        kind, item, number = model.wrap_type[k], int(model.wrap_objid[k]), float(model.wrap_prm[k])
        if kind == kinds.mjWRAP_JOINT:
            terms.append(CoordinateTerm(model.joint(item).name or f"q_{item}", number))
        elif kind == kinds.mjWRAP_PULLEY:
            branches.append(Branch(len(points), number))
        elif kind == kinds.mjWRAP_SITE:
            points.append(_site(model, item))
        else:
            name = f"geom_{item}"
            shape = "sphere" if kind == kinds.mjWRAP_SPHERE else "cylinder"
            pose = _pose(model.geom_pos[item], model.geom_quat[item])
            link, radius = _body(model.geom_bodyid[item]), float(model.geom_size[item][0])
            surfaces[name] = WrapSurface(name, link, shape, radius, pose)  # type: ignore[arg-type]
            side = _site(model, int(number)) if number >= 0.0 else None
            wraps.append(Wrap(name, len(points) - 1, rule="mujoco", side_point=side))
    name = model.tendon(t).name or f"tendon_{t}"
    more = {"wraps": tuple(wraps), "branches": tuple(branches), "terms": tuple(terms)}
    return Muscle(name, tuple(points), f_max=1.0, **more)  # type: ignore[arg-type]


def _site(model: mujoco.MjModel, s: int) -> ViaPoint:
    return ViaPoint(_body(model.site_bodyid[s]), _vector(model.site_pos[s]))


def _body(b: int) -> str:
    return f"body_{b}" if b else WORLD


def _vector(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _pose(position: FloatArray, quaternion: FloatArray) -> Pose:
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quaternion)
    rows = tuple(tuple(row) for row in R.reshape(3, 3).tolist())
    return Pose(_vector(position), rpy(rows))  # type: ignore[arg-type]
