"""Faults of a communication line, and their effect on runs, forces and devices."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from support.hardware.virtual_link import INTRUDER, World, live_in
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.emulator.faults import FaultyChannel
from cardsflow_fmu.hardware.protocol.frame import Frame, Kind, pack, unpack
from cardsflow_fmu.hardware.protocol.handshake import ErrorCode, Handshake
from cardsflow_fmu.simulation.run import RunError, simulate

FRAMES = 4000
STEP = 1e-3


def sent_through(faults: Faults, direction: str = "in") -> tuple[FaultyChannel, list, list]:
    """Send one frame per step. Return the arrivals as (time, number) and as (time, frame)."""
    channel = FaultyChannel(faults, direction)
    arrived = []
    for k in range(FRAMES):
        channel.send(b"%08d" % k, "peer", k * STEP)
        while channel.next_due <= (k + 1) * STEP:
            at = channel.next_due
            arrived += [(at, data) for data, _ in channel.due(at)]
    arrived += [(math.inf, data) for data, _ in channel.due(math.inf)]
    numbers = [(at, int(data)) for at, data in arrived if len(data) == 8 and data.isdigit()]
    return channel, numbers, arrived


def numbers_of(arrivals: Sequence[tuple[float, int]]) -> list[int]:
    return [number for _, number in arrivals]


def test_a_channel_without_faults_changes_nothing() -> None:
    channel, arrivals, _ = sent_through(Faults())
    assert numbers_of(arrivals) == list(range(FRAMES))
    assert [at for at, _ in arrivals] == [k * STEP for k in range(FRAMES)]
    assert channel.counters["delivered"] == FRAMES
    assert not Faults().any
    assert Faults(outages=((0.0, 1.0),)).any


@pytest.mark.parametrize("loss", [0.01, 0.05, 0.2, 1.0])
def test_the_loss_is_the_fraction_of_lost_frames(loss: float) -> None:
    channel, arrivals, _ = sent_through(Faults(loss=loss))
    spread = math.sqrt(FRAMES * loss * (1 - loss))
    assert channel.counters["lost"] == pytest.approx(FRAMES * loss, abs=4 * spread)
    assert len(arrivals) == FRAMES - channel.counters["lost"]
    assert numbers_of(arrivals) == sorted(numbers_of(arrivals))


def test_frames_are_late_by_delay_and_jitter() -> None:
    _, arrivals, _ = sent_through(Faults(delay=2e-3, jitter=5e-3))
    late = np.array([at - k * STEP for at, k in arrivals if math.isfinite(at)])
    assert late.min() >= 2e-3 - 1e-12
    assert late.max() <= 7e-3 + 1e-12
    assert np.mean(late) == pytest.approx(4.5e-3, rel=0.05)
    assert numbers_of(arrivals) != sorted(numbers_of(arrivals))
    assert sorted(numbers_of(arrivals)) == list(range(FRAMES))


def test_frames_are_duplicated() -> None:
    channel, arrivals, _ = sent_through(Faults(duplicate=0.1))
    numbers = numbers_of(arrivals)
    assert len(numbers) == FRAMES + channel.counters["duplicated"]
    assert channel.counters["duplicated"] == pytest.approx(0.1 * FRAMES, rel=0.2)
    assert sorted(set(numbers)) == list(range(FRAMES))


def test_frames_are_overtaken_by_the_next() -> None:
    channel, arrivals, _ = sent_through(Faults(reorder=0.1))
    numbers = numbers_of(arrivals)
    assert sorted(numbers) == list(range(FRAMES))
    behind = sum(after < before for before, after in itertools.pairwise(numbers))
    assert behind in (channel.counters["overtaken"], channel.counters["overtaken"] - 1)
    assert behind == pytest.approx(0.1 * FRAMES, rel=0.2)


def test_a_frame_that_is_not_overtaken_still_arrives() -> None:
    channel = FaultyChannel(Faults(reorder=1.0))
    channel.send(b"alone", "peer", 5.0)
    assert channel.due(5.0) == []
    assert channel.next_due == pytest.approx(5.01)
    assert channel.due(channel.next_due) == [(b"alone", "peer")]
    assert channel.next_due == math.inf


def test_damaged_frames_differ_from_the_sent_ones() -> None:
    channel, _, arrived = sent_through(Faults(corrupt=1.0))
    assert channel.counters["damaged"] == FRAMES
    assert all(data != b"%08d" % k for k, (_, data) in enumerate(arrived))
    lengths = {len(data) for _, data in arrived}
    assert min(lengths) == 0
    assert max(lengths) == 16


def test_all_frames_are_lost_during_an_outage() -> None:
    _, arrivals, _ = sent_through(Faults(outages=((0.5, 0.2), (2.0, 0.1))))
    missing = sorted(set(range(FRAMES)) - set(numbers_of(arrivals)))
    assert missing == [*range(500, 700), *range(2000, 2100)]


@pytest.mark.slow
def test_equal_seeds_result_in_equal_faults() -> None:
    chances = dict.fromkeys(("loss", "duplicate", "reorder", "corrupt"), 0.1)
    some = {"delay": 1e-3, "jitter": 2e-3, **chances}
    faults = Faults(**some, seed=4)
    assert sent_through(faults)[2] == sent_through(faults)[2]
    assert sent_through(faults)[2] != sent_through(faults, "out")[2]
    other = Faults(**some, seed=5)
    assert sent_through(faults)[2] != sent_through(other)[2]


SETTINGS = {
    "run.duration": 0.35,
    "hardware.link": "virtual:",
    "hardware.ramp_in": 0.0,
    "hardware.ramp_down": 0.05,
}
RAMP_DOWN_STEPS = 50
ALL = Faults(loss=0.05, delay=1e-4, jitter=2e-3, duplicate=0.05, reorder=0.05, corrupt=0.05, seed=3)
KEY = b"a key of sixteen bytes or more"


@pytest.fixture(scope="module")
def plant_run() -> Result:
    """Run the arm with its plant."""
    return simulate(Experiment.load(PLANAR_2R, SETTINGS), coupling="direct")


@pytest.fixture(scope="module")
def late_run() -> Result:
    """Run the arm with its plant and a delay of one step, as with hardware."""
    late = Experiment.load(PLANAR_2R, SETTINGS | {"controller.delay": 1})
    return simulate(late, coupling="direct")


def load(**changes: object) -> Experiment:
    hardware = {f"hardware.{key}": value for key, value in changes.items()}
    return Experiment.load(PLANAR_2R, SETTINGS | {"hardware.use": True} | hardware)


@pytest.fixture(params=["unsigned", "signed"])
def key_file(request: pytest.FixtureRequest, tmp_path: Path) -> dict[str, str]:
    """Return the settings for unsigned and signed frames."""
    if request.param == "unsigned":
        return {}
    (tmp_path / "key.bin").write_bytes(KEY)
    (tmp_path / "key.bin").chmod(0o600)
    return {"key_file": str(tmp_path / "key.bin")}


def world_of(
    monkeypatch: pytest.MonkeyPatch,
    experiment: Experiment,
    faults: Faults,
    events: dict[float, Callable[[World], None]] | None = None,
) -> World:
    world = World(experiment, faults, KEY if experiment.hardware.key_file else None, events)
    live_in(monkeypatch, world)
    return world


def rows_of(result: Result) -> np.ndarray:
    """Return the columns that runs with hardware and runs with the plant have in common."""
    robot = result.experiment.robot
    signals = [muscle_signals(prefix, robot) for prefix in ("f", "l")]
    signals += [coordinate_signals(prefix, robot) for prefix in ("q", "qd")]
    return result.columns([name for names in signals for name in names])


def rms(result: Result) -> float:
    return float(result.summary["tracking"]["rms"])


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "key_file"),
    [
        (Faults(), "unsigned"),
        (Faults(loss=0.01), "unsigned"),
        (Faults(loss=0.05), "unsigned"),
        (Faults(loss=0.2), "unsigned"),
        (Faults(jitter=5e-3), "unsigned"),
        (Faults(duplicate=0.3), "unsigned"),
        (Faults(reorder=0.2), "unsigned"),
        (Faults(corrupt=0.2), "unsigned"),
        (Faults(corrupt=0.2), "signed"),
        (Faults(outages=((0.05, 0.2),)), "unsigned"),
        (ALL, "signed"),
    ],
    indirect=["key_file"],
)
def test_in_lockstep_faults_do_not_change_a_trajectory(
    monkeypatch: pytest.MonkeyPatch, plant_run: Result, faults: Faults, key_file: dict[str, str]
) -> None:
    """The run equals a run with the plant, since lost frames are repeated and copies ignored."""
    experiment = load(mode="lockstep", **key_file)
    world = world_of(monkeypatch, experiment, faults)
    result = simulate(experiment, coupling="direct")
    np.testing.assert_array_equal(rows_of(result), rows_of(plant_run))
    assert result["missed"][-1] == 0
    beyond = len(world.robot.applied) - experiment.run.steps
    assert 0 < beyond <= RAMP_DOWN_STEPS
    assert world.device.state == "safe"


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "most_missed", "key_file"),
    [
        (Faults(), 0.0, "unsigned"),
        (Faults(), 0.0, "signed"),
        (Faults(loss=0.01), 0.04, "unsigned"),
        (Faults(loss=0.05), 0.14, "unsigned"),
        (Faults(loss=0.2), 0.45, "unsigned"),
        (Faults(delay=1e-4, jitter=5e-3), 0.75, "unsigned"),
        (Faults(duplicate=0.3), 0.0, "unsigned"),
        (Faults(reorder=0.1), 0.3, "unsigned"),
        (Faults(corrupt=0.1), 0.25, "unsigned"),
        (ALL, 0.8, "signed"),
    ],
    indirect=["key_file"],
)
def test_in_real_time_a_run_tolerates_faults_of_a_few_steps(
    monkeypatch: pytest.MonkeyPatch,
    late_run: Result,
    faults: Faults,
    most_missed: float,
    key_file: dict[str, str],
) -> None:
    """`World` checks force limits and the watchdog at each event."""
    experiment = load(**key_file)
    world = world_of(monkeypatch, experiment, faults)
    result = simulate(experiment, coupling="direct")
    assert result.complete
    assert result["missed"][-1] <= most_missed * experiment.run.steps
    assert not world.device.failure
    assert world.device.state == "safe"
    assert rms(result) < (1e-4 if most_missed == 0 else 2 * rms(late_run))


@pytest.mark.slow
def test_measurements_in_real_time_are_one_step_old(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces at time t belong to the state measured at t - h."""
    experiment = load()
    world = world_of(monkeypatch, experiment, Faults())
    result = simulate(experiment, coupling="direct")
    assert np.all(result["q.joint_1"][:2] == experiment.start.q[0])
    assert world.robot.applied[1][0] - world.robot.applied[0][0] == pytest.approx(STEP)
    np.testing.assert_allclose(result["age"][1:], 0.0, atol=1e-9)


