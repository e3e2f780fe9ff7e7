"""Controller and robot on two machines with different clocks, signed frames and a bad cable.

If the kernel cannot emulate line faults, the device emulates them.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.hardware.two_machines import Machines, two_machines
from support.process_output import MAX_WAIT, read_lines_until
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.hardware.session.connect import KEY_FILE
from cardsflow_fmu.results.verdict import FAILED_MISSED_SHARE
from cardsflow_fmu.simulation.run import simulate

pytestmark = pytest.mark.slow

DELAY, JITTER, LOSS = 1.0, 0.5, 0.02
"""Delay and jitter of each direction in [ms], and fraction of lost frames."""
STEPS = 300
LONG = 120.0
"""Timeout that no pause of a busy machine reaches, in [s]."""


@pytest.fixture(scope="module")
def machines() -> Iterator[Machines]:
    with two_machines() as made:
        if made is None:
            pytest.skip("network and time namespaces are not permitted here")
        yield made


def key_file(folder: Path, name: str = "key.bin") -> Path:
    file = folder / name
    file.write_bytes(os.urandom(32))
    file.chmod(0o600)
    return file


@contextmanager
def device(machines: Machines, experiment: Path, *words: object) -> Iterator[subprocess.Popen[str]]:
    """Start a device."""
    command = machines.command(machines.device, ["device", experiment, "--json", *words])
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            read_lines_until(process, "listening")
            yield process
        finally:
            process.kill()  # `unshare` handles only this signal


def totals(process: subprocess.Popen[str]) -> dict[str, Any]:
    """Stop a device; return what it has counted."""
    os.killpg(process.pid, signal.SIGTERM)  # `unshare` ignores it; the device handles it
    return dict(json.loads(read_lines_until(process, '"slipped"')[-1]))


def controller(
    machines: Machines, experiment: Path, uri: str, out: Path, settings: dict[str, object]
) -> subprocess.Popen[str]:
    """Run an experiment with the robot at an address."""
    words = ["run", experiment, "--coupling", "direct", "--hardware", uri, "--json", "-o", out]
    words += [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
    command = machines.command(machines.controller, words)
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def driven(
    machines: Machines, experiment: Path, uri: str, out: Path, settings: dict[str, object]
) -> tuple[int, dict[str, Any], str, float]:
    """Wait for a run. Return its exit code, summary and messages, and the elapsed time in [s]."""
    begin = time.monotonic()
    with controller(machines, experiment, uri, out, settings) as run:
        text, messages = run.communicate(timeout=MAX_WAIT)
    return run.returncode, json.loads(text or "{}"), messages, time.monotonic() - begin


def require_round_trips(out: Path, elapsed: float) -> None:
    """Check that one clock measures each round trip: the clocks differ by `CLOCK_AHEAD`."""
    trips = Result.load(out)["round_trip_time"][1:]
    assert trips.min() >= 2e-3 * DELAY
    assert trips.max() < elapsed


def test_a_run_in_lockstep_equals_one_in_a_single_process(
    machines: Machines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only frames signed with the key reach the robot, and each command exactly once."""
    uri, key = f"udp://{machines.device_address}:5005", key_file(tmp_path)
    settings = {
        "hardware.mode": "lockstep",
        "hardware.timeout": LONG,
        "hardware.ramp_down": 0.0,
        "run.duration": 1e-3 * STEPS,
    }
    shaping = machines.shape(DELAY, JITTER, LOSS)
    out = tmp_path / "out"
    with device(machines, PLANAR_2R, "--listen", uri, "--key-file", key, *shaping) as process:
        for wrong in ("", str(key_file(tmp_path, "wrong.bin"))):
            monkeypatch.setenv(KEY_FILE, wrong)
            code, _, messages, _ = driven(machines, PLANAR_2R, uri, out, settings)
            assert code == 1
            assert f"no device answers at {uri}" in messages
        monkeypatch.setenv(KEY_FILE, str(key))
        code, summary, messages, elapsed = driven(machines, PLANAR_2R, uri, out, settings)
        counted = totals(process)
    assert code == 0, messages
    assert (summary["status"], summary["hardware"]["missed"]) == ("complete", 0)
    require_round_trips(out, elapsed)
    of_device = counted["device"]
    assert of_device.get("unsigned")
    assert of_device.get("signature")
    assert (of_device["runs"], of_device["setpoints"]) == (1, STEPS)
    if "faults" in counted:
        assert all(counted["faults"][way]["lost"] > 0 for way in ("inward", "outward"))
    monkeypatch.delenv(KEY_FILE)
    here = {"hardware.use": True, "hardware.link": "loopback:"}
    alone = simulate(Experiment.load(PLANAR_2R, settings | here), coupling="direct")
    result = Result.load(out)
    for name in {*alone.names} - {"round_trip_time", "age", "lateness"}:
        np.testing.assert_array_equal(result[name], alone[name], err_msg=name)


