"""Runs and devices with real ROS 2 nodes that use rclpy without code of this package."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from support.process_output import MAX_WAIT, read_lines_until
from support.robots.robots import HELD, PLANAR_2R
from support.ros import jazzy

from cardsflow_fmu import Experiment
from cardsflow_fmu.results.saved_run import load_run

pytestmark = pytest.mark.interop

PROGRAMS = Path(jazzy.__file__).parent
ROBOT = Experiment.load(PLANAR_2R).robot
JOINTS = [c.name for c in ROBOT.coordinates]
MUSCLES = [muscle.name for muscle in ROBOT.muscles]
SLOW_ENOUGH = 3.0
"""Duration of a published run, in [s]."""

SLOW = {"run.step": 0.01, "controller.period": 0.01, "controller.kp": 10.0, "controller.kd": 5.0}
"""Settings of a run with few exchanges."""

Environment = dict[str, str]


@pytest.fixture
def ros() -> Environment:
    """Return the environment for programs of a test, with a separate ROS domain."""
    try:
        return jazzy.ros_environment()
    except jazzy.NoRosError as error:
        pytest.skip(f"there is no ROS 2: {error}")


def cardsflow(*words: object) -> list[str]:
    return [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]


def run_words(out: Path, *words: object) -> list[str]:
    return cardsflow("run", PLANAR_2R, "-o", out, "--json", *words)


def set_words(settings: dict[str, float]) -> list[str]:
    return [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]


@contextmanager
def started(command: list[str], ros: Environment) -> Iterator[subprocess.Popen[str]]:
    """Start a program, and kill it at the end if it still runs."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen(command, **pipes, text=True, env=ros) as process:  # type: ignore[call-overload]
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def listening(
    ros: Environment, node: str, bag: Path, *wanted: str, until: str = ""
) -> Iterator[dict[str, Any]]:
    """Yield the data that a listener records about a node; it is complete after the context.

    The context ends after the listener has said a word, if there is one.
    """
    seen: dict[str, Any] = {}
    command = [sys.executable, str(PROGRAMS / "listener.py"), node, str(bag), *wanted]
    with started(command, ros) as process:
        read_lines_until(process, "up")
        yield seen
        if until:
            read_lines_until(process, until)
        out, _ = process.communicate(timeout=MAX_WAIT)
        seen |= json.loads(out.splitlines()[-1])


def messages_in(bag: Path) -> dict[str, list[Any]]:
    """Return the messages of a bag by topic, read by rosbags."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    found: dict[str, list[Any]] = defaultdict(list)
    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, _, content in reader.messages():
            found[connection.topic].append(reader.deserialize(content, connection.msgtype))
    return found


def seconds(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def test_a_bag_of_a_run_has_its_results(ros: Environment, tmp_path: Path) -> None:
    """The bag has the topics, latched topics and /clock; the node has its parameters."""
    bag, out = tmp_path / "bag", tmp_path / "out"
    wanted = ("controller.kp", "controller.solver", "run.step")
    with listening(ros, "/arm/left/shown", bag, *wanted) as seen:
        words = ("--publish", "ros2://arm/left?node=shown", "--set", f"run.duration={SLOW_ENOUGH}")
        done = subprocess.run(
            run_words(out, *words), capture_output=True, text=True, env=ros, check=False
        )
        assert done.returncode == 0, done.stderr
    assert "published as node /arm/left/shown" in done.stderr
    assert json.loads(done.stdout)["real_time_factor"] < 1.1
    assert "/arm/left/shown" in seen["nodes"]
    assert (
        seen["topics"]
        | {
            "/clock": "rosgraph_msgs/msg/Clock",
            "/arm/left/joint_states": "sensor_msgs/msg/JointState",
            "/arm/left/tendon_states": "sensor_msgs/msg/JointState",
            "/arm/left/cables": "visualization_msgs/msg/MarkerArray",
        }
        == seen["topics"]
    )
    assert sorted(seen["latched"]) == ["/arm/left/robot_bodies", "/arm/left/robot_description"]
    own = Experiment.load(PLANAR_2R).controller.data()
    values = {"controller.kp": own["kp"], "controller.solver": own["solver"], "run.step": 1e-3}
    assert seen["parameters"] == {"values": values, "changed": False}

    run, messages = load_run(out), messages_in(bag)
    topics = {
        "joint_states": (JOINTS, {"position": "q", "velocity": "qd"}),
        "joint_reference": (JOINTS, {"position": "q_d"}),
        "tendon_states": (MUSCLES, {"position": "l", "effort": "f"}),
        "tendon_commands": (MUSCLES, {"effort": "f"}),
    }
    for topic, (names, fields) in topics.items():
        came = messages[f"/arm/left/{topic}"]
        assert len(came) > 10  # the recorder may find the topics late
        rows = np.searchsorted(run["time"], [seconds(m.header.stamp) - 1e-6 for m in came])
        assert [m.name for m in came] == [names] * len(came)
        for field, prefix in fields.items():
            columns = run.columns([f"{prefix}.{name}" for name in names])
            np.testing.assert_array_equal([getattr(m, field) for m in came], columns[rows])
    rates = np.array([m.velocity for m in messages["/arm/left/tendon_states"]])
    assert np.isfinite(rates).all()
    clock = [seconds(message.clock) for message in messages["/clock"]]
    stamps = [seconds(m.header.stamp) for m in messages["/arm/left/joint_states"]]
    assert (np.diff(clock) > 0.0).all()
    # the recorder may find the other topics before /clock
    assert {stamp for stamp in stamps if stamp >= clock[0]} <= set(clock)
    assert SLOW_ENOUGH - 0.1 < clock[-1] <= SLOW_ENOUGH
    assert seen["clock"] == pytest.approx(clock[-1], abs=1e-6)  # by use_sim_time


@contextmanager
def device(ros: Environment, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Start an emulated device."""
    given = ("--listen", "udp://127.0.0.1:0", "--watchdog", "60000", "--json", *words)
    with started(cardsflow("device", PLANAR_2R, *given), ros) as process:
        yield process


