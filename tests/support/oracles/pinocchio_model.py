"""Robot in Pinocchio, with one joint per coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import WORLD, Joint, Motion, Pose, Robot
from sim_dart.core.arrays import FloatArray

_JOINT = {
    "rotation": pinocchio.JointModelRevoluteUnaligned,
    "translation": pinocchio.JointModelPrismaticUnaligned,
}


class PinocchioRobot:
    """Dynamics of a robot by Pinocchio."""

    def __init__(self, robot: Robot) -> None:
        self.model: Any = pinocchio.Model()
        self.model.gravity.linear = np.array(robot.gravity)
        self._dofs: dict[str, int] = {}
        self._places: dict[str, tuple[int, Any]] = {WORLD: (0, pinocchio.SE3.Identity())}
        self._add_children(robot, WORLD)
        self._order = [self._dofs[c.name] for c in robot.coordinates]
        self.data: Any = self.model.createData()

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """Return M, shape (n, n)."""
        M = pinocchio.crba(self.model, self.data, self._sorted(q))
        full = np.triu(M) + np.triu(M, 1).T
        return full[np.ix_(self._order, self._order)]

    def bias(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Return C + G, shape (n,)."""
        found = pinocchio.nle(self.model, self.data, self._sorted(q), self._sorted(qd))
        return np.array(found)[self._order]

    def acceleration(self, q: FloatArray, qd: FloatArray, tau: FloatArray) -> FloatArray:
        """Return qdd, shape (n,)."""
        state = self._sorted(q), self._sorted(qd), self._sorted(tau)
        return np.array(pinocchio.aba(self.model, self.data, *state))[self._order]

    def loop_acceleration(
        self, robot: Robot, q: FloatArray, qd: FloatArray, tau: FloatArray
    ) -> FloatArray:
        """Return qdd with loop joints that fix a point (ball) or a pose (fixed), shape (n,)."""
        kind = {"ball": "CONTACT_3D", "fixed": "CONTACT_6D"}
        models = pinocchio.StdVec_RigidConstraintModel()
        datas = pinocchio.StdVec_RigidConstraintData()
        for loop in robot.loops:
            (A, T_A), (B, T_B) = self._places[loop.parent], self._places[loop.child]
            ends = A, T_A * _pose(loop.T_parent_joint), B, T_B * _pose(loop.T_child_joint)
            contact = getattr(pinocchio.ContactType, kind[loop.type])
            models.append(pinocchio.RigidConstraintModel(contact, self.model, *ends))
            datas.append(models[-1].createData())
        pinocchio.initConstraintDynamics(self.model, self.data, models, datas)
        state = self._sorted(q), self._sorted(qd), self._sorted(tau)
        settings = pinocchio.ProximalSettings(1e-13, 1e-13, 1e-8, 1000)
        found = pinocchio.constraintDynamics(self.model, self.data, *state, models, datas, settings)
        return np.array(found)[self._order]

    def point_bias(self, q: FloatArray, qd: FloatArray, link: str, point: Any) -> FloatArray:
        """Return J' qd of a point of a link, in world axes, shape (3,)."""
        joint, T = self._places[link]
        frame = pinocchio.Frame("", joint, 0, T * _translation(point), pinocchio.OP_FRAME)
        self._forward(q, qd)
        placement = frame.placement
        v = placement.actInv(self.data.v[joint])
        a = placement.actInv(self.data.a[joint])
        R = (self.data.oMi[joint] * placement).rotation
        bias: FloatArray = R @ (a.linear + np.cross(v.angular, v.linear))
        return bias

    def _forward(self, q: FloatArray, qd: FloatArray) -> None:
        still = np.zeros(self.model.nv)
        state = self._sorted(q), self._sorted(qd), still
        pinocchio.forwardKinematics(self.model, self.data, *state)

    def _sorted(self, values: FloatArray) -> FloatArray:
        out = np.empty(self.model.nv)
        out[self._order] = values
        return out

    def _add_children(self, robot: Robot, parent: str) -> None:
        """Add joints depth first, as Pinocchio requires."""
        for joint in robot.joints:
            if joint.parent == parent:
                self._add(robot, joint)
                self._add_children(robot, joint.child)

    def _add(self, robot: Robot, joint: Joint) -> None:
        at, T = self._places[joint.parent]
        T = T * _pose(joint.T_parent_joint)
        for motion in joint.motions:
            at, T = self._add_motion(joint, motion, at, T), pinocchio.SE3.Identity()
        T = T * _pose(joint.T_child_joint).inverse()
        self._places[joint.child] = at, T
        given = robot.link(joint.child).inertia
        xx, yy, zz, xy, xz, yz = (
            getattr(given, f"i{a}") for a in ["xx", "yy", "zz", "xy", "xz", "yz"]
        )
        moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        inertia = pinocchio.Inertia(given.mass, np.array(given.com), moments)
        self.model.appendBodyToJoint(at, inertia, T)

    def _add_motion(self, joint: Joint, motion: Motion, at: int, T: Any) -> int:
        name = joint.coordinates[motion.coordinate].name
        made = self.model.addJoint(at, _JOINT[motion.kind](np.array(motion.axis)), T, name)
        self._dofs[name] = self.model.joints[made].idx_v
        return int(made)


def _pose(pose: Pose) -> Any:
    R = Rotation.from_euler("xyz", pose.rpy).as_matrix()
    return pinocchio.SE3(R, np.array(pose.position))


def _translation(point: Any) -> Any:
    return pinocchio.SE3(np.eye(3), np.array(point))
