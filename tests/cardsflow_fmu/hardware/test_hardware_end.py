"""However a host ends hardware.fmu by FMI calls, the robot enters its safe state."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from support.cases import sample_cases
from support.fmu.fmu_host import Host, load, require_error
from support.process_output import wait_until
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.server import DeviceServer
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.links import framed_link
from cardsflow_fmu.hardware.session.session import RUNNING, STOPPED, HardwareSession
from cardsflow_fmu.simulation.build import build

FMI = ("2.0", "3.0")
H = 1e-3
RAMP = 10
"""Number of steps of the ramp down."""
SETTINGS = {
    "hardware.mode": "lockstep",
    "hardware.timeout": 60.0,
    "hardware.ramp_in": 0.0,
    "hardware.ramp_down": RAMP * H,
    "hardware.use": True,
}
HOLDING_FORCES = [41.0, 10.0, 10.0, 14.0]
in_both_hosts = pytest.mark.parametrize(
    "bench", sample_cases(["in-process", "worker"]), indirect=True
)


class Bench:
    """Device, instance of hardware.fmu, and the commands that the robot has received."""

    def __init__(self, device: Device, host: Host, references: dict[str, int]) -> None:
        self.device, self.host, self._references = device, host, references
        self.commands: list[np.ndarray] = []
        self._is_free = False
        apply = device.robot.apply

        def noted(command: np.ndarray) -> None:
            self.commands.append(command.copy())
            apply(command)

        device.robot.apply = noted  # type: ignore[method-assign]

    def start(self) -> None:
        self.host.slave.setupExperiment(startTime=0.0)
        self.host.slave.enterInitializationMode()
        self.host.slave.exitInitializationMode()

    def steps(self, count: int) -> None:
        names = [name for name in self._references if name == "f" or name.startswith("f.")]
        forces = [self._references[name] for name in names]
        for k in range(count):
            self.host.slave.setReal(forces, HOLDING_FORCES)
            self.host.slave.doStep(k * H, H)

    def free(self) -> None:
        """Free the instance, once."""
        if not self._is_free:
            self._is_free = True
            self.host.slave.freeInstance()

    def mode(self) -> float:
        return float(self.host.slave.getReal([self._references["mode"]])[0])

    def positions(self) -> list[float]:
        """Return the joint positions: two scalars in FMI 2.0, an array in FMI 3.0."""
        if "q" in self._references:
            return list(self.host.slave.getFloat64([self._references["q"]], 2))
        return list(self.host.slave.getReal([self._references[f"q.joint_{k}"] for k in (1, 2)]))


@pytest.fixture(scope="module")
def file(fmi: FmiVersion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the hardware.fmu of the arm."""
    made = Experiment.load(PLANAR_2R, SETTINGS)
    return build(made, tmp_path_factory.mktemp("fmus"), fmi=fmi)["hardware"]


@pytest.fixture
def bench(
    request: pytest.FixtureRequest,
    file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Bench]:
    """Yield a run in progress in this process, or in a worker if a test requests it."""
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", getattr(request, "param", "in-process"))
    monkeypatch.setattr(framed_link, "_STOP_PERIOD", 60.0)  # a pause does not repeat a stop
    made = Experiment.load(PLANAR_2R, SETTINGS)
    device, over = emulated_device(made, made.hardware), threading.Event()
    with DeviceServer(device, "udp://127.0.0.1:0") as server:
        thread = threading.Thread(target=server.run, args=(over.is_set,))
        thread.start()
        monkeypatch.setenv("CARDSFLOW_HARDWARE_LINK", server.uri)
        folder = tmp_path / "fmu"
        fmpy.extract(str(file), str(folder))
        variables = fmpy.read_model_description(str(folder)).modelVariables
        host = load(folder)
        host.open(False)
        bench = Bench(device, host, {v.name: v.valueReference for v in variables})
        try:
            bench.start()
            bench.steps(3)
            assert device.state == "running"
            yield bench
        finally:
            bench.free()
            over.set()
            thread.join()