@pytest.mark.slow
def test_the_device_is_safe_within_its_watchdog_time_after_an_outage_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The controller side ends after `max_missed` states, the device by its watchdog."""
    experiment = load()
    world = world_of(monkeypatch, experiment, Faults(outages=((0.1, 0.2),)))
    with pytest.raises(
        RunError, match="the hardware does not respond: no state in 11 exchanges"
    ) as error:
        simulate(experiment, coupling="direct")
    result = error.value.result
    assert result.summary["status"] == "incomplete"
    assert result["time"][-1] == pytest.approx(0.11, abs=2 * STEP)
    last, _ = world.robot.applied[-1]
    world.sleep(last + world.device.watchdog + 1e-6 - world.now)
    assert world.device.state == "safe"
    assert world.device.counters["watchdog"] == 1
    world.sleep(2 * STEP)
    np.testing.assert_array_equal(world.robot.tension, world.robot.bounds[0])


@pytest.mark.slow
def test_a_run_with_a_large_max_missed_ends_when_the_device_is_safe(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    experiment = load(max_missed=1000)
    world = world_of(monkeypatch, experiment, Faults(outages=((0.1, 0.2),)))
    with pytest.raises(RunError, match="the device has entered its safe state") as error:
        simulate(experiment, coupling="direct")
    assert error.value.result["time"][-1] == pytest.approx(0.3, abs=5e-3)
    again = simulate(experiment, coupling="direct")
    assert again.complete
    assert again["q.joint_1"][0] == experiment.start.q[0]
    assert world.device.counters["runs"] == 2


@pytest.mark.slow
def test_a_run_whose_hardware_does_not_respond_at_the_end_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The run has all rows, but the device may not have received the last commands."""
    experiment = load(max_missed=1000)
    world_of(monkeypatch, experiment, Faults(outages=((0.3, 10.0),)))
    with pytest.raises(
        RunError, match=r"did not respond at the end: the newest state is 0\.0[45]"
    ) as error:
        simulate(experiment, coupling="direct")
    assert error.value.result.summary["status"] == "incomplete"
    world_of(monkeypatch, experiment, Faults(outages=((0.34, 10.0),)))
    assert simulate(
        experiment, coupling="direct"
    ).complete  # a gap this short does not trigger the watchdog


