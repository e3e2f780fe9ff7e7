"""Hardware model: ports and trajectories of the plant, and a safe end of every run."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from support.robots.plants import copies
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import Flag
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.session import connect as connect
from cardsflow_fmu.hardware.session.safety import TripError
from cardsflow_fmu.hardware.session.session import (
    HOLDING,
    RUNNING,
    STARTING,
    STOPPED,
    HardwareSession,
)
from cardsflow_fmu.models.hardware import HardwareModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import simulate

FMI = ("2.0", "3.0")
ARM = EXAMPLES / "roboy_left_arm"
IN_PROCESS = {"hardware.link": "loopback:", "hardware.use": True}
LOCKSTEP = IN_PROCESS | {
    "hardware.mode": "lockstep",
    "hardware.ramp_in": 0.0,
    "hardware.timeout": 60.0,
}
HOLDING_FORCES = np.array([41.0, 10.0, 10.0, 14.0])


def experiment(settings: dict[str, Any] | None = None, folder: Path = PLANAR_2R) -> Experiment:
    return Experiment.load(folder, LOCKSTEP | {"run.duration": 0.1} | (settings or {}))


@pytest.fixture
def devices(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Device]]:
    """Collect the devices created in this process; all must be safe at the end."""
    made: list[Device] = []

    def make(*arguments: Any) -> Device:
        made.append(emulated_device(*arguments))
        return made[-1]

    monkeypatch.setattr(connect, "emulated_device", make)
    yield made
    gc.collect()
    assert all(device.state in ("idle", "safe") for device in made)


def stepped(model: HardwareModel, steps: int, forces: Any = HOLDING_FORCES) -> HardwareModel:
    h = 1e-3
    for k in range(steps):
        model.inputs[:4] = forces
        model.step(k * h, h)
    return model


def started(settings: dict[str, Any] | None = None) -> HardwareModel:
    model = HardwareModel(experiment(settings))
    model.initialize()
    return model


def output(model: HardwareModel, name: str) -> float:
    return float(model.values[[port.name for port in model.ports].index(name)])


@pytest.mark.parametrize("folder", [PLANAR_2R, ARM])
def test_the_ports_are_the_ports_of_the_plant_and_diagnostics(folder: Path) -> None:
    own = HardwareModel.table(experiment(folder=folder))
    plants = PlantModel.table(experiment(folder=folder))
    kept = [port for port in own if port in plants]
    assert kept == plants  # names, units, causalities, variabilities, starts, order
    others = [port for port in own if port not in plants]
    assert {port.causality for port in others} == {"output"}
    muscles = [port.name[2:] for port in plants if port.name.startswith("f.")]
    assert [port.name for port in others] == [
        *(f"tension.{muscle}" for muscle in muscles),
        *("age", "missed", "round_trip_time", "lateness", "mode", "clamped"),
    ]


@pytest.mark.slow
def test_the_fmu_declares_no_states_or_derivatives(tmp_path: Path, fmi: FmiVersion) -> None:
    files = build(experiment(), tmp_path, fmi=fmi)
    flags = fmpy.read_model_description(str(files["hardware"])).coSimulation
    assert not flags.canGetAndSetFMUstate
    assert not flags.canSerializeFMUstate
    assert not flags.canHandleVariableCommunicationStepSize
    assert not flags.providesDirectionalDerivative
    assert fmpy.read_model_description(str(files["plant"])).coSimulation.canGetAndSetFMUstate


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("host", ["direct", "in-process", "worker"])
def test_in_lockstep_hardware_has_the_trajectory_of_the_plant(
    host: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "worker" if host == "worker" else "in-process")
    way = "direct" if host == "direct" else "python"
    with_hardware = simulate(experiment(), **RUN_MODES[way])
    ours = simulate(experiment({"hardware.use": False}), **RUN_MODES[way])
    for name in ours.names:
        np.testing.assert_allclose(with_hardware[name], ours[name], rtol=0, atol=1e-9, err_msg=name)
    np.testing.assert_array_equal(
        with_hardware["tension.cable_1"][1:], with_hardware["f.cable_1"][:-1]
    )
    assert with_hardware.summary["hardware"]["missed"] == 0


@pytest.mark.cases(6)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "settings"),
    [
        (PLANAR_2R, {"plant.step": 0.00025, "controller.period": 0.002}),
        (PLANAR_2R, {"plant.mass_scale": 1.3, "controller.delay": 1}),
        (PLANAR_2R, {"disturbance": {"force": {"tip": [20.0, 0.0, 5.0]}, "begin": 0.02}}),
        (PLANAR_2R, {"hardware.motors": {"command": "length", "stiffness": 5000.0}}),
        (PLANAR_2R, {"hardware.motors": {"command": "velocity", "stiffness": 8000.0}}),
        (
            PLANAR_2R,
            {
                "hardware.motors": {
                    "command": "length",
                    "stiffness": 5000.0,
                    "damping": 3.0,
                    "spindle_radius": 0.015,
                    "encoder_scale": 651.9,
                    "offset": "start",
                }
            },
        ),
        (PLANAR_2R, {"hardware.scale": 100.0, "hardware.has_lengths": False}),
        (ARM, {"run.step": 0.002, "controller.period": 0.004, "plant.step": 0.001}),
    ],
)
def test_in_lockstep_the_trajectory_is_the_same_with_other_steps_and_motors(
    folder: Path, settings: dict[str, Any]
) -> None:
    length = {"run.duration": 0.04}
    with_hardware = simulate(
        experiment(settings | length, folder), compute="python", coupling="direct"
    )
    alone = settings | length | {"hardware.use": False}
    ours = simulate(experiment(alone, folder), compute="python", coupling="direct")
    for name in ours.names:
        np.testing.assert_allclose(
            with_hardware[name], ours[name], rtol=1e-9, atol=1e-9, err_msg=name
        )


@pytest.mark.slow
def test_a_step_of_the_master_may_be_several_exchanges(devices: list[Device]) -> None:
    fine, coarse = started(), started()
    stepped(fine, 4)
    coarse.inputs[:4] = HOLDING_FORCES
    coarse.step(0.0, 0.004)
    np.testing.assert_array_equal(coarse.outputs[:8], fine.outputs[:8])
    with pytest.raises(InputError, match="not a whole multiple of the step agreed"):
        coarse.step(0.004, 0.0015)


def test_without_measured_tensions_there_are_no_tension_ports() -> None:
    names = [p.name for p in HardwareModel.table(experiment({"hardware.has_tensions": False}))]
    assert not [name for name in names if name.startswith("tension")]
    model = stepped(started({"hardware.has_tensions": False}), 3)
    assert output(model, "mode") == RUNNING
    model.close()


@pytest.mark.slow
def test_the_robot_does_not_move_before_the_first_step(devices: list[Device]) -> None:
    model = started()
    assert devices[0].state == "ready"
    assert output(model, "mode") == STARTING
    assert output(model, "q.joint_1") == -0.5
    stepped(model, 1)
    assert devices[0].state == "running"


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("how", ["close", "forget", "reset", "trip", "bad step"])
def test_every_end_is_in_the_safe_state(devices: list[Device], how: str) -> None:
    model = stepped(started({"hardware.ramp_down": 0.02}), 3)
    device = devices[0]
    commands: list[np.ndarray] = []
    device.robot.apply = lambda f: commands.append(f.copy())  # type: ignore[method-assign]
    if how == "close":
        model.close()
    elif how == "forget":
        del model
    elif how == "reset":
        model.reset()
    elif how == "trip":
        model.inputs[0] = math.nan
        with pytest.raises(TripError):
            model.step(0.003, 1e-3)
    else:
        with pytest.raises(InputError):
            model.step(0.003, 0.00123)
        model.close()
    assert device.state == "safe"
    if how == "trip":
        assert not commands
        return
    first = np.array([c[0] for c in commands])  # from 41 N to f_min, 10 N
    np.testing.assert_allclose(first, 10.0 + 31.0 * np.arange(19, -1, -1) / 20)


@pytest.mark.slow
def test_a_reset_connects_again(devices: list[Device]) -> None:
    model = stepped(started({"hardware.ramp_down": 0.0}), 5)
    end = model.outputs[:8].copy()
    model.reset()
    model.initialize()
    np.testing.assert_array_equal(stepped(model, 5).outputs[:8], end)
    assert len(devices) == 2
    model.close()


@pytest.mark.slow
def test_only_a_reset_is_allowed_after_an_error(devices: list[Device]) -> None:
    model = started()
    with pytest.raises(TripError):
        stepped(model, 1, math.nan)
    assert output(model, "mode") == STOPPED
    with pytest.raises(HardwareError, match="has been stopped; reset to connect again"):
        stepped(model, 1)
    model.reset()
    model.initialize()
    stepped(model, 1)
    model.close()


@pytest.mark.slow
def test_freeing_the_fmu_ends_in_the_safe_state(devices: list[Device], tmp_path: Path) -> None:
    """The FMI calls of any host: terminate, free."""
    file = build(experiment({"hardware.ramp_down": 0.01}), tmp_path / "fmus")["hardware"]
    folder = fmpy.extract(str(file), str(tmp_path / "fmu"))
    description = fmpy.read_model_description(folder)
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="hardware",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    slave.doStep(0.0, 0.001)
    assert devices[0].state == "running"
    slave.terminate()
    slave.freeInstance()
    assert devices[0].state == "safe"
    assert devices[0].counters["setpoints"] == 11
    assert devices[0].counters["stops"] == 1


@pytest.mark.slow
def test_a_robot_far_from_its_start_pose_is_rejected(devices: list[Device]) -> None:
    model = HardwareModel(experiment())
    model.values[[port.name for port in model.ports].index("q_start.joint_2")] = 0.7
    with pytest.raises(
        HardwareError, match=r"'joint_2' is at 0\.5 rad, but the start position is 0\.7"
    ):
        model.initialize()
    assert devices[0].state == "safe"


@pytest.mark.slow
def test_an_exceeded_limit_ends_the_run(devices: list[Device]) -> None:
    model = started({"hardware.max_tension": {"cable_1": 40.0}})
    with pytest.raises(
        TripError, match="the tension of muscle 'cable_1' is 41 N, above its limit of 40 N"
    ):
        stepped(model, 1)
    assert devices[0].state == "safe"
    assert output(model, "mode") == STOPPED
    assert output(model, "tension.cable_1") == 41.0


def test_the_state_of_hardware_cannot_be_saved() -> None:
    model = HardwareModel(experiment())
    for save in (model.get_state, lambda: copies(model)):
        with pytest.raises(InputError, match="cannot be saved"):
            save()
    with pytest.raises(InputError, match="cannot be restored"):
        model.set_state(b"")
    with pytest.raises(InputError, match="call initialize first"):
        model.step(0.0, 1e-3)


def test_hardware_without_an_address_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    model = HardwareModel(Experiment.load(PLANAR_2R))
    with pytest.raises(InputError, match=r"hardware\.link: missing; .*CARDSFLOW_HARDWARE_LINK"):
        model.initialize()
    monkeypatch.setenv("CARDSFLOW_HARDWARE_LINK", "pigeon://coop")
    with pytest.raises(InputError, match="invalid hardware address 'pigeon://coop'"):
        model.initialize()


def test_a_missing_device_is_an_error_after_two_seconds() -> None:
    with pytest.raises(HardwareError, match=r"no device answers at .*\.1:9 within 2 s"):
        started({"hardware.link": "udp://127.0.0.1:9"})


@pytest.mark.slow
def test_in_real_time_a_step_is_paced(devices: list[Device]) -> None:
    patient = {"hardware.watchdog": 10.0, "hardware.max_missed": 10_000}
    model = started(patient | {"hardware.mode": "realtime", "hardware.ramp_down": 0.02})
    begin = time.monotonic()
    stepped(model, 101)
    assert time.monotonic() - begin >= 0.1
    assert devices[0].counters["setpoints"] == 101
    begin = time.monotonic()
    model.close()
    assert time.monotonic() - begin > 0.015


class SilentLink:
    """Link that answers as the test specifies: True for a state, False for no state.

    It is also the clock of its session.
    """

    def __init__(self, answers: list[bool], flags: int = 0) -> None:
        self.run_id, self.counters = 1, {}
        self.agreed: Handshake | None = None
        self.start_state = np.array([-0.5, 0.5, *[0.0] * 2, *[0.3] * 4, *[10.0] * 4])
        self.commands: list[np.ndarray] = []
        self.is_open = False
        self.stops = 0
        self.now = 1000.0
        self._answers, self._flags = iter(answers), flags

    def monotonic(self) -> float:
        return self.now

    def monotonic_ns(self) -> int:
        return round(1e9 * self.now)

    def sleep(self, seconds: float, /) -> None:
        self.now += seconds

    def open(self, handshake: Handshake) -> None:
        self.is_open, self.agreed = True, handshake.with_watchdog(0.015)

    def exchange(self, t: float, command: np.ndarray, deadline: float) -> Exchange:
        assert deadline - self.now < 2.0
        self.commands.append(command.copy())
        if next(self._answers, False):
            return Exchange(self.start_state, len(self.commands), 0.0, 1e-4, self._flags)
        return Exchange(None, 0, 0.5, math.nan, 0)

    def stop(self) -> bool:
        self.stops += 1
        return False

    def close(self) -> None:
        self.is_open = False


def session(link: SilentLink, settings: dict[str, Any] | None = None) -> HardwareSession:
    made = experiment({"hardware.mode": "realtime", "hardware.max_missed": 3} | (settings or {}))
    handshake = Handshake(1, 1e-3, 1.0, 0.02, 4, 12, lockstep=not made.hardware.is_paced)
    one = HardwareSession(made.robot, made.hardware, link, handshake, clock=link)
    one.open()
    return one


def test_missed_states_are_tolerated_and_then_end_the_run() -> None:
    link = SilentLink([True, False, False, False, True, False, False, False, False])
    one = session(link)
    modes = []
    with pytest.raises(HardwareError, match=r"no state in 4 exchanges.*max_missed is 3"):
        for k in range(9):
            one.exchange(1e-3 * k, HOLDING_FORCES)
            modes.append(one.mode)
    assert modes == [RUNNING, *[HOLDING] * 3, RUNNING, *[HOLDING] * 3]
    assert (one.missed, one.mode) == (7, STOPPED)
    assert len(link.commands) == 9  # no ramp if the device does not respond
    assert (link.stops, link.is_open) == (1, False)


def test_a_device_that_enters_its_safe_state_ends_the_run() -> None:
    for flag, message in (
        (Flag.SAFE, r"safe state: no command arrived for 0\.015 s"),
        (Flag.FAULT, "has failed"),
    ):
        one = session(SilentLink([True], int(flag)))
        with pytest.raises(HardwareError, match=message):
            one.exchange(0.0, HOLDING_FORCES)
        assert one.mode == STOPPED


def test_a_missing_answer_in_lockstep_ends_the_run() -> None:
    one = session(SilentLink([False]), {"hardware.mode": "lockstep", "hardware.timeout": 0.5})
    with pytest.raises(HardwareError, match=r"no answer within 0\.5 s in lockstep"):
        one.exchange(0.0, HOLDING_FORCES)


def test_a_ramp_down_without_answers_is_short() -> None:
    link = SilentLink([True] * 5)
    one = session(link, {"hardware.ramp_down": 3.0})
    for k in range(5):
        one.exchange(1e-3 * k, HOLDING_FORCES)
    one.end()
    assert (len(link.commands), link.stops, link.is_open) == (5 + 4, 1, False)
    one.end()
    assert link.stops == 1


def test_a_ramp_down_tolerates_as_many_missed_states_as_a_run() -> None:
    """Otherwise the forces would drop suddenly if the line loses a frame."""
    link = SilentLink([True] * 5 + [False, False, False, True] * 10)
    one = session(link, {"hardware.ramp_down": 0.02})
    for k in range(5):
        one.exchange(1e-3 * k, HOLDING_FORCES)
    one.end()
    first = np.array([command[0] for command in link.commands[5:]])
    np.testing.assert_allclose(first, 10.0 + 31.0 * np.arange(19, -1, -1) / 20)


def test_an_exception_in_a_step_still_ramps_down() -> None:
    link = SilentLink([True] * 100)
    one = session(link, {"hardware.ramp_down": 0.01})
    one.exchange(0.0, HOLDING_FORCES)
    exchange, link.exchange = link.exchange, None  # type: ignore[method-assign, assignment]

    def fail_once(*arguments: Any) -> Exchange:
        link.exchange = exchange  # type: ignore[method-assign]
        raise KeyboardInterrupt

    link.exchange = fail_once  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        one.exchange(1e-3, HOLDING_FORCES)
    assert len(link.commands) == 11
    np.testing.assert_array_equal(link.commands[-1], 10.0)
    assert link.stops == 1


def test_a_session_ends_even_if_the_link_fails() -> None:
    link = SilentLink([True])
    one = session(link)
    one.exchange(0.0, HOLDING_FORCES)

    def broken(*arguments: Any) -> Exchange:
        raise OSError("cable cut")

    link.exchange = broken  # type: ignore[method-assign]
    one.end()
    assert (link.stops, link.is_open) == (1, False)
