"""Controller and robot on two machines with different clocks.

If the kernel cannot emulate line faults, the device emulates them.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from support.hardware.two_machines import Machines, two_machines
from support.process_output import MAX_WAIT, read_lines_until
from support.robots.robots import PLANAR_2R

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def machines() -> Iterator[Machines]:
    with two_machines() as made:
        if made is None:
            pytest.skip("network and time namespaces are not permitted here")
        yield made


@contextmanager
def device(machines: Machines, *words: object) -> Iterator[subprocess.Popen[str]]:
    """Start a device."""
    command = machines.command(machines.device, ["device", PLANAR_2R, "--json", *words])
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            read_lines_until(process, "listening")
            yield process
        finally:
            process.kill()  # `unshare` handles only this signal


def controller(machines: Machines, uri: str, out: Path, *words: object) -> subprocess.Popen[str]:
    """Run an experiment with the robot at an address."""
    settings = ["hardware.max_missed=2000", "hardware.watchdog=4.0", "run.duration=0.6"]
    sets: Sequence[object] = [word for line in settings for word in ("--set", line)]
    run = [
        "run",
        PLANAR_2R,
        "--coupling",
        "direct",
        "--hardware",
        uri,
        *sets,
        "--json",
        "-o",
        out,
        *words,
    ]
    command = machines.command(machines.controller, run)
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("delay", "jitter", "loss"), [(0.0, 0.0, 0.0), (1.0, 0.5, 0.02)], ids=["cable", "bad cable"]
)
def test_a_run_between_two_machines(
    machines: Machines,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    delay: float,
    jitter: float,
    loss: float,
) -> None:
    """The commands of docs/how_to/two_machines.md, with a key on both sides."""
    key = tmp_path / "key.bin"
    key.write_bytes(os.urandom(32))
    key.chmod(0o600)
    monkeypatch.setenv("CARDSFLOW_HARDWARE_KEY_FILE", str(key))
    uri = f"udp://{machines.device_address}:5005"
    shaping = machines.shape(delay, jitter, loss)
    with (
        device(machines, "--listen", uri, "--watchdog", 4000, "--key-file", key, *shaping),
        controller(machines, uri, tmp_path / "out") as run,
    ):
        out, err = run.communicate(timeout=MAX_WAIT)
    assert run.returncode == 0, err
    summary = json.loads(out)
    assert summary["status"] == "complete"
    round_trip = summary["hardware"]["round_trip"]["median"]
    assert (
        2e-3 * delay <= round_trip < 1.0
    )  # measured by one clock, so that the offset has no effect


def test_an_unplugged_cable_ends_the_run_in_the_safe_state(
    machines: Machines, tmp_path: Path
) -> None:
    uri = f"udp://{machines.device_address}:5006"
    machines.shape(0.0, 0.0, 0.0)
    with device(machines, "--listen", uri, "--watchdog", 500) as process:
        words = ("--set", "run.duration=60.0", "--set", "hardware.max_missed=1000")
        with controller(machines, uri, tmp_path / "out", *words) as run:
            read_lines_until(process, '"running"')
            machines.unplug()
            _, err = run.communicate(timeout=MAX_WAIT)
            said = read_lines_until(process, '"safe"')
    assert run.returncode != 0
    assert "the hardware does not respond: no state in" in err
    assert "no command for 0.5 s" in said[-1]
