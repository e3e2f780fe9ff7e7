"""`cardsflow device` and `cardsflow replay-hardware` in separate processes."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.experiments import copy_arm
from support.hardware.hardware_devices import rejection
from support.robots.robots import EXAMPLES, HELD, PLANAR_2R

from addin_sdfusion.robot import write_sdf
from addin_sdfusion.robot.formats.read import read
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.cosim.signals.ports import muscle_signals
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.status import Event, StatusReporter
from cardsflow_fmu.hardware.links.udp import UdpLink
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.frame import Flag
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.protocol.recording import Recorder, RecordingHeader, read_recording
from cardsflow_fmu.simulation.run import RunError, run, simulate
from sim_dart import MusclePaths

FREE = ["--listen", "udp://127.0.0.1:0"]
ARM, ROBOT = str(PLANAR_2R), str(PLANAR_2R / "robot")
SECONDS = 300
SETTINGS = {"run.duration": 0.25, "hardware.ramp_in": 0.0, "hardware.ramp_down": 0.0}
LOCKSTEP = {"hardware.use": True, "hardware.mode": "lockstep", "hardware.timeout": SECONDS}

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


class Served:
    """Process of a device, with its address and its output."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        first = json.loads(process.stdout.readline() or "{}")
        assert list(first) == ["listening"], process.communicate()
        self.uri: str = first["listening"]
        self.events: list[dict] = []
        self.totals: dict = {}
        self.errors = ""

    def end(self, number: int = signal.SIGINT) -> int:
        """Interrupt the device and return its exit code."""
        self.process.send_signal(number)
        return self.wait()

    def wait(self) -> int:
        output, self.errors = self.process.communicate(timeout=SECONDS)
        *self.events, self.totals = map(json.loads, output.splitlines())
        return self.process.returncode

    def states(self) -> list[str]:
        return [event["state"] for event in self.events]


@contextmanager
def serve_device(*words: str, **environment: str) -> Iterator[Served]:
    command = [sys.executable, "-m", "cardsflow_fmu.cli", *words, "--json"]
    command += [] if "--listen" in words else FREE
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    ) as process:
        try:
            yield Served(process)
        finally:
            if process.poll() is None:
                process.kill()
                process.communicate()


def experiment(**changes: object) -> Experiment:
    return Experiment.load(PLANAR_2R, SETTINGS | changes)


def rows_of(result: Result) -> np.ndarray:
    names = [name for name in result.names if re.match(r"(f|q|qd|l)\.", name)]
    assert len(names) == 12
    return result.columns(names)


@pytest.fixture(scope="module")
def plant_run() -> Result:
    return simulate(experiment(), coupling="direct")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory, plant_run: Result) -> Path:
    """Record a run in lockstep, which equals the run with the plant."""
    folder = tmp_path_factory.mktemp("recorded")
    with serve_device("device", ARM) as device:
        driven = experiment(**LOCKSTEP, **{"hardware.link": device.uri})
        result = run(driven, folder, coupling="direct")
        assert device.end() == 0
    np.testing.assert_array_equal(rows_of(result), rows_of(plant_run))
    assert device.states()[-2:] == ["running", "safe"]
    assert device.events[-1]["reason"] == "stopped on request"
    assert device.totals["device"]["setpoints"] == driven.run.steps
    return folder / "hardware.rec"


@pytest.mark.slow
def test_run_with_a_device_equals_the_run_with_the_plant(recorded: Path, plant_run: Result) -> None:
    recording = read_recording(recorded)
    names = muscle_signals("f", plant_run.experiment.robot)
    assert recording.header.command_names == tuple(names)
    assert recording.header.lockstep
    assert recording.header.start_state[:2] == plant_run.experiment.start.q
    assert recording.lost_bytes == 0
    np.testing.assert_array_equal(recording.commands, plant_run.columns(names)[:-1])
    np.testing.assert_array_equal(recording.states[:, 0], plant_run["q.joint_1"][1:])


