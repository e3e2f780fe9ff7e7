"""Topics of a run, with a bus in this process; `test_real_ros` uses real nodes."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.recorded import sinusoidal_result, with_columns
from support.robots.robots import PLANAR_2R
from support.ros.bus import Bus

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.ports import coordinate_signals
from cardsflow_fmu.ros.publisher import RunPublisher, node_parameters
from cardsflow_fmu.ros.scene_topics import DESCRIPTION, ShownRobot
from cardsflow_fmu.ros.topics import JOINT_STATES, TENDON_STATES
from cardsflow_fmu.ros_interface.joint_state import JointState

EXPERIMENT = Experiment.load(PLANAR_2R)


def rows_of(run: Experiment) -> Any:
    """Return the rows of an artificial motion with velocities."""
    plain = sinusoidal_result(run.robot, 1.0)
    names = coordinate_signals("qd", run.robot)
    return with_columns(plain, {name: np.cos(plain["time"]) for name in names})


def test_the_newest_row_is_published_once() -> None:
    bus, run = Bus(), rows_of(EXPERIMENT)
    joints, tendons, description = (
        bus.node().subscribe(topic) for topic in (JOINT_STATES, TENDON_STATES, DESCRIPTION)
    )
    publisher = RunPublisher(ShownRobot.from_experiment(EXPERIMENT), bus.node())
    for count in (30, 50, 50):
        publisher.watch(run.names, run.rows[:count])
        publisher.send_newest()
    for row in (29, 49):
        came = joints.receive(time.monotonic())
        assert came is not None
        state = JointState.from_message(came.message)
        assert state.names == tuple(c.name for c in EXPERIMENT.robot.coordinates)
        np.testing.assert_array_equal(state.position, run.rows[row, 1:3])
        assert state.time_ns == round(1e9 * run["time"][row])
        came = tendons.receive(time.monotonic())
        assert came is not None
        np.testing.assert_array_equal(came.message.effort, run.rows[row, 3:7])
    assert joints.receive(time.monotonic()) is None
    came = description.receive(time.monotonic())
    assert came is not None
    assert "<robot name" in came.message.data
    assert all(topic.latched == (topic.name[:7] == "/robot_") for _, _, topic in bus.ends[3:])


def test_topics_without_installed_message_types_are_omitted_and_named() -> None:
    bus, run = Bus(unknown=("tf2_msgs/msg/TFMessage", "cardsflow_msgs/msg/Signals")), rows_of
    publisher = RunPublisher(ShownRobot.from_experiment(EXPERIMENT), bus.node())
    made = run(EXPERIMENT)
    publisher.watch((*made.names, "energy"), np.column_stack([made.rows, made["time"]]))
    publisher.send_newest()
    assert "without /tf (tf2_msgs), /signals (cardsflow_msgs)" in publisher.remark
    names = {topic.name for _, _, topic in bus.ends}
    assert "/joint_states" in names
    assert not names & {"/tf", "/signals"}


def test_parameters_are_the_settings_of_controller_and_run() -> None:
    found = node_parameters(EXPERIMENT)
    assert found["controller.kp"] == [2000.0, 2000.0]
    assert found["controller.type"] == "joint_space"
    assert found["run.step"] == 1e-3
    assert "controller.motor_weights" not in found  # an empty list has no type


def test_a_failure_of_publishing_does_not_end_the_run() -> None:
    class Broken:
        def has_type(self, message_type: str) -> bool:
            return True

        def advertise(self, topic: Any) -> None:
            """Record the topic."""

        def publish(self, topic: Any, values: Any) -> None:
            if topic.name == "/joint_states":
                raise InputError("gone")

    run = rows_of(EXPERIMENT)
    publisher = RunPublisher(ShownRobot.from_experiment(EXPERIMENT), Broken())  # type: ignore[arg-type]
    publisher.watch(run.names, run.rows)
    publisher.stop()
    publisher.run()
    assert str(publisher.failure) == "gone"


def test_the_error_without_rclpy_names_a_remedy(
    cardsflow: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    line = cardsflow.error_line("run", PLANAR_2R, "--publish", "ros2://", "-o", tmp_path / "out")
    for what in ("ROS 2 topics require rclpy", "source the setup.bash", "ros-jazzy-rclpy", "3.11"):
        assert what in line
    assert not (tmp_path / "out").exists()
