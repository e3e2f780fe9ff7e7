"""Detection and isolation of faults in C."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.controllers.fault_monitor import KINDS, STEP, Bench, FaultMonitor

BEGIN = 100  # first tick with a fault
END = 260
MUSCLE, OTHER, JOINT = 2, 5, 1
VALUES = {"weak": 0.5, "length_bias": 0.004, "length_scale": 0.7, "jammed": 2e4}
PARTS = {"length": Bench.m, "tension": 2 * Bench.m, "encoder": 3 * Bench.m}


class Fault:
    """Fault of one muscle or joint of a bench, as in the emulator."""

    def __init__(self, kind: str) -> None:
        self.kind, self.first = kind, {}

    def apply(self, bench: Bench) -> None:
        i, lengths, tensions = MUSCLE, bench.lengths, bench.tensions
        first = self.first or {
            "length": lengths[i],
            "tension": tensions[i],
            "command": bench.commands[i],
            "encoder": bench.encoders[JOINT],
        }
        self.first, value = first, VALUES.get(self.kind, 0.0)
        if self.kind in ("broken", "length_stuck"):
            lengths[i] = first["length"]
        if self.kind in ("broken", "tension_dead"):
            tensions[i] = 0.0
        if self.kind == "weak":
            tensions[i] *= value
        if self.kind == "jammed":
            change = lengths[i] - first["length"]
            tensions[i] *= max(first["command"] + value * change, 0.0) / bench.commands[i]
        if self.kind == "length_bias":
            lengths[i] += value
        if self.kind == "length_scale":
            lengths[i] = first["length"] + value * (lengths[i] - first["length"])
        if self.kind == "length_swapped":
            lengths[[i, OTHER]] = lengths[[OTHER, i]]
        if self.kind == "tension_stuck":
            tensions[i] = first["tension"]
        if self.kind == "encoder_stuck":
            bench.encoders[JOINT] = first["encoder"]

    @property
    def part(self) -> int:
        """Number of the part that must be found."""
        sensor = self.kind.partition("_")[0]
        return PARTS.get(sensor, 0) + (JOINT if sensor == "encoder" else MUSCLE)


def run_until_found(monitor: FaultMonitor, bench: Bench, kind: str) -> int:
    """Return the tick at which a fault is found, or END."""
    fault = Fault(kind)
    for now in bench.ticks(END):
        if now.tick >= BEGIN:
            fault.apply(now)
        now.write(monitor)
        if monitor.tick():
            return now.tick
    return END


@pytest.mark.parametrize("kind", KINDS[1:])
def test_single_fault_is_found_and_isolated(kind: str) -> None:
    monitor, bench = FaultMonitor(Bench.n, Bench.m), Bench(3)
    tick = run_until_found(monitor, bench, kind)
    expected = {kind: OTHER + Bench.m if kind == "length_swapped" else Fault(kind).part}
    assert monitor.found == expected
    assert BEGIN <= tick < END
    part = Fault(kind).part
    assert monitor.array("confidence")[part] >= 0.99 or kind == "length_scale"
    assert monitor.array("begin")[part] == pytest.approx(BEGIN * STEP, abs=12 * STEP)
    assert monitor.array("time")[part] == pytest.approx(tick * STEP)
    if kind in ("weak", "length_bias", "length_scale"):
        assert monitor.array("value")[part] == pytest.approx(VALUES[kind], rel=0.15)


def test_broken_cable_has_no_force_left_and_its_length_sensor_is_not_used() -> None:
    monitor = FaultMonitor(Bench.n, Bench.m)
    run_until_found(monitor, Bench(1), "broken")
    assert monitor.array("bound").tolist() == [0.0 if i == MUSCLE else 500.0 for i in range(8)]
    lost = np.flatnonzero(monitor.array("usable") == 0).tolist()
    assert lost == [MUSCLE, MUSCLE + Bench.m]


def test_ticks_are_counted_from_zero_again_without_any_effect() -> None:
    found = []
    for start in (0, 2**20):
        monitor = FaultMonitor(Bench.n, Bench.m)
        monitor.array("clock")[0] = start
        run_until_found(monitor, Bench(3), "length_bias")
        found.append([monitor.array(name).copy() for name in ("kind", "statistic", "value")])
    assert monitor.array("clock")[0] < 2**20
    assert np.array_equal(*found)


def test_broken_cable_is_found_without_tension_sensors_as_a_stuck_length() -> None:
    monitor, bench, fault = FaultMonitor(Bench.n, Bench.m), Bench(2), Fault("broken")
    for now in bench.ticks(END):
        if now.tick >= BEGIN:
            fault.apply(now)
        now.tensions[:] = math.nan
        now.write(monitor)
        if monitor.tick():
            break
    assert monitor.found == {"length_stuck": MUSCLE + Bench.m}


def test_unknown_load_is_not_a_fault() -> None:
    monitor = FaultMonitor(Bench.n, Bench.m)
    for now in Bench(4).ticks(END, jump=BEGIN):
        now.write(monitor)
        assert not monitor.tick()


@pytest.mark.parametrize("stated", [1e-4, 0.0])
def test_constant_errors_of_lengths_are_a_fault_only_if_they_are_not_stated(stated: float) -> None:
    """They shift the pose of the lengths, with which the encoders are compared."""
    monitor, bench, alarms = FaultMonitor(Bench.n, Bench.m), Bench(7), 0
    monitor.write(length_error=stated)
    error = np.random.default_rng(1).normal(0.0, 1e-4, Bench.m)
    for now in bench.ticks(END):
        now.lengths += error
        now.write(monitor)
        alarms += monitor.tick()
    assert (alarms > 0) == (stated == 0.0)


@pytest.mark.parametrize("resolution", [1e-5, 1e-3])
@pytest.mark.parametrize("fall", [0.0, 40.0])
def test_constant_values_of_a_sensor_without_noise_are_not_a_fault(
    resolution: float, fall: float
) -> None:
    """Encoders of a robot at rest repeat their values, also after a fall to its limits."""
    monitor, bench = FaultMonitor(Bench.n, Bench.m), Bench(5)
    monitor.write(length_noise=max(1e-4, resolution), length_error=resolution)
    for now in bench.ticks(3 * BEGIN):
        if now.tick == 2 * BEGIN:
            rest = now.q + fall / 2.0 * (0.1 * BEGIN * STEP) ** 2
        now.q = now.q + fall / 2.0 * (max(min(now.tick, 2 * BEGIN) - 1.9 * BEGIN, 0.0) * STEP) ** 2
        if now.tick >= 2 * BEGIN:
            now.q = rest
        exact = now._rest + now.L @ now.q
        now.lengths = np.round(exact / resolution) * resolution
        now.encoders = np.round(now.q / 1e-5) * 1e-5
        now.write(monitor)
        assert not monitor.tick()


def test_false_alarms_are_as_rare_as_stated() -> None:
    """The bound of the threshold holds, and is not far too large.

    The rate is so large that alarms occur in a short time. Each alarm restarts the monitor.
    """
    stated = 40_000.0  # per hour: 0.056 per tick
    monitor, bench, alarms, ticks = FaultMonitor(Bench.n, Bench.m, stated), Bench(6), 0, 4000
    monitor.write(tension_noise=0.0, tension_error=0.0)
    monitor.tick()
    for now in bench.ticks(ticks):
        now.write(monitor)
        monitor.tick()
        if monitor.array("suspect").any() or monitor.array("kind").any():
            alarms += 1
            monitor.reset()
    expected = stated * ticks * STEP / 3600.0
    assert expected / 50.0 < alarms < expected + 3.0 * math.sqrt(expected)
