"""A robot in MuJoCo: its tree as bodies, its muscles as spatial tendons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import WORLD, Pose, Robot, Vector3
from sim_dart.core.arrays import FloatArray


def dense_tendon_jacobian(model: Any, data: Any) -> FloatArray:
    """Return the dense Jacobian of the tendons, shape (tendons, nv), of a sparse model."""
    J = np.zeros((model.ntendon, model.nv))
    for k in range(model.ntendon):
        row = slice(model.ten_J_rowadr[k], model.ten_J_rowadr[k] + model.ten_J_rownnz[k])
        J[k, model.ten_J_colind[row]] = data.ten_J[row]
    return J


class MujocoRobot:
    """Muscle paths and dynamics of a robot by MuJoCo, with steps in [s] for `run`.

    Without `inertias` the links have other inertias, since MuJoCo rejects zero moments.
    """

    def __init__(self, robot: Robot, *, inertias: bool = True, step: float = 1e-3) -> None:
        xml = etree.tostring(_model(robot, inertias, step), encoding="unicode")
        self.model: Any = mujoco.MjModel.from_xml_string(xml)
        self.data: Any = mujoco.MjData(self.model)
        self._order = [self.model.joint(c.name).dofadr[0] for c in robot.coordinates]

    def move(self, q: Sequence[float], qd: Sequence[float] | None = None) -> None:
        """Set the state and evaluate all terms."""
        self.data.qpos[self._order] = q
        self.data.qvel[self._order] = 0.0 if qd is None else qd
        mujoco.mj_forward(self.model, self.data)

    def acceleration(self, tau: FloatArray) -> FloatArray:
        """Return qdd of M qdd + C + G + D qd = tau at the last state, shape (n,)."""
        self.data.qfrc_applied[self._order] = tau
        mujoco.mj_forward(self.model, self.data)
        return np.array(self.data.qacc)[self._order]

    def run(self, forces: Sequence[float] | FloatArray, steps: int) -> None:
        """Advance by steps with constant muscle forces: semi-implicit Euler, implicit damping."""
        self.data.ctrl[:] = forces
        mujoco.mj_step(self.model, self.data, steps)

    @property
    def q(self) -> FloatArray:
        """Return the positions, shape (n,)."""
        return np.array(self.data.qpos)[self._order]

    @property
    def lengths(self) -> FloatArray:
        """Return l, shape (m,)."""
        return np.array(self.data.ten_length)

    @property
    def jacobian(self) -> FloatArray:
        """Return L, shape (m, n)."""
        model = self.model
        dense = np.zeros((model.ntendon, model.nv))
        for k in range(model.ntendon):
            row = slice(model.ten_J_rowadr[k], model.ten_J_rowadr[k] + model.ten_J_rownnz[k])
            dense[k, model.ten_J_colind[row]] = self.data.ten_J[row]
        return dense[:, self._order]

    @property
    def mass_matrix(self) -> FloatArray:
        """Return M, shape (n, n)."""
        M = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, M)
        return M[np.ix_(self._order, self._order)]

    @property
    def bias(self) -> FloatArray:
        """Return C + G, shape (n,)."""
        return np.array(self.data.qfrc_bias)[self._order]


def _model(robot: Robot, inertias: bool, step: float) -> Any:
    root = etree.Element("mujoco")
    etree.SubElement(root, "compiler", angle="radian", autolimits="false")
    etree.SubElement(root, "option", gravity=text(robot.gravity), timestep=repr(step))
    bodies = {WORLD: etree.SubElement(root, "worldbody")}
    for joint in robot.joints:
        bodies[joint.child] = _body(robot, joint, bodies[joint.parent], inertias)
    _tendons(robot, root, bodies)
    actuators = etree.SubElement(root, "actuator")
    for muscle in robot.muscles:  # a muscle pulls where a motor pushes
        etree.SubElement(actuators, "motor", tendon=muscle.name, gear="-1")
    _loops(robot, root, bodies, step)
    return root


def _body(robot: Robot, joint: Any, parent: Any, inertias: bool) -> Any:
    T = _matrix(joint.T_parent_joint) @ np.linalg.inv(_matrix(joint.T_child_joint))
    body = etree.SubElement(
        parent, "body", name=joint.child, pos=text(T[:3, 3]), quat=_quaternion(T)
    )
    R_child_joint = _matrix(joint.T_child_joint)[:3, :3]
    for motion in joint.motions:  # MuJoCo also applies the joints of a body in turn
        coordinate = joint.coordinates[motion.coordinate]
        etree.SubElement(
            body,
            "joint",
            name=coordinate.name,
            type={"rotation": "hinge", "translation": "slide"}[motion.kind],
            pos=text(joint.T_child_joint.position),
            axis=text(R_child_joint @ np.array(motion.axis)),
            damping=repr(coordinate.damping),
        )
    inertia = robot.link(joint.child).inertia
    moments = (inertia.ixx, inertia.iyy, inertia.izz, inertia.ixy, inertia.ixz, inertia.iyz)
    etree.SubElement(
        body,
        "inertial",
        pos=text(inertia.com),
        mass=repr(inertia.mass if inertias else 1.0),
        fullinertia=text(moments if inertias else (1, 1, 1, 0, 0, 0)),
    )
    return body


def _loops(robot: Robot, root: Any, bodies: dict[str, Any], step: float) -> None:
    """Add stiff point constraints, which are sufficient for hinges of planar loops."""
    if not robot.loops:
        return
    equality = etree.SubElement(root, "equality")
    for loop in robot.loops:
        sites = {}
        for key, link, pose in (
            ("site1", loop.parent, loop.T_parent_joint),
            ("site2", loop.child, loop.T_child_joint),
        ):
            sites[key] = f"{loop.name}_{key}"
            place = text(pose.position)
            etree.SubElement(bodies[link], "site", name=sites[key], pos=place)
        etree.SubElement(equality, "connect", solref=text((2 * step, 1.0)), **sites)


def _tendons(robot: Robot, root: Any, bodies: dict[str, Any]) -> None:
    tendons = etree.SubElement(root, "tendon")
    for m, muscle in enumerate(robot.muscles):
        spatial = etree.SubElement(tendons, "spatial", name=muscle.name)
        for k, point in enumerate(muscle.via_points):
            site = f"site_{m}_{k}"
            etree.SubElement(bodies[point.link], "site", name=site, pos=text(point.position))
            etree.SubElement(spatial, "site", site=site)


def _matrix(pose: Pose) -> FloatArray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", pose.rpy).as_matrix()
    T[:3, 3] = pose.position
    return T


def _quaternion(T: FloatArray) -> str:
    x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat()
    return text((w, x, y, z))


def text(values: Vector3 | Sequence[float] | FloatArray) -> str:
    """Return numbers as the exact text of an attribute."""
    return " ".join(repr(float(value)) for value in values)
