"""Round-trip times by ROS topics over loopback, compared with the hardware protocol."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.hardware import echo_device
from support.hardware.echo_device import COMMANDS, SIGNATURE, STATES
from support.interleaved import record
from support.robots.robots import PLANAR_2R
from support.ros import echo_node

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.pacing import real_time_priority
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.links.udp import UdpLink
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.ros_interface.address import node_address

BLOCKS, EXCHANGES = 20, 300
MEDIAN_LIMIT = 0.5e-3
COMMAND = np.full(COMMANDS, 50.0)
TESTS = Path(__file__).parents[1]
HANDSHAKE = Handshake(SIGNATURE, 1e-3, 1.0, 2.0, COMMANDS, STATES, False)


@contextmanager
def said(file: str | None, *words: str) -> Iterator[str]:
    """Start a program and yield the first line of its output."""
    command = [sys.executable, str(file), *words]
    places = [str(TESTS.parent), str(TESTS), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(places)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def block(link: HardwareLink) -> np.ndarray:
    """Measure round-trip times of answered exchanges, in [s]."""
    times = np.full(EXCHANGES, np.nan)
    for k in range(EXCHANGES):
        begin = time.perf_counter()
        came = link.exchange(k * 1e-3, COMMAND, time.monotonic() + 0.5)
        if came.state is not None and np.isfinite(came.round_trip):
            times[k] = time.perf_counter() - begin
        time.sleep(1e-4)
    return times[np.isfinite(times)]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # in what rclpy imports
def test_round_trip() -> None:
    """The fastest block shows the time without other load."""
    pytest.importorskip("rclpy")
    experiment = Experiment.load(PLANAR_2R)
    topics = DeviceTopics(experiment.robot, experiment.hardware)
    with ExitStack() as stack:
        links: dict[str, HardwareLink] = {}
        uri = stack.enter_context(said(echo_device.__file__))
        links["our protocol"] = stack.enter_context(UdpLink(uri, timeout=10.0))
        where = "ros2://?domain=13"
        assert stack.enter_context(said(echo_node.__file__, where)) == "up"
        there = f"{where}&timeout=5&node=ctl"
        links["rclpy"] = RosLink(there, node_address(there), topics, timeout=20.0)
        stack.callback(links["rclpy"].close)
        for link in links.values():
            link.open(HANDSHAKE)
        times: dict[str, list[np.ndarray]] = {name: [] for name in links}
        with real_time_priority():
            for _ in range(BLOCKS):
                for name, link in links.items():
                    times[name].append(block(link))
    quiet = {}
    for name, blocks in times.items():
        every = np.concatenate(blocks)
        quiet[name] = min(float(np.median(one)) for one in blocks if len(one))
        record(
            f"round trip by topics, {name}",
            answered=len(every),
            median_us=float(np.median(every)) * 1e6,
            p99_us=float(np.quantile(every, 0.99)) * 1e6,
            quiet_median_us=quiet[name] * 1e6,
        )
    assert quiet["rclpy"] <= MEDIAN_LIMIT