@pytest.mark.slow
def test_replay_of_a_recording_has_the_same_results(recorded: Path, plant_run: Result) -> None:
    """Bit-identical in lockstep, with a clear error after its end; also in real time."""
    with serve_device("replay-hardware", str(recorded), "--watchdog", "10000") as device:
        driven = experiment(**LOCKSTEP, **{"hardware.link": device.uri})
        result = simulate(driven, coupling="direct")
        np.testing.assert_array_equal(rows_of(result), rows_of(plant_run))
        longer = experiment(**LOCKSTEP, **{"hardware.link": device.uri, "run.duration": 0.3})
        with pytest.raises(RunError, match="the robot of the device has failed") as error:
            simulate(longer, coupling="direct")
        assert error.value.result["time"][-1] == pytest.approx(0.25, abs=2e-3)
        with Line(device.uri, recorded) as line:
            line.exchange(20)
            np.testing.assert_allclose(line.state[:2], plant_run.rows[40, 1:3], atol=0.05)
        assert device.end() == 0
    assert any(e["reason"] == "the recording ends after 0.25 s" for e in device.events)


class Line:
    """Link in real time that sends commands of 12 N every 2 ms."""

    def __init__(
        self, uri: str, recorded: Path, key: bytes | None = None, timeout: float = SECONDS
    ) -> None:
        header = read_recording(recorded).header
        self._link = UdpLink(uri, key=key, timeout=timeout)
        self.handshake = Handshake(
            header.signature, 2e-3, 1.0, 10.0, header.commands, header.states, lockstep=False
        )

    def __enter__(self) -> Line:
        self._link.open(self.handshake)
        return self

    def __exit__(self, *exception: object) -> None:
        self._link.close()

    def exchange(self, times: int) -> int:
        """Send a number of commands; return the flags of the last answer."""
        begin, came = time.monotonic(), None
        for k in range(times):
            due = begin + k * 2e-3
            time.sleep(max(due - time.monotonic(), 0.0))
            answer = self._link.exchange(k * 2e-3, np.full(4, 12.0), due + SECONDS)
            came = answer if answer.state is not None else came
        assert came.state is not None
        self.state = came.state
        return came.device_flags


@pytest.mark.slow
def test_device_reports_its_safe_state_without_commands(recorded: Path) -> None:
    with serve_device("device", ARM, "--watchdog", "30") as device:
        with Line(device.uri, recorded) as line:
            line.exchange(10)
            time.sleep(0.1)
            assert line.exchange(1) & Flag.SAFE
        assert device.end(signal.SIGTERM) == 0
    assert device.states()[-2:] == ["running", "safe"]
    assert device.events[-1]["reason"].startswith("no command for 0.03 s (this device was late by")
    assert device.totals["device"]["watchdog"] == 1


@pytest.mark.slow
def test_device_with_a_key_only_answers_signed_frames(recorded: Path, tmp_path: Path) -> None:
    key = tmp_path / "key.bin"
    key.write_bytes(bytes(range(32)))
    key.chmod(0o644)
    with serve_device("device", ARM, CARDSFLOW_HARDWARE_KEY_FILE=str(key)) as device:
        with pytest.raises(HardwareError, match="no device answers"):
            Line(device.uri, recorded, timeout=0.5).__enter__()
        with Line(device.uri, recorded, bytes(range(32))) as line:
            line.exchange(2)
        assert device.end() == 0
    assert device.totals["device"]["unsigned"] > 0
    assert "other users can read this key" in device.errors


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("key", [None, bytes(range(32))])
@pytest.mark.parametrize("host", ["0.0.0.0", "127.0.0.1"])
def test_public_device_without_a_key_prints_a_warning(
    key: bytes | None, host: str, tmp_path: Path
) -> None:
    words: list[str] = []
    if key is not None:
        (tmp_path / "key.bin").write_bytes(key)
        (tmp_path / "key.bin").chmod(0o600)
        words = ["--key-file", str(tmp_path / "key.bin")]
    with serve_device("device", ROBOT, "--listen", f"udp://{host}:0", *words) as device:
        assert device.end() == 0
    warned = "anyone on the network can send commands" in device.errors
    assert warned == (host == "0.0.0.0" and key is None)


