"""A link to an emulated robot in virtual time: no test waits, and every run is the same.

Both sides are complete but for sockets: session, link and frames on one; faults, device and robot
on the other. Time passes only while the link waits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.emulator.drives import force_bounds
from cardsflow_fmu.hardware.emulator.emulated_device import device_of
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.hardware.emulator.faults import FaultyLine
from cardsflow_fmu.hardware.links.framed_link import FramedLink
from cardsflow_fmu.hardware.session import connect as connect

PEER = "ours"


class WatchedRobot(EmulatedRobot):
    """An emulated robot that records its commands, and requires forces within bounds."""

    now: Callable[[], float] = staticmethod(lambda: 0.0)

    def reset(self) -> None:
        super().reset()
        self.applied: list[tuple[float, np.ndarray]] = []
        self.bounds = force_bounds(self.plant.robot)

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


class World:
    """A clock, a device with its robot, and the line to it.

    Args:
        experiment: The experiment.
        faults: Faults of the line.
        key: The pre-shared key of the device.
        events: Functions by the time in [s] at which they are called, once.
    """

    def __init__(
        self,
        experiment: Experiment,
        faults: Faults,
        key: bytes | None = None,
        events: dict[float, Callable[[World], None]] | None = None,
    ) -> None:
        self.experiment, self.faults, self.key = experiment, faults, key
        self.now = 1000.0
        self._events = sorted(
            ((self.now + t, event) for t, event in (events or {}).items()), key=lambda e: e[0]
        )
        self.answers: list[bytes] = []
        self.intruders: list[bytes] = []
        self.restart()

    def restart(self) -> None:
        """Replace the device by a new one."""
        robot = WatchedRobot.of_experiment(self.experiment)
        robot.now = lambda: self.now
        self.robot = robot
        self.device: Device = device_of(robot, self.experiment.hardware, self.key)
        self.line = FaultyLine(self.device, self.faults)
        self._reached = self.now

    def monotonic(self) -> float:
        return self.now

    def monotonic_ns(self) -> int:
        return int(self.now * 1e9)

    def sleep(self, seconds: float) -> None:
        self.wait(self.now + seconds, lambda: False)

    def wait(self, until: float, over: Callable[[], object]) -> None:
        """Let time pass, event by event."""
        while not over():
            event = min(until, self._reached + self.device.step, self.line.next_due)
            event = min(event, self.device.next_deadline + 1e-9)
            event = min([event, *(t for t, _ in self._events[:1])])
            if event >= until:
                self.now = max(self.now, until)
                self._happen()
                return
            self.now = max(self.now, event)
            self._happen()

    def _happen(self) -> None:
        while self._events and self._events[0][0] <= self.now:
            self._events.pop(0)[1](self)
        while self._reached + self.device.step <= self.now:
            self.device.advance(self.device.step)
            self._reached += self.device.step
        self.device.tick(self.now)
        for data, peer in self.line.due(self.now):
            (self.answers if peer == PEER else self.intruders).append(data)
        self._require_watchdog()

    def _require_watchdog(self) -> None:
        """A device that follows has been commanded within its watchdog time."""
        if self.device.goes_by_clock and self.device.state == "running":
            last, _ = self.robot.applied[-1]
            assert self.now - last <= self.device.watchdog + 1e-9


class VirtualLink(FramedLink):
    """The link into a world."""

    def __init__(self, world: World, key: bytes | None = None) -> None:
        super().__init__("virtual:", key=key, clock=world)
        self.world = world

    def _connect(self) -> None:
        self.world.answers.clear()

    def _disconnect(self) -> None:
        pass

    def _send(self, data: bytes) -> None:
        self.world.line.send(data, PEER, self.world.now)
        self.world.wait(self.world.now, lambda: False)

    def _receive(self, deadline: float) -> bytes | None:
        answers = self.world.answers
        if not answers:
            self.world.wait(deadline, lambda: answers)
        return answers.pop(0) if answers else None


def live_in(monkeypatch: pytest.MonkeyPatch, world: World) -> None:
    """Let all links opened from now on lead to the world's device, by the world's clock."""
    monkeypatch.setattr(connect, "open_link", lambda uri, key, **_: VirtualLink(world, key))
