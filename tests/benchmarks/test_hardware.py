"""Round-trip times to emulated devices in Python and C over loopback."""

from __future__ import annotations

import select
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.hardware import echo_device
from support.hardware.echo_device import COMMANDS, SIGNATURE, STATES
from support.interleaved import record

from cardsflow_fmu.hardware.links.udp import UdpLink, udp_address
from cardsflow_fmu.hardware.protocol.frame import HEADER_BYTES
from cardsflow_fmu.hardware.protocol.handshake import Handshake

REFERENCE = Path(__file__).parents[2] / "examples/hardware_in_the_loop/device.c"
KEY = bytes(range(32))
BLOCKS, EXCHANGES = 40, 500
MEDIAN_LIMIT, P99_LIMIT = 60e-6, 300e-6
COMMAND = np.full(COMMANDS, 50.0)


@contextmanager
def device(command: Sequence[str | Path]) -> Iterator[str]:
    """Start a device in a separate process and yield its address."""
    words = list(map(str, command))
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def block(link: UdpLink, lockstep: bool) -> np.ndarray:
    """Measure round-trip times of exchanges, in [s]."""
    link.open(Handshake(SIGNATURE, 1e-3, 1.0, 0.02, COMMANDS, STATES, lockstep))
    times = np.empty(EXCHANGES)
    for k in range(EXCHANGES):
        begin = time.perf_counter()
        came = link.exchange(k * 1e-3, COMMAND, time.monotonic() + 0.5)
        times[k] = time.perf_counter() - begin
        assert came.state is not None
    return times


def bare_block(line: socket.socket) -> np.ndarray:
    """Measure round-trip times of unparsed datagrams with the size of frames, in [s]."""
    question, times = bytes(HEADER_BYTES + 8 * COMMANDS), np.empty(EXCHANGES)
    for k in range(EXCHANGES):
        begin = time.perf_counter()
        line.send(question)
        assert select.select([line], (), (), 0.5)[0]
        line.recv(4096)
        times[k] = time.perf_counter() - begin
    return times


def test_round_trip(tmp_path: Path) -> None:
    """Blocks alternate between devices. The fastest block shows the time without other load."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    in_c = tmp_path / "device"
    subprocess.run([compiler, "-std=c99", "-O2", "-o", in_c, REFERENCE, "-lm"], check=True)
    echo = [sys.executable, echo_device.__file__]
    commands: dict[str, tuple[list[str | Path], bytes | None]] = {
        "device in python": (echo, None),
        "device in python, signed": ([*echo, KEY.hex()], KEY),
        "device in c": ([in_c, "127.0.0.1", "0", f"{SIGNATURE:x}"], None),
    }
    times: dict[str, list[np.ndarray]] = {name: [] for name in ("bare echo", *commands)}
    with ExitStack() as stack:
        links = {}
        for name, (command, key) in commands.items():
            uri = stack.enter_context(device(command))
            links[name] = stack.enter_context(UdpLink(uri, key=key, timeout=10.0))
        floor = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        floor.connect(udp_address(stack.enter_context(device([*echo, "bare"]))))
        for _ in range(BLOCKS):
            times["bare echo"].append(bare_block(floor))
            for name, link in links.items():
                times[name].append(block(link, lockstep=True))
    figures = {name: quantiles(blocks) for name, blocks in times.items()}
    for name, (median, p99, quiet_median, quiet_p99) in figures.items():
        record(
            f"hardware round trip, {name}",
            median_us=median * 1e6,
            p99_us=p99 * 1e6,
            quiet_median_us=quiet_median * 1e6,
            quiet_p99_us=quiet_p99 * 1e6,
        )
    for name in ("device in python", "device in c"):
        assert figures[name][2] <= MEDIAN_LIMIT, name
        assert figures[name][3] <= P99_LIMIT, name
    assert figures["device in c"][2] < figures["device in python"][2]


def quantiles(blocks: list[np.ndarray]) -> tuple[float, float, float, float]:
    """Return median and 99th percentile of all blocks, and their minima over blocks, in [s]."""
    every = np.concatenate(blocks)
    medians = [float(np.median(times)) for times in blocks]
    tails = [float(np.quantile(times, 0.99)) for times in blocks]
    return float(np.median(every)), float(np.quantile(every, 0.99)), min(medians), min(tails)
