"""Memory of devices that are commanded by topics, and of their links, for CARDSFLOW_ROS_MINUTES."""

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
from support.interleaved import record
from support.robots.robots import PLANAR_2R
from support.ros.router import router_on_loopback

from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.hardware.session.connect import handshake_of

MINUTES = float(os.environ.get("CARDSFLOW_ROS_MINUTES", "1"))
STEP = 5e-3
MOST_GROWTH = 4.0
"""Between the ends of the first and the last tenth, in [MiB]: allocators take memory in pieces."""


@contextmanager
def device(uri: str) -> Iterator[int]:
    """The number of the process of a device."""
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
    """Memory of a process, in [MiB]."""
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    raise AssertionError


@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="memory is read from /proc")
def test_memory_does_not_grow() -> None:
    for package in ("zenoh", "cyclonedds"):
        pytest.importorskip(package)
    experiment = Experiment.load(PLANAR_2R)
    settings = experiment.hardware
    topics = DeviceTopics(experiment.robot, settings)
    hold = np.array([40.0, 15.0, 15.0, 15.0])
    with ExitStack() as stack:
        _, port = stack.enter_context(router_on_loopback())
        links, processes = {}, {"links": os.getpid()}
        for name, where in {
            "zenoh": f"ros2://127.0.0.1:{port}?domain=14",
            "dds": "ros2://127.0.0.1?rmw=dds&domain=14",
        }.items():
            processes[name] = stack.enter_context(device(f"{where}&timeout=20"))
            links[name] = link = RosLink(f"{where}&timeout=20&node=ctl", topics, timeout=30.0)
            stack.callback(link.close)
            link.open(handshake_of(experiment.robot, settings, STEP))
        tenths = []
        begin, k, answered = time.monotonic(), 0, dict.fromkeys(links, 0)
        for tenth in range(1, 11):
            while time.monotonic() - begin < 6.0 * MINUTES * tenth:
                for name, link in links.items():
                    came = link.exchange(k * STEP, hold, time.monotonic() + STEP)
                    answered[name] += came.state is not None
                k += 1
                time.sleep(max(begin + k * STEP - time.monotonic(), 0.0))
            tenths.append({name: resident(number) for name, number in processes.items()})
    for name in processes:
        record(
            f"memory by topics, {name}",
            minutes=MINUTES,
            answered=float(answered.get(name, 0)),
            first_mib=tenths[0][name],
            last_mib=tenths[-1][name],
            largest_mib=max(row[name] for row in tenths),
        )
        assert tenths[-1][name] - tenths[0][name] <= MOST_GROWTH, name