RESTING = f"""
[robot]
path = "{PLANAR_2R}/robot/planar_2r_bodies.xml"
joints.joint_1."coordinates[0]" = {{ stiffness = 200.0, rest = -0.5, damping = 5.0 }}
joints.joint_2."coordinates[0]" = {{ stiffness = 200.0, rest = 0.5, damping = 5.0 }}
[start]
q = {{ joint_1 = -0.5, joint_2 = 0.5 }}
[reference]
type = "rest"
[controller]
type = "joint_space"
kp = 100.0
kd = 20.0
period = 0.01
[run]
step = 0.01
duration = 0.6
[hardware]
max_missed = 100000
watchdog = {LONG}
"""
"""The arm at rest, held by joint springs, so that no delay of commands moves it."""


def resting(folder: Path) -> Path:
    """Write the experiment of the arm at rest."""
    file = folder / "experiment.toml"
    file.write_text(RESTING)
    return file


def test_a_run_in_real_time_between_two_machines(
    machines: Machines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The commands of docs/how_to/two_machines.md, with a key on both sides.

    The number of exchanges that a busy machine misses determines whether the run succeeds.
    """
    uri, key = f"udp://{machines.device_address}:5006", key_file(tmp_path)
    monkeypatch.setenv(KEY_FILE, str(key))
    experiment, out = resting(tmp_path), tmp_path / "out"
    shaping = machines.shape(DELAY, JITTER, LOSS)
    with device(machines, experiment, "--listen", uri, "--key-file", key, *shaping) as process:
        code, summary, messages, elapsed = driven(machines, experiment, uri, out, {})
        counted = totals(process)
    hardware = summary["hardware"]
    assert hardware["exchanges"] == summary["real_time"]["steps"] == 60
    assert elapsed >= 0.6
    require_round_trips(out, elapsed)
    succeeds = hardware["missed"] <= FAILED_MISSED_SHARE * hardware["exchanges"]
    assert (code == 0) == (summary["status"] == "complete") == succeeds, messages
    assert not {"unsigned", "watchdog"} & counted["device"].keys()


def test_an_unplugged_cable_ends_the_run_in_the_safe_state(
    machines: Machines, tmp_path: Path
) -> None:
    """The device and the run wait for 5 s, so that shorter pauses have no effect."""
    uri, experiment = f"udp://{machines.device_address}:5007", resting(tmp_path)
    machines.shape(0.0, 0.0, 0.0)
    with device(machines, experiment, "--listen", uri, "--watchdog", 5000) as process:
        settings = {"run.duration": 60.0, "hardware.max_missed": 500}
        with controller(machines, experiment, uri, tmp_path / "out", settings) as run:
            read_lines_until(process, '"running"')
            machines.unplug()
            _, err = run.communicate(timeout=MAX_WAIT)
            said = read_lines_until(process, '"safe"')
    assert run.returncode != 0
    assert "the hardware does not respond: no state in" in err
    assert "no command for 5 s" in said[-1]
