"""Memory of a device with ROS topics and of its link, over CARDSFLOW_ROS_MINUTES."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.interleaved import record
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.hardware.session.connect import handshake_of
from cardsflow_fmu.ros_interface.address import node_address

MINUTES = float(os.environ.get("CARDSFLOW_ROS_MINUTES", "1"))
STEP = 5e-3
MAX_GROWTH = 4.0
"""Largest growth between the first and the last tenth of the run, in [MiB]."""


@contextmanager
def device(uri: str) -> Iterator[int]:
    """Start a device and yield its process id."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "device", str(PLANAR_2R)]
    command += ["--listen", "udp://127.0.0.1:0", "--watchdog", "20000", "--ros2", uri]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            while "commands from" not in process.stdout.readline():
                assert process.poll() is None
            yield process.pid
        finally:
            process.terminate()


def resident(process: int) -> float:
    """Return the memory of a process, in [MiB]."""
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    raise AssertionError


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="memory is read from /proc")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # in what rclpy imports
def test_memory_does_not_grow() -> None:
    pytest.importorskip("rclpy")
    experiment = Experiment.load(PLANAR_2R)
    settings, uri = experiment.hardware, "ros2://?domain=14&timeout=20"
    topics = DeviceTopics(experiment.robot, settings)
    hold = np.array([40.0, 15.0, 15.0, 15.0])
    link = RosLink(uri, node_address(f"{uri}&node=ctl"), topics, timeout=30.0)
    with device(uri) as process, contextlib.closing(link):
        processes = {"link": os.getpid(), "device": process}
        link.open(handshake_of(experiment.robot, settings, STEP))
        tenths = []
        begin, k, answered = time.monotonic(), 0, 0
        for tenth in range(1, 11):
            while time.monotonic() - begin < 6.0 * MINUTES * tenth:
                came = link.exchange(k * STEP, hold, time.monotonic() + STEP)
                answered += came.state is not None
                k += 1
                time.sleep(max(begin + k * STEP - time.monotonic(), 0.0))
            tenths.append({name: resident(number) for name, number in processes.items()})
    for name in processes:
        record(
            f"memory by topics, {name}",
            minutes=MINUTES,
            answered=float(answered),
            first_mib=tenths[0][name],
            last_mib=tenths[-1][name],
            largest_mib=max(row[name] for row in tenths),
        )
        assert tenths[-1][name] - tenths[0][name] <= MAX_GROWTH, name
