"""Node that uses rclpy and commands constant forces like a forward_command_controller.

    python commander.py COMMANDS STATES FORCE ...

It publishes the forces at 200 Hz until a `JointState` ends with them, and prints it as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import rclpy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

MAX_WAIT = 60.0
"""Time to wait for the state, in [s]."""


def command(commands: str, states: str, forces: list[float]) -> dict[str, Any]:
    rclpy.init()
    node = rclpy.create_node("commander")
    publisher = node.create_publisher(Float64MultiArray, commands, 10)
    newest = [JointState()]
    node.create_subscription(JointState, states, lambda message: newest.append(message), 10)
    node.create_timer(5e-3, lambda: publisher.publish(Float64MultiArray(data=forces)))
    end = time.monotonic() + MAX_WAIT
    while list(newest[-1].effort[-len(forces) :]) != forces and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    last = newest[-1]
    return {
        "status": last.header.frame_id,
        "name": list(last.name),
        "position": list(last.position),
        "effort": list(last.effort),
    }


if __name__ == "__main__":
    forces = [float(text) for text in sys.argv[3:]]
    print(json.dumps(command(sys.argv[1], sys.argv[2], forces)), flush=True)
