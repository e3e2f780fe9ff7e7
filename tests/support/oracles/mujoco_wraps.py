"""MuJoCo's wrapping of muscles of a `carriage` over one surface each, with side sites."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from lxml import etree
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray

from .mujoco_model import text


class MujocoWraps:
    """Path lengths by MuJoCo for a carriage whose muscle k wraps over surface k.

    `sides` are points in the frames of the surfaces that select the sides of the muscles; None
    selects the shorter path.
    """

    def __init__(self, robot: Robot, sides: Sequence[FloatArray | None] | None = None) -> None:
        root = etree.Element("mujoco")
        etree.SubElement(root, "compiler", angle="radian")
        world = etree.SubElement(root, "worldbody")
        body = etree.SubElement(world, "body")
        for axis in ("1 0 0", "0 1 0", "0 0 1"):
            etree.SubElement(body, "joint", type="slide", axis=axis)
        etree.SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        tendons = etree.SubElement(root, "tendon")
        for k, (muscle, surface) in enumerate(zip(robot.muscles, robot.wrap_surfaces, strict=True)):
            start, end = (point.position for point in muscle.via_points)
            etree.SubElement(world, "site", name=f"a{k}", pos=text(start))
            etree.SubElement(body, "site", name=f"b{k}", pos=text(end))
            R = Rotation.from_euler("xyz", surface.pose.rpy)
            x, y, z, w = R.as_quat()
            etree.SubElement(
                world,
                "geom",
                name=f"g{k}",
                type=surface.shape,
                size=text([surface.radius] + [9.0] * (surface.shape == "cylinder")),
                pos=text(surface.pose.position),
                quat=text([w, x, y, z]),
            )
            spatial = etree.SubElement(tendons, "spatial")
            etree.SubElement(spatial, "site", site=f"a{k}")
            over = etree.SubElement(spatial, "geom", geom=f"g{k}")
            if sides is not None and sides[k] is not None:
                place = R.apply(sides[k]) + surface.pose.position
                etree.SubElement(world, "site", name=f"s{k}", pos=text(place))
                over.set("sidesite", f"s{k}")
            etree.SubElement(spatial, "site", site=f"b{k}")
        self.model: Any = mujoco.MjModel.from_xml_string(etree.tostring(root, encoding="unicode"))
        self.data: Any = mujoco.MjData(self.model)

    def lengths(self, q: FloatArray) -> FloatArray:
        """Return l, shape (m,), in [m]."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_tendon(self.model, self.data)
        return np.array(self.data.ten_length)
