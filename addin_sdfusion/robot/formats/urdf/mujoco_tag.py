"""Reader of the `<mujoco>` element in URDF files."""

from __future__ import annotations

from dataclasses import replace

from ...model.robot import Robot
from ..reading.xml import Node


def read_mujoco_tag(robot: Robot, node: Node) -> Robot:
    """Return the robot with the gravity of `<mujoco><option>`; report other settings as omitted."""
    for mujoco in node.all("mujoco"):
        for child in mujoco.all():
            words = set(map(str, child.element.attrib))
            if child.tag == "option" and child.has("gravity"):
                robot = replace(robot, gravity=child.vector_attribute("gravity"))
                words.discard("gravity")
            if words or child.tag not in ("option", "compiler"):
                listed = ", ".join(sorted(words)) or "all of it"
                problem = f"<{child.tag}> of <mujoco> is only for MuJoCo; omitted: {listed}"
                child.warning("element-left-out", problem)
    return robot
