"""Hardware without joint encoders and with faults: limits, ramps and ends of runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.hardware import virtual_link
from support.hardware.hardware_devices import KEY
from support.hardware.hardware_fuzz import FRAMES, bad_frames
from support.hardware.virtual_link import WatchedRobot, World, live_in
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.session.connect import _fitted_pose
from cardsflow_fmu.simulation.run import RunError, simulate
from sim_dart import MusclePaths
from sim_dart.estimation.fitted_pose import FittedPose

STEP, TICK = 1e-3, 5
DOWN = 0.1
BEGIN = 0.15
MUSCLES = 11
Change = Callable[[np.ndarray], None]

SETTINGS: dict[str, Any] = {
    "run.duration": 0.4,
    "hardware": {
        "use": True,
        "link": "virtual:",
        "has_positions": False,
        "ramp_in": 0.0,
        "ramp_down": 0.05,
        "emulator": {"noise": 1e-4},
    },
    "estimator": {"exact_transition": False, "ramp_down": DOWN},
}


class FuzzedWorld(World):
    """World that sends invalid frames before every valid frame, in both directions."""

    bad = 0
    seed = 0

    def send(self, data: bytes) -> None:
        for frame in self._bad_of(data):
            super().send(frame)
        super().send(data)

    def _deliver(self, data: bytes, peer: Hashable) -> None:
        self.answers.extend(self._bad_of(data))
        super()._deliver(data, peer)

    def _bad_of(self, data: bytes) -> Iterator[bytes]:
        self.seed += 1
        return bad_frames([data], self.bad, self.seed)


class ReadRobot(WatchedRobot):
    """Robot that records its positions whenever its state is read."""

    def reset(self) -> None:
        super().reset()
        self.read: list[tuple[float, np.ndarray]] = []

    def state(self) -> np.ndarray:
        self.read.append((self.now(), self.plant.q.copy()))
        return super().state()


def world_of(
    monkeypatch: pytest.MonkeyPatch,
    change: Change | None = None,
    faults: Faults | None = None,
    events: dict[float, Callable[[World], None]] | None = None,
    begin: float = BEGIN,
) -> World:
    """Return a world with Roboy's arm whose measurements are changed from a time on."""

    class Changed(ReadRobot):
        def state(self) -> np.ndarray:
            values = super().state()
            if change is not None and self._advances * STEP >= begin:
                change(values)
            return values

    monkeypatch.setattr(virtual_link, "WatchedRobot", Changed)
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", SETTINGS)
    world = World(experiment, faults or Faults(), None, events)
    live_in(monkeypatch, world)
    return world


def run_of(world: World) -> tuple[Result, str]:
    """Run until the end or the first error. Return the results and the error message."""
    try:
        return simulate(world.experiment, coupling="direct"), ""
    except RunError as error:
        result, why = error.result, str(error)
    assert isinstance(result, Result)
    return result, why


def stuck(*muscles: int, tension: bool = False) -> Change:
    """Return a change after which measurements of muscles stay constant."""
    at = np.array(muscles) + tension * MUSCLES
    held: list[np.ndarray] = []

    def change(values: np.ndarray) -> None:
        if not held:
            held.append(values[at])
        values[at] = held[0]

    return change


def swapped(i: int, j: int, *, tension: bool = False) -> Change:
    """Return a change that swaps the measurements of two muscles."""
    at = np.array([i, j]) + tension * MUSCLES

    def change(values: np.ndarray) -> None:
        values[at] = values[at[::-1]]

    return change


def dead(values: np.ndarray) -> None:
    """Set all measured tensions to 0."""
    values[MUSCLES:] = 0.0


def require_ramps(result: Result) -> None:
    """Require that forces ramp down linearly after the estimate is invalid, and stay minimal."""
    robot = result.experiment.robot
    low = np.array([m.f_min for m in robot.muscles])
    ticks = slice(0, len(result.rows) - 1, TICK)
    valid, forces = result["valid"][ticks], result.columns([f"f.{m.name}" for m in robot.muscles])
    forces, top, lost = forces[ticks], None, 0
    for k in range(1, len(valid)):
        if valid[k]:
            lost = 0
            continue
        top, lost = (forces[k - 1] if lost == 0 else top), lost + 1
        share = max(0.0, 1.0 - TICK * STEP / DOWN * lost)
        np.testing.assert_allclose(forces[k], low + share * (top - low), rtol=0, atol=1e-9)


