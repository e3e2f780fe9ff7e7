"""MJCF of a robot in MuJoCo, in the coordinates of the robot.

MuJoCo's velocities are v = V(q) u, where u are the speeds of the robot's free coordinates. For ball
and free joints, the robot uses angles and MuJoCo quaternions; equalities of joints hold exactly.
Therefore M = V' M_mj V, bias = V' (bias_mj + M_mj V' u) and L = L_mj V.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray

from .mujoco_model import dense_tendon_jacobian

STEP = 1e-30
"""Step of complex-step derivatives, which have no rounding error."""
ANGLES = ("alpha", "beta", "gamma")


class Terms(NamedTuple):
    """M (n, n), C + G with the springs of joints (n,), lengths and moment arms of the tendons."""

    M: FloatArray
    bias: FloatArray
    lengths: FloatArray
    L: FloatArray


class MujocoFile:
    """File in MuJoCo, evaluated at states of a robot's free coordinates."""

    def __init__(self, file: Path, robot: Robot) -> None:
        self.model: Any = mujoco.MjModel.from_xml_path(str(file))
        self.model.tendon_stiffness[:] = 0.0  # these are muscles of the robot
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        self.data: Any = mujoco.MjData(self.model)
        self._names = [c.name for c in robot.coordinates]
        self._joints = [self._name(j) for j in range(self.model.njnt)]
        unnamed = iter(range(1, 1 + self._joints.count("")))
        self._joints = [name or f"joint_{next(unnamed)}" for name in self._joints]

    def _name(self, joint: int) -> str:
        return str(self.model.joint(joint).name)

    def tendon_of(self, muscle: str) -> int | None:
        """Return the index of the tendon of a muscle; None for a muscle at a joint."""
        model, on_tendons = self.model, mujoco.mjtTrn.mjTRN_TENDON
        for k in range(len(model.actuator_trntype)):
            if model.actuator(k).name == muscle and model.actuator_trntype[k] == on_tendons:
                return int(model.actuator_trnid[k, 0])
        names = [model.tendon(t).name for t in range(model.ntendon)]
        return names.index(muscle) if muscle in names else None

    def terms(self, q: FloatArray, u: FloatArray) -> Terms:
        """Return the terms at positions and speeds of the free coordinates, in their order."""
        V, rate = self._rates(q, u)
        self.data.qpos[:] = self._positions(q)
        self.data.qvel[:] = V @ u
        mujoco.mj_forward(self.model, self.data)
        M = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, M)
        bias = self.data.qfrc_bias - self.data.qfrc_spring
        L = dense_tendon_jacobian(self.model, self.data)
        return Terms(V.T @ M @ V, V.T @ (bias + M @ rate), np.array(self.data.ten_length), L @ V)

    def _all(self, q: Any, u: FloatArray) -> dict[str, tuple[Any, Any]]:
        """Return value and speed of hinges, slides and angles of other joints, by name."""
        model = self.model
        found = dict(zip(self._names, zip(q, u, strict=True), strict=True))
        start = {name: model.qpos0[model.jnt_qposadr[j]] for j, name in enumerate(self._joints)}
        equal = (model.eq_type == mujoco.mjtEq.mjEQ_JOINT) & (model.eq_active0 != 0)
        waiting = list(np.flatnonzero(equal))
        while waiting:
            k = waiting.pop(0)
            name, second = self._joints[model.eq_obj1id[k]], int(model.eq_obj2id[k])
            powers = model.eq_data[k][:5]
            if second < 0:
                found[name] = start[name] + powers[0], 0.0
            elif self._joints[second] in found:
                value, speed = found[self._joints[second]]
                x = value - start[self._joints[second]]
                way = sum(c * x**p for p, c in enumerate(powers))
                slope = sum(p * c * x ** (p - 1) for p, c in enumerate(powers) if p)
                found[name] = start[name] + way, slope * speed
            else:
                waiting.append(k)
        return found

    def _positions(self, q: FloatArray) -> FloatArray:
        """Return MuJoCo's qpos."""
        known, found = self._all(q, q), self.model.qpos0.copy()
        values = {name: value for name, (value, _) in known.items()}
        for j, name in enumerate(self._joints):
            kind, at = mujoco.mjtJoint(self.model.jnt_type[j]), int(self.model.jnt_qposadr[j])
            if kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
                found[at] = values[name]
                continue
            turned = np.array([1.0, 0.0, 0.0, 0.0])
            for angle, axis in zip((values[f"{name}_{w}"] for w in ANGLES), np.eye(3), strict=True):
                step, product = np.zeros(4), np.zeros(4)
                mujoco.mju_axisAngle2Quat(step, axis, angle)
                mujoco.mju_mulQuat(product, turned, step)
                turned = product
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                moved = np.array([values[f"{name}_{w}"] for w in "xyz"])
                found[at : at + 3] += self._start(j) @ moved
                at += 3
            product = np.zeros(4)
            mujoco.mju_mulQuat(product, self.model.qpos0[at : at + 4], turned)
            found[at : at + 4] = product
        return found

    def _start(self, joint: int) -> FloatArray:
        R, at = np.zeros(9), int(self.model.jnt_qposadr[joint]) + 3
        mujoco.mju_quat2Mat(R, self.model.qpos0[at : at + 4])
        return R.reshape(3, 3)

    def _rates(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return V, shape (nv, n), and its time derivative times u."""
        columns = [self._velocity(q, e) for e in np.eye(len(q))]
        V = np.array(columns).reshape(len(q), self.model.nv).T
        moved = q + 1j * STEP * u
        rate = sum(
            (self._velocity(moved, e).imag / STEP * u[k] for k, e in enumerate(np.eye(len(q)))),
            start=np.zeros(self.model.nv),
        )
        return V.real, rate

    def _velocity(self, q: Any, u: FloatArray) -> Any:
        """Return MuJoCo's qvel at speeds of the free coordinates; q may be complex."""
        known = self._all(q, u)
        values = {name: value for name, (value, _) in known.items()}
        speeds = {name: speed for name, (_, speed) in known.items()}
        found = np.zeros(self.model.nv, complex)
        for j, name in enumerate(self._joints):
            kind, at = mujoco.mjtJoint(self.model.jnt_type[j]), int(self.model.jnt_dofadr[j])
            if kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
                found[at] = speeds[name]
                continue
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                found[at : at + 3] = self._start(j) @ np.array(
                    [speeds[f"{name}_{w}"] for w in "xyz"]
                )
                at += 3
            _, b, c = (values[f"{name}_{w}"] for w in ANGLES)
            back = _about(2, -c) @ _about(1, -b)
            E = np.array([back[:, 0], _about(2, -c)[:, 1], [0.0, 0.0, 1.0]]).T
            found[at : at + 3] = E @ np.array([speeds[f"{name}_{w}"] for w in ANGLES])
        return found


def _about(axis: int, angle: Any) -> Any:
    c, s = np.cos(angle), np.sin(angle)
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    R = np.eye(3, dtype=complex)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R
