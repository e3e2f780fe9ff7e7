"""Devices for tests: a robot with a closed-form solution, and its server in a thread."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from numpy.typing import NDArray

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.server import DeviceServer, Line
from cardsflow_fmu.hardware.links.udp import UdpLink
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.handshake import Handshake

FloatArray = NDArray[np.float64]

COMMANDS, STATES = 3, 5
SIGNATURE = 0xFEDC_BA98_7654_3210
STEP = 1e-3
F_MIN, F_MAX = 2.0, 50.0
KEY = b"a key that is long enough"


class Integrator:
    """Robot with x' = u. Its state is x, the time and the number of calls of `safe`.

    Attributes:
        given: All received commands.
        failing: Whether the next call of `advance` fails.
        broken: Replacement for the first state value, or None.
    """

    commands, states = COMMANDS, STATES

    def __init__(self) -> None:
        self.given: list[FloatArray] = []
        self.failing = False
        self.broken: float | None = None
        self.safes = self.resets = 0
        self.reset()

    def apply(self, command: FloatArray) -> None:
        self.u = command.copy()
        self.given.append(self.u)

    def advance(self, dt: float) -> None:
        if self.failing:
            raise SimulationError("it has come off its hinges")
        self.x = self.x + self.u * dt
        self.time += dt

    def state(self) -> FloatArray:
        first = self.x[0] if self.broken is None else self.broken
        return np.array([first, *self.x[1:], self.time, self.safes])

    def safe(self) -> None:
        self.u = np.zeros(COMMANDS)
        self.safes += 1

    def reset(self) -> None:
        self.x, self.u, self.time = np.zeros(COMMANDS), np.zeros(COMMANDS), 0.0
        self.resets += 1


def handshake(*, lockstep: bool = False, step: float = STEP, watchdog: float = 0.02) -> Handshake:
    return Handshake(SIGNATURE, step, 1.0, watchdog, COMMANDS, STATES, lockstep)


def make_device(
    key: bytes | None = None, *, watchdog: float = 0.02, scale: float = 1.0, step: float = STEP
) -> Device:
    return Device(
        Integrator(),
        SIGNATURE,
        step,
        scale=scale,
        key=key,
        watchdog=watchdog,
        f_min=F_MIN,
        f_max=F_MAX,
    )


def robot_of(device: Device) -> Integrator:
    assert isinstance(device.robot, Integrator)
    return device.robot


@contextmanager
def served(
    device: Device, uri: str = "udp://127.0.0.1:0", line: Line | None = None
) -> Iterator[str]:
    """Serve a device in a thread; yield its address."""
    ended = threading.Event()
    with DeviceServer(device, uri, line=line) as server:
        thread = threading.Thread(target=server.run, args=(ended.is_set,))
        thread.start()
        try:
            yield server.uri
        finally:
            ended.set()
            thread.join()


def rejection(uri: str, request: Handshake) -> str:
    """Return why a device rejects a run. A paused device does not answer at first."""
    for _ in range(30):
        with pytest.raises(HardwareError) as caught, UdpLink(uri, timeout=1.0) as link:
            link.open(request)
        if "no device answers" not in str(caught.value):
            return str(caught.value)
    raise AssertionError("the device does not answer")
