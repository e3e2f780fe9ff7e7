"""Reader of motors in URDF files: transmissions and ros2_control."""

from __future__ import annotations

from ..reading.xml import Node

COMMAND_INTERFACES = ("effort", "velocity", "position")
"""Command interfaces of ros2_control."""


def motor_joints(robot: Node) -> set[str]:
    """Return the names of the joints with a motor; report motors of unknown joints."""
    joint_names = {joint.attribute("name", "") for joint in robot.all("joint")}
    named = [*_of_transmissions(robot), *_of_ros2(robot)]
    for node in named:
        if node.attribute("name") not in joint_names:
            problem = f"<{node.tag}>: unknown joint {node.attribute('name', '')!r}"
            node.warning("unknown-joint", f"{problem}; its motor is omitted")
    return {name for node in named if (name := node.attribute("name", "")) in joint_names}


def _of_transmissions(robot: Node) -> list[Node]:
    named = []
    for transmission in robot.all("transmission"):
        named += transmission.all("joint")
        for actuator in transmission.all("actuator"):
            ratio = actuator.number("mechanicalReduction", 1.0)
            if ratio != 1.0:
                problem = (
                    f"its reduction {ratio:g} is ignored; motor torques are joint torques here"
                )
                actuator.warning("reduction-left-out", problem)
    return named


def _of_ros2(robot: Node) -> list[Node]:
    return [
        joint
        for control in robot.all("ros2_control")
        for joint in control.all("joint")
        if any(
            c.attribute("name", "") in COMMAND_INTERFACES for c in joint.all("command_interface")
        )
    ]
