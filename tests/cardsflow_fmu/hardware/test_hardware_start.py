"""Start of runs with hardware: the first exchanges after the handshake."""

from __future__ import annotations

import numpy as np
import pytest
from support.hardware.virtual_link import World, live_in
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.emulator.faults import FaultyLine
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange_statistics import exchange_statistics
from cardsflow_fmu.hardware.session.connect import Connection, make_session
from cardsflow_fmu.hardware.session.session import HardwareSession
from cardsflow_fmu.results.verdict import failure, problems
from cardsflow_fmu.simulation.run import simulate

LOADING = 2.0
"""Time from the handshake to the first step, in [s]: a host loads other FMUs."""
PULL = np.full(4, 90.0)


def late_session(monkeypatch: pytest.MonkeyPatch, outage: float) -> tuple[World, HardwareSession]:
    """Return a session whose first frames are lost."""
    settings = {"hardware.use": True, "hardware.ramp_in": 0.0}
    experiment = Experiment.load(PLANAR_2R, settings)
    world = World(experiment, Faults())
    live_in(monkeypatch, world)
    session = make_session(experiment, Connection("virtual:"))
    session.open()
    world.line = FaultyLine(world.device, Faults(outages=((0.0, outage),)))
    world.sleep(LOADING)
    return world, session


def test_control_begins_on_a_new_state_if_the_first_exchange_is_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world, session = late_session(monkeypatch, outage=2.5e-3)
    session.exchange(0.0, PULL)
    assert session.missed > 0
    assert session.age <= 2 * session.step
    first = world.robot.applied[0][1]
    assert first.max() < PULL[0]  # the forces that hold the robot, since the last state was old
    session.exchange(session.step, PULL)
    np.testing.assert_array_equal(world.robot.applied[-1][1], PULL)
    session.end()


def test_a_run_without_a_first_answer_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    _, session = late_session(monkeypatch, outage=1.0)
    with pytest.raises(HardwareError, match="no state in 11 exchanges"):
        session.exchange(0.0, PULL)


@pytest.mark.parametrize(
    ("missed", "warns", "fails"), [(10, 0, False), (11, 1, False), (201, 1, True)]
)
def test_many_missed_exchanges_are_a_warning_or_a_failure(
    missed: int, warns: int, fails: bool
) -> None:
    summary = {"hardware": {"missed": missed, "exchanges": 1000}}
    assert len(problems(summary)) == warns
    failed = f"{missed} of 1000 exchanges with the hardware missed" if fails else None
    assert failure(summary) == failed


def test_a_late_computer_is_reported_when_the_device_is_safe(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The device enters its safe state since the computer of the controller was late by 80 ms."""
    world, session = late_session(monkeypatch, outage=1e-4)
    session.exchange(0.0, PULL)
    session.exchange(session.step, PULL)
    world.sleep(0.08)
    with pytest.raises(HardwareError, match="started steps late by up to") as caught:
        for k in range(2, 5):
            session.exchange(k * session.step, PULL)
    late = float(str(caught.value).split("late by up to ")[1].split()[0])
    assert 79.0 <= late <= 80.0
    assert "entered its safe state" in str(caught.value)


def test_steps_on_old_states_are_counted() -> None:
    """States older than two steps, without the state before the run."""
    columns = {
        "time": 1e-3 * np.arange(5),
        "missed": np.array([0.0, 0.0, 1.0, 2.0, 2.0]),
        "round_trip_time": np.full(5, 2e-4),
        "clamped": np.zeros(5),
        "age": 1e-3 * np.array([9.0, 0.9, 1.9, 2.9, 0.9]),
    }
    hardware = exchange_statistics(columns)["hardware"]
    assert (hardware["exchanges"], hardware["old_states"]) == (4, 1)
    assert hardware["oldest_state"] == pytest.approx(2.9e-3)


@pytest.mark.parametrize("bound", [100.0, 20.0])
def test_the_summary_counts_clamped_commands(monkeypatch: pytest.MonkeyPatch, bound: float) -> None:
    """The device has a lower maximum force than the controller."""
    settings = {"hardware.use": True, "hardware.link": "virtual:", "run.duration": 0.1}
    experiment = Experiment.load(PLANAR_2R, settings)
    world = World(experiment, Faults())
    world.device._upper[:] = bound
    live_in(monkeypatch, world)
    hardware = simulate(experiment, coupling="direct").summary["hardware"]
    assert hardware["exchanges"] == 100
    assert (hardware["clamped"] > 0) == (bound < 100.0)
    assert hardware["watchdog_expired"] is False