@pytest.mark.slow
def test_run_with_transmission_faults_ends_with_a_clear_status() -> None:
    table = "{loss=0.05, jitter=5e-4, duplicate=0.1, reorder=0.05, corrupt=0.05, seed=3}"
    patient = HELD | {"hardware.watchdog": SECONDS, "hardware.max_missed": 100_000}
    words = [word for key, value in patient.items() for word in ("--set", f"{key}={value}")]
    words += ["--set", f"hardware.emulator={table}"]
    with serve_device("device", ARM, *words) as device:
        changes = patient | {"hardware.link": device.uri, "hardware.use": True}
        assert simulate(experiment(**changes), coupling="direct").complete
        assert device.end() == 0
    faults = device.totals["faults"]
    assert all(faults["inward"][key] > 0 for key in ("lost", "duplicated", "damaged", "delivered"))
    assert faults["inward"]["sent"] >= 250


@pytest.mark.slow
def test_device_emulates_a_robot_with_motors_and_sensors(recorded: Path, tmp_path: Path) -> None:
    """The device rejects a second sender and reports it."""
    robot = read(PLANAR_2R / "robot").require()
    write_sdf(robot, tmp_path)
    table = "{joint_counts=1000, length_counts=1000, noise=1e-3, motor_lag=0.01, seed=4"
    table += ", differentiate_positions=true}"
    words = ["--step", "0.002", "--set", f"hardware.emulator={table}", "--watchdog", "10000"]
    with serve_device("device", str(tmp_path), *words) as device:
        with Line(device.uri, recorded) as line:
            line.exchange(10)
            counts = line.state[[0, 1, 4, 5, 6, 7]] * 1000
            assert "another run uses it" in rejection(device.uri, line.handshake)
            assert line.exchange(2) & Flag.SAFE == 0
        assert device.end() == 0
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert np.all((line.state[8:] > 10.0) & (line.state[8:] < 12.0))
    refused = [event["reason"] for event in device.events if event["state"] == "rejected"]
    assert refused == ["another run uses it; end that run first"]


@pytest.mark.slow
def test_device_uses_the_imperfections_of_its_experiment(recorded: Path) -> None:
    words = ["--set", "hardware.emulator.length_offset.cable_2=0.25", "--watchdog", "10000"]
    with serve_device("device", ARM, *words) as device:
        with Line(device.uri, recorded) as line:
            line.exchange(2)
        assert device.end() == 0
    lengths = MusclePaths(experiment().robot).evaluate(line.state[:2]).lengths
    np.testing.assert_allclose(line.state[4:8] - lengths, [0, 0.25, 0, 0], atol=1e-12)