def has_ended_safely(bench: Bench) -> bool:
    """Return whether the forces were ramped down linearly and the device was then stopped."""
    first = np.array([command[0] for command in bench.commands[-RAMP:]])
    expected = 10.0 + 31.0 * np.arange(RAMP - 1, -1, -1) / RAMP
    return (
        bench.device.state == "safe"
        and bench.device.counters["stops"] > 0
        and len(bench.commands) == 3 + RAMP
        and np.allclose(first, expected, rtol=0.0, atol=1e-12)
    )


@pytest.mark.slow
@in_both_hosts
def test_terminate_ends_in_the_safe_state(bench: Bench) -> None:
    bench.host.slave.terminate()
    assert has_ended_safely(bench)


@pytest.mark.slow
def test_outputs_can_be_read_after_terminate(bench: Bench) -> None:
    bench.host.slave.terminate()
    assert bench.mode() == STOPPED
    assert bench.positions() == bench.device.robot.state()[:2].tolist()


@in_both_hosts
def test_free_without_terminate_ends_in_the_safe_state(bench: Bench) -> None:
    bench.free()
    assert has_ended_safely(bench)


def test_terminate_and_free_stop_once(bench: Bench) -> None:
    bench.host.slave.terminate()
    bench.host.slave.reset()
    assert has_ended_safely(bench)
    assert bench.device.counters["stops"] == 1


@in_both_hosts
def test_a_reset_after_terminate_allows_a_new_run(bench: Bench) -> None:
    bench.host.slave.terminate()
    bench.host.slave.reset()
    bench.start()
    bench.steps(2)
    assert bench.device.state == "running"
    assert bench.device.counters["runs"] == 2
    assert bench.mode() == RUNNING


@in_both_hosts
def test_terminate_after_a_failure_ends_in_the_safe_state(bench: Bench) -> None:
    """An invalid step fails in C before it reaches the model; terminate is then rejected."""
    require_error(lambda: bench.host.slave.doStep(7.0, H))
    assert bench.device.state == "running"
    require_error(bench.host.slave.terminate)
    assert has_ended_safely(bench)


def test_free_without_initialisation_is_allowed(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There is no communication before the initialization."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        silent.setblocking(False)
        monkeypatch.setenv("CARDSFLOW_HARDWARE_LINK", f"udp://127.0.0.1:{silent.getsockname()[1]}")
        fmpy.extract(str(file), str(tmp_path / "fmu"))
        host = load(tmp_path / "fmu")
        host.open(False)
        host.slave.freeInstance()
        with pytest.raises(BlockingIOError):
            silent.recv(1)


def test_terminate_returns_when_the_device_is_gone(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In lockstep a step waits for an answer; a missing device is not an error here."""
    monkeypatch.setattr(HardwareSession, "_deadline", lambda self: time.monotonic() + 0.1)
    monkeypatch.setattr(framed_link, "_STOP_PERIOD", 0.01)
    bench.device.receive = lambda *anything: []  # type: ignore[method-assign]
    bench.host.slave.terminate()
    assert bench.mode() == STOPPED


@pytest.mark.slow
def test_the_master_terminates_instances_that_have_not_failed(
    bench: Bench, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """External FMUs may need it. An instance that has failed is only freed."""
    bench.host.slave.terminate()
    asked: list[str] = []
    for fails in (False, True):
        instance = FmuInstance("hardware", file, tmp_path / f"own {fails}")
        calls: Any = instance._calls
        terminate = calls.terminate
        monkeypatch.setattr(calls, "terminate", lambda t=terminate: asked.append("asked") or t())
        if fails:
            with pytest.raises(Exception, match="starts at 5 s"):
                instance.step(5.0, H)
        instance.close()
        assert wait_until(lambda: bench.device.state == "safe")
    assert asked == ["asked"]


def test_terminate_is_called_once(bench: Bench) -> None:
    bench.host.slave.terminate()
    with pytest.raises(FMICallException):
        bench.host.slave.terminate()
    assert bench.device.counters["stops"] == 1