@pytest.mark.slow
def test_a_device_that_has_restarted_needs_a_new_run(
    monkeypatch: pytest.MonkeyPatch, key_file: dict[str, str]
) -> None:
    experiment = load(**key_file)
    world = world_of(monkeypatch, experiment, Faults(), {0.1: World.restart})
    with pytest.raises(RunError, match="the hardware does not respond"):
        simulate(experiment, coupling="direct")
    assert world.device.state == "idle"
    assert world.device.counters["signature" if key_file else "run"] >= 11
    assert world.robot.applied == []
    assert simulate(experiment, coupling="direct").complete


@pytest.mark.slow
def test_a_second_sender_is_rejected_without_effect(
    monkeypatch: pytest.MonkeyPatch, key_file: dict[str, str]
) -> None:
    """It sends a HELLO, copied set points of the run, and a STOP."""

    def intrude(world: World) -> None:
        device = world.device
        handshake = pack(Frame(Kind.HELLO, 0, 99, 0, 0.0, 1, 0, device.agreed.values()), world.key)
        for kind, run in ((Kind.SETPOINT, 99), (Kind.SETPOINT, device.run_id), (Kind.STOP, 99)):
            frame = Frame(kind, 0, run, 10_000, 0.0, 1, 0, [100.0] * 4)
            world.line.send(pack(frame, world.key), INTRUDER, world.now)
        stop = Frame(Kind.STOP, 0, device.run_id, 0, 0.0, 1, 0, ())
        world.line.send(pack(stop), INTRUDER, world.now)
        world.line.send(handshake, INTRUDER, world.now)

    experiment = load(**key_file)
    events = {0.05 + k * 0.01: intrude for k in range(10)}
    intruded = world_of(monkeypatch, experiment, Faults(), events)
    disturbed = simulate(experiment, coupling="direct")
    world_of(monkeypatch, experiment, Faults())
    alone = simulate(experiment, coupling="direct")
    np.testing.assert_array_equal(rows_of(disturbed), rows_of(alone))
    answers = [unpack(data, intruded.key) for data in intruded.intruders]
    assert [(a.kind, a.values[0]) for a in answers] == [(Kind.ERROR, ErrorCode.BUSY)] * 10
    assert intruded.device.counters["busy"] == 10


@pytest.mark.slow
def test_damaged_and_forged_frames_are_dropped() -> None:
    """A running device receives 10,000 of them; `World` checks the device."""
    world = World(load(), Faults(corrupt=1.0, seed=1))
    handshake = Handshake(world.device.signature, STEP, 1.0, 0.02, 4, 12, False)
    device, answers = world.device, []
    answers += device.receive(
        pack(Frame(Kind.HELLO, 0, 7, 0, 0.0, 1, 0, handshake.values())), "us", 0
    )
    good = pack(Frame(Kind.SETPOINT, 0, 7, 1, 0.0, 1, 0, [50.0] * 4))
    answers += device.receive(good, "us", 0.0)
    assert len(answers) == 2
    chance = np.random.default_rng(2)
    for k in range(5000):
        frame = Frame(Kind.SETPOINT, 0, 7, 2 + k, 0.0, 1, 0, chance.uniform(0, 100, 4))
        world.line.send(pack(frame), "us", 0.0)
        world.line.send(chance.bytes(int(chance.integers(0, 200))), "us", 0.0)
        assert world.line.due(0.0) == []
    assert len(world.robot.applied) == 1
    assert device.state == "running"
    assert device.counters["received"] == 10_002