def test_a_late_subscriber_receives_the_description(ros: Environment, tmp_path: Path) -> None:
    with device(ros, "--publish", "ros2://right") as process:
        read_lines_until(process, "published as node /right/cardsflow")
        begin = time.time()
        with listening(ros, "/right/cardsflow", tmp_path / "bag", until="many"):
            pass
    messages = messages_in(tmp_path / "bag")
    (description,) = messages["/right/robot_description"]
    joints = ElementTree.fromstring(description.data).iter("joint")
    assert set(JOINTS) <= {joint.get("name") for joint in joints}
    assert messages["/right/robot_bodies"][0].markers
    newest = messages["/right/joint_states"][-1]
    assert begin < seconds(newest.header.stamp) < time.time()
    assert "/clock" not in messages


@pytest.mark.parametrize("controller", ["", "&controller=tendons"], ids=["own", "ros2_control"])
def test_a_run_drives_a_device_by_topics(ros: Environment, tmp_path: Path, controller: str) -> None:
    address = f"ros2://left?timeout=4&node=arm{controller}"
    with device(ros, "--ros2", address, *set_words(HELD)) as process:
        topic = "/left/tendons/commands" if controller else "/left/device_commands"
        said = read_lines_until(process, f"commands from {topic} with a timeout of 4 s")
        assert any("warning: ros2://" in line and "topics are not signed" in line for line in said)
        link = f"ros2://left?timeout=4&node=controller{controller}"
        # a pause of 3 s misses exchanges, but is shorter than the run and the timeout
        settings = HELD | SLOW | {"run.duration": 4.0, "hardware.watchdog": 60.0}
        words = run_words(tmp_path / "out", "--hardware", link, "--allow-poor-tracking")
        words += set_words(settings)
        done = subprocess.run(words, capture_output=True, text=True, env=ros, check=False)
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["status"] == "complete"
        said = read_lines_until(process, "none arrived for 4 s; forces are ramped down")
        assert any("ROS commands begin" in line for line in said)
    q = load_run(tmp_path / "out").columns([f"q.{name}" for name in JOINTS])
    assert np.isfinite(q).all()
    assert (q[-1] != q[0]).all()  # the device was driven


def test_another_node_commands_tendons_as_joints(ros: Environment) -> None:
    """It uses Float64MultiArray commands and one JointState with joints and tendons."""
    forces = [30.0, 15.0, 20.0, 15.0]
    with device(ros, "--ros2", "ros2://?timeout=4&controller=tendons") as process:
        read_lines_until(process, "commands from /tendons/commands")
        words = ["/tendons/commands", "/joint_states", *map(str, forces)]
        command = [sys.executable, str(PROGRAMS / "commander.py"), *words]
        done = subprocess.run(command, capture_output=True, text=True, env=ros, check=False)
        assert done.returncode == 0, done.stderr
        read_lines_until(process, "none arrived for 4 s; forces are ramped down")
    state = json.loads(done.stdout)
    assert state["status"] == "running"
    assert state["name"] == [*JOINTS, *MUSCLES]
    np.testing.assert_allclose(state["effort"][len(JOINTS) :], forces, rtol=1e-12)
    assert (np.array(state["position"])[len(JOINTS) :] > 0.0).all()


def test_ctrl_c_ends_a_published_run_with_its_results(ros: Environment, tmp_path: Path) -> None:
    words = ("--publish", "ros2://", "--set", "run.duration=60")
    with started(run_words(tmp_path / "out", *words), ros) as process:
        with listening(ros, "/cardsflow", tmp_path / "bag", until="many"):
            read_lines_until(process, "published as node /cardsflow")
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=MAX_WAIT)
    assert process.returncode == 130, said
    assert "Traceback" not in said
    assert len(load_run(tmp_path / "out").rows) > 10
    assert len(messages_in(tmp_path / "bag")["/joint_states"]) > 10
