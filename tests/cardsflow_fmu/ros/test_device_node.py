"""`cardsflow device --ros2` and `run --hardware ros2://`, two programs over each middleware."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from cardsflow_fmu.middleware.address import node_address
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R
from support.ros.bus import Bus
from support.ros.router import router_on_loopback

from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.results.saved_run import load_run
from cardsflow_fmu.ros import device_node
from cardsflow_fmu.ros.scene_topics import Shown
from cardsflow_fmu.ros.topics import JOINT_STATES

LONGEST = 120.0
"""Time to wait for the device, in [s]."""


@contextmanager
def device(*words: str) -> Iterator[subprocess.Popen[str]]:
    """A device in a process of its own."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "device", str(PLANAR_2R), *words]
    command += ["--listen", "udp://127.0.0.1:0", "--watchdog", "5000", "--json"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen(command, **pipes, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()


def lines_until(process: subprocess.Popen[str], what: str) -> list[str]:
    """What a device says, as far as a line with a text."""
    assert process.stdout is not None
    lines: list[str] = []
    end = time.monotonic() + LONGEST
    while not lines or what not in lines[-1]:
        lines.append(process.stdout.readline())
        assert lines[-1], lines
        assert time.monotonic() < end
    return lines


def check_a_run(cardsflow: CommandLine, out: Path, uri: str) -> None:
    with device("--ros2", f"{uri}timeout=4&node=arm") as process:
        said = lines_until(process, "commands from /left/device_commands, ramped down after 4 s")
        assert any("warning: ros2://" in line and "no key" in line for line in said)
        words: Sequence[object] = ("--set", "run.duration=0.3", "--json", "-o", out)
        code, printed, err = cardsflow(
            "run", PLANAR_2R, "--hardware", f"{uri}timeout=4&node=controller", *words
        )
        assert code == 0, err
        assert json.loads(printed)["status"] == "complete"
        said = lines_until(process, "none came for 4 s: forces are ramped down")
        assert any("commands by ROS begin" in line for line in said)
    run = load_run(out)
    q = run.columns(["q.joint_1", "q.joint_2"])
    assert np.isfinite(q).all()
    assert (q[-1] != q[0]).all()  # it was driven


@pytest.mark.slow
@pytest.mark.extra("ros2-zenoh")
def test_a_run_by_topics_over_zenoh(cardsflow: CommandLine, tmp_path: Path) -> None:
    with router_on_loopback() as (_, port):
        check_a_run(cardsflow, tmp_path / "out", f"ros2://127.0.0.1:{port}/left?domain=12&")


@pytest.mark.slow
@pytest.mark.extra("ros2-dds")
def test_a_run_by_topics_over_dds(cardsflow: CommandLine, tmp_path: Path) -> None:
    check_a_run(cardsflow, tmp_path / "out", "ros2://127.0.0.1/left?rmw=dds&domain=12&")


@pytest.mark.extra("ros2")
def test_what_a_device_measures_is_published(monkeypatch: pytest.MonkeyPatch) -> None:
    from rosbags.typesys import Stores, get_typestore

    bus, experiment = Bus(), Experiment.load(PLANAR_2R)
    monkeypatch.setattr(device_node, "open_node", bus.node)
    inbox = bus.node().subscribe(JOINT_STATES)
    emulated = emulated_device(experiment, experiment.hardware)
    begin = time.time()
    with device_node.DeviceNode(
        emulated,
        Shown.of(experiment),
        experiment.hardware,
        "udp://127.0.0.1:1",
        node_address("ros2://"),
        None,
        print,
        takes_commands=False,
    ) as node:
        node.take_state()
        message = inbox.receive(time.monotonic() + LONGEST)
    assert message is not None
    state = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(message.content, JOINT_STATES.type)
    assert state.name == [c.name for c in experiment.robot.coordinates]
    np.testing.assert_array_equal(state.position, emulated.robot.state()[:2])
    stamp = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
    assert begin - 1e-3 <= stamp <= time.time()
    assert not any(topic.name == "/clock" for _, _, topic in bus.ends)


@pytest.mark.extra("ros2")
def test_a_device_states_its_timeout(cardsflow: CommandLine) -> None:
    line = cardsflow.refused(
        "device", PLANAR_2R, "--listen", "udp://127.0.0.1:0", "--ros2", "ros2://"
    )
    assert "commands by a topic need a stated timeout, such as ros2://?timeout=0.1" in line