def test_device_ends_after_its_duration(cardsflow: CommandLine) -> None:
    code, out, _ = cardsflow("device", PLANAR_2R, *FREE, "--duration", 0.05)
    assert code == 0
    first, *_, last = out.splitlines()
    assert re.fullmatch(r"listening on udp://127\.0\.0\.1:\d+", first)
    assert last == "totals: slipped 0"


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["device", "nowhere"], 2, "nowhere"),
        (["device", ARM, "--set", "plant.stepp=1"], 2, "stepp"),
        (["device", ARM, "--step", "1"], 2, "--set plant.step=..."),
        (["device", ARM, "--cable-set", "x"], 2, "--set robot.cable_set=..."),
        (["device", ROBOT, "--set", "plant.step=1"], 2, "only settings of [hardware] apply"),
        (["device", ROBOT, "--set", "hardware.emulator.loss=1.5"], 2, "emulator.loss: must be"),
        (["device", ROBOT, "--step", "-1"], 2, "a positive time"),
        (["device", ARM, "--listen", "tcp://127.0.0.1:5"], 2, "udp://HOST:PORT"),
        (["device", ARM, "--listen", "udp://127.0.0.1"], 2, "udp://HOST:PORT"),
        (["device", ARM, "--listen", "udp://127.0.0.1:99999"], 2, "udp://HOST:PORT"),
        (["device", ARM, "--listen", "udp://no.such.invalid:5"], 1, "unknown host"),
        (["device", str(EXAMPLES / "pneumatic_elbow")], 2, "the muscle law 'mckibben'; remove"),
        (
            ["run", str(EXAMPLES / "hill_arm"), "--hardware", "loopback:"],
            2,
            "hardware requires force commands",
        ),
        (["device", ARM, "--listen", "udp://192.0.2.1:5"], 1, "address of this machine"),
        (["device", ARM, "--watchdog", "0"], 2, "watchdog must be a positive"),
        (["device", ARM, "--duration", "0"], 2, "--duration: must be positive"),
        (["device", ARM, "--key-file", "nowhere.key"], 2, "nowhere.key"),
        (["replay-hardware", "nowhere.rec"], 2, "nowhere.rec: cannot be read"),
        (["replay-hardware", __file__], 2, "is not a hardware recording"),
    ],
)
def test_invalid_device_options_are_reported_in_one_line(
    words: list[str], code: int, message: str, cardsflow: CommandLine
) -> None:
    own = [] if "--listen" in words or words[0] == "run" else FREE
    assert message in cardsflow.error_line(*words, *own, code=code)


def test_device_does_not_execute_a_muscle_law(tmp_path: Path, cardsflow: CommandLine) -> None:
    """Only commands that simulate execute the Python file of a law, and a device rejects it."""
    executed = tmp_path / "executed"
    code = f"""open({str(executed)!r}, "w").close()
class Elastic:
    command = ("rest_length", "m", 0.0, 4.0)
"""
    arm = copy_arm(tmp_path, law=code)
    law = "muscles.cable_1.model.kind='law.py:Elastic'"
    line = cardsflow.error_line("device", arm, *FREE, "--set", law)
    assert "experiment.toml: muscles.cable_1.model: hardware requires force commands" in line
    assert "the muscle law 'Elastic'; remove" in line
    assert not executed.exists()


def test_used_port_is_reported_in_one_line(cardsflow: CommandLine) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        uri = f"udp://127.0.0.1:{taken.getsockname()[1]}"
        line = cardsflow.error_line("device", PLANAR_2R, "--listen", uri, code=1)
    assert f"cannot listen on {uri}" in line


def test_recording_without_states_cannot_be_replayed(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = tmp_path / "hardware.rec"
    Recorder(file, RecordingHeader(("f",), ("N",), ("q",), ("rad",), 1, 1e-3)).close()
    assert "contains no states to replay" in cardsflow.error_line("replay-hardware", file, *FREE)


@pytest.mark.slow
def test_truncated_recording_causes_a_warning(
    recorded: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = tmp_path / "hardware.rec"
    file.write_bytes(recorded.read_bytes()[:-7])
    code, _, err = cardsflow("replay-hardware", file, *FREE, "--duration", 0.01)
    assert code == 0
    assert "the last 161 bytes are an incomplete record" in err


class StillRobot:
    """Robot that does not move."""

    commands, states = 1, 2

    def apply(self, command: np.ndarray) -> None: ...

    def advance(self, dt: float) -> None: ...

    def state(self) -> np.ndarray:
        return np.zeros(2)

    def safe(self) -> None: ...

    def reset(self) -> None: ...


def test_state_change_is_reported_once() -> None:
    device = Device(StillRobot(), 1, 1e-3, f_min=0.0, f_max=1.0)
    events: list[Event] = []
    status = StatusReporter(device, events.append)
    device.go_safe()
    for _ in range(3):
        status.update()
    assert events == []
    for _ in range(3):
        device.counters["busy"] += 1
        status.update()
    assert [event.state for event in events] == ["rejected"]
    assert str(events[0]) == "run 00000000 rejected: another run uses it; end that run first"
