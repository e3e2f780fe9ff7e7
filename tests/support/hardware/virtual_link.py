"""Link to an emulated robot in virtual time: tests need not wait, and runs are repeatable.

Except for sockets, both sides are complete: session, link and frames on one side; faults, device
and robot on the other. Virtual time advances only while the link waits.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable

import numpy as np
import pytest

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.emulator.emulated_device import device_of
from cardsflow_fmu.hardware.emulator.emulated_link import EmulatedLink, EmulatedWorld
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.hardware.emulator.faults import FaultyLine
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds
from cardsflow_fmu.hardware.session import connect

INTRUDER = "theirs"
"""Another peer."""


class WatchedLine(FaultyLine):
    """Line that keeps the answers to an intruder in a list."""

    def __init__(self, device: Device, faults: Faults, intruders: list[bytes]) -> None:
        super().__init__(device, faults)
        self._intruders = intruders

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        frames = super().due(now)
        self._intruders += [data for data, peer in frames if peer == INTRUDER]
        return [(data, peer) for data, peer in frames if peer != INTRUDER]


class WatchedRobot(EmulatedRobot):
    """Emulated robot that records its commands and requires forces within limits."""

    now: Callable[[], float] = staticmethod(lambda: 0.0)

    def reset(self) -> None:
        super().reset()
        self.applied: list[tuple[float, np.ndarray]] = []
        self.bounds = actuator_bounds(self.plant.robot)

    def apply(self, command: np.ndarray) -> None:
        self._require_bounds(command)
        self.applied.append((self.now(), command.copy()))
        super().apply(command)

    def advance(self, dt: float) -> None:
        super().advance(dt)
        self._require_bounds(self.tension)

    def _require_bounds(self, forces: np.ndarray) -> None:
        f_min, f_max = self.bounds
        assert np.all(forces >= f_min)
        assert np.all(forces <= f_max)


class World(EmulatedWorld):
    """Emulated world with events, other peers, and a monitored robot.

    Args:
        experiment: The experiment.
        faults: Faults of the line.
        key: The pre-shared key of the device.
        events: Functions by the time in [s] at which each is called once.

    Attributes:
        intruders: Answers to the intruder.
    """

    def __init__(
        self,
        experiment: Experiment,
        faults: Faults,
        key: bytes | None = None,
        events: dict[float, Callable[[World], None]] | None = None,
    ) -> None:
        self.experiment, self.faults, self.key = experiment, faults, key
        self.intruders: list[bytes] = []
        super().__init__(self._make_device(), faults)
        self.line = WatchedLine(self.device, faults, self.intruders)
        self._events = sorted(
            ((self.now + t, event) for t, event in (events or {}).items()), key=lambda e: e[0]
        )

    def _make_device(self) -> Device:
        self.robot = WatchedRobot.from_experiment(self.experiment)
        self.robot.now = lambda: self.now
        return device_of(self.robot, self.experiment.hardware, self.key)

    def restart(self) -> None:
        """Replace the device by a new one."""
        self.device = self._make_device()
        self.line = WatchedLine(self.device, self.faults, self.intruders)

    def _next_event(self) -> float:
        return min([super()._next_event(), *(t for t, _ in self._events[:1])])

    def _process(self) -> None:
        """Process events; require that a running device was commanded within its watchdog time."""
        while self._events and self._events[0][0] <= self.now:
            self._events.pop(0)[1](self)
        super()._process()
        if self.device.moves_in_real_time and self.device.state == "running":
            last, _ = self.robot.applied[-1]
            assert self.now - last <= self.device.watchdog + 1e-9


def live_in(monkeypatch: pytest.MonkeyPatch, world: World) -> None:
    """Connect all links opened from now on to the device of the world, with its clock."""
    monkeypatch.setattr(connect, "open_link", lambda uri, key, **_: EmulatedLink(world, key=key))