def errors(world: World, result: Result) -> np.ndarray:
    """Return the errors of the estimate at every step, shape (steps, n)."""
    assert isinstance(world.robot, ReadRobot)
    begin = world.robot.applied[0][0]
    read, true = (np.array(column) for column in zip(*world.robot.read, strict=True))
    at = begin + result["time"] - STEP  # states are one step old
    names = [c.name for c in result.experiment.robot.coordinates]
    found = [
        result[f"q_hat.{name}"] - np.interp(at, read, q)
        for name, q in zip(names, true.T, strict=True)
    ]
    return np.array(found).T


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "loss"),
    [(stuck(0), 0.0), (stuck(0, 4, 6, tension=True), 0.0), (None, 0.2)],
    ids=["length stuck", "tensions stuck", "loss"],
)
def test_faults_that_other_measurements_compensate_do_not_end_a_run(
    monkeypatch: pytest.MonkeyPatch, change: Change | None, loss: float
) -> None:
    """Ten other lengths determine the pose, loads are estimated, and a lost state is harmless."""
    world = world_of(monkeypatch, change, Faults(loss=loss, seed=1))
    result, why = run_of(world)
    assert (why, world.device.state) == ("", "safe")
    assert result["valid"].all()
    assert np.abs(errors(world, result)).max() < 0.02


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [dead, swapped(0, 1, tension=True), swapped(0, 1)],
    ids=["tensions of 0", "tensions swapped", "lengths swapped"],
)
def test_implausible_measurements_end_the_run_with_a_ramp(
    monkeypatch: pytest.MonkeyPatch, change: Change
) -> None:
    world = world_of(monkeypatch, change)
    result, why = run_of(world)
    assert (why, world.device.state) == ("", "safe")
    lost = result["time"][result["valid"] == 0]
    assert BEGIN < lost[0] < BEGIN + 0.12
    require_ramps(result)


@pytest.mark.slow
def test_lengths_that_are_swapped_from_the_start_prevent_a_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The fitted pose differs from the start pose of the run."""
    world = world_of(monkeypatch, swapped(0, 1), begin=0.0)
    with pytest.raises(
        HardwareError, match=r"but the start position is .* hardware\.start_tolerance"
    ):
        simulate(world.experiment, coupling="direct")
    assert world.robot.applied == []


@pytest.mark.slow
def test_a_device_that_has_restarted_needs_a_new_run(monkeypatch: pytest.MonkeyPatch) -> None:
    world = world_of(monkeypatch, events={0.1: World.restart})
    result, why = run_of(world)
    assert "the hardware does not respond" in why
    assert result["time"][-1] < 0.12
    assert (world.device.state, world.robot.applied) == ("idle", [])
    again, why = run_of(world)
    assert not why
    assert again["valid"].all()


@pytest.mark.parametrize("value", [1e308, -1e308, 1e9])
def test_the_fitted_pose_is_finite_for_any_measurement(value: float) -> None:
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", {})
    q = np.array(experiment.start.q)
    pose = FittedPose(experiment.robot, q, np.zeros(MUSCLES), 1.0)
    lengths = MusclePaths(experiment.robot).evaluate(q).lengths.copy()
    wrong = lengths.copy()
    wrong[::3] = value
    pose.follow(wrong, np.full(MUSCLES, 20.0))
    assert np.isfinite(pose.q).all()
    assert np.abs(pose.q - q).max() > 0.1


def test_lengths_with_drifting_offsets_do_not_change_the_fitted_pose() -> None:
    """If all lengths drift, the pose is fitted to all of them."""
    for drift, moves in (({"motor2": 1e-5}, False), (1e-5, True)):
        experiment = Experiment.load(
            EXAMPLES / "roboy_left_arm", {"estimator": {"offset_drift": drift}}
        )
        q, pose = np.array(experiment.start.q), _fitted_pose(experiment)
        lengths = MusclePaths(experiment.robot).evaluate(q).lengths.copy()
        lengths[2] += 5e-3
        pose.follow(lengths, np.full(MUSCLES, 20.0))
        assert (np.abs(pose.q - q).max() > 1e-2) == moves


@pytest.mark.slow
@pytest.mark.parametrize("is_signed", [False, True], ids=["unsigned", "signed"])
def test_invalid_frames_have_no_effect(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, is_signed: bool
) -> None:
    """Forces stay within limits. With a key, invalid frames are dropped and change nothing."""
    settings = SETTINGS | {"run.duration": 0.1}
    if is_signed:
        (tmp_path / "key.bin").write_bytes(KEY)
        (tmp_path / "key.bin").chmod(0o600)
        settings = settings | {"hardware.key_file": str(tmp_path / "key.bin")}
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", settings)
    rows, ends = [], Counter[str]()
    for bad in (0, FRAMES // 200):
        world = FuzzedWorld(experiment, Faults(), KEY if is_signed else None)
        world.bad = bad
        live_in(monkeypatch, world)
        try:
            result, why = run_of(world)
            rows.append(result.rows)
            assert np.isfinite(result.rows).all()
        except HardwareError as error:
            why = str(error)
        ends[why] += 1
        assert world.robot.applied or why
        assert not world.device.failure
        world.sleep(world.device.watchdog + STEP)
        assert world.device.state != "running"
    if is_signed:
        assert ends == {"": 2}
        np.testing.assert_array_equal(*rows)
