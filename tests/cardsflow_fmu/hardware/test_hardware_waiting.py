"""Waiting for datagrams: awake where that pays, asleep elsewhere, and never awake for long."""

from __future__ import annotations

import itertools
import math
import socket
import threading
import time
from contextlib import closing

import pytest

from cardsflow_fmu.hardware.links import datagram_wait as waiting
from cardsflow_fmu.hardware.links.datagram_wait import Waiter

LOOK, SOON, WAKING = 1e-6, 20e-6, 30e-6
"""How long it takes to look once, for an answer to come, and to be woken, in [s]."""


class World:
    """A clock that goes on as it is looked at, and one datagram on its way at most.

    Attributes:
        arrival: When the next datagram is there, in [s].
        awake: Time for which somebody looked again and again, in [s].
    """

    def __init__(self) -> None:
        self.now, self.arrival, self.awake = 10.0, math.inf, 0.0

    def monotonic(self) -> float:
        return self.now

    perf_counter = monotonic

    def select(self, readers: object, writers: object, others: object, seconds: float) -> tuple:
        over = self.now + seconds
        if self.arrival > over:
            self.now = over
            return [], [], []
        self.now = max(self.now, self.arrival) + WAKING
        return [self], [], []

    def read(self) -> str:
        self.now += LOOK
        if self.arrival <= self.now:
            self.arrival = math.inf
            return "came"
        self.awake += LOOK
        raise BlockingIOError

    def wait(self, waiter: Waiter[str], comes_in: float, patience: float = 1.0) -> float:
        """Wait for what comes after a time; how long that took, in [s]."""
        begin = self.now
        self.arrival = begin + comes_in
        assert waiter.receive(begin + patience) == "came"
        return self.now - begin


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> World:
    world = World()
    monkeypatch.setattr(waiting, "time", world)
    monkeypatch.setattr(waiting, "select", world)
    return world


def waiter_in(world: World, cores: int = 2) -> Waiter[str]:
    with socket.socket() as line:
        return Waiter(line, world.read, cores)


def test_who_is_answered_soon_stays_awake(world: World) -> None:
    waiter = waiter_in(world)
    assert world.wait(waiter, SOON) >= SOON + WAKING
    for _ in range(100):
        assert world.wait(waiter, SOON) < SOON + 2 * LOOK


def test_on_one_core_nobody_stays_awake(world: World) -> None:
    waiter = waiter_in(world, cores=1)
    for _ in range(100):
        assert world.wait(waiter, SOON) >= SOON + WAKING
    assert world.awake == 0


@pytest.mark.parametrize("comes_in", [300e-6, 1e-3, 0.1])
def test_who_waits_for_long_sleeps(world: World, comes_in: float) -> None:
    """Such as a device between the set points of a run at 1 kHz."""
    waiter = waiter_in(world)
    for _ in range(100):
        assert world.wait(waiter, comes_in) < comes_in + WAKING + 2 * LOOK
    assert world.awake == 0


def test_nobody_is_awake_for_longer_than_a_tenth_of_a_millisecond(world: World) -> None:
    waiter = waiter_in(world)
    world.wait(waiter, 150e-6)
    world.wait(waiter, 150e-6)
    assert 0 < world.awake <= 100e-6 + LOOK


def test_in_vain_less_and_less_often(world: World) -> None:
    """As where the other side needs the core: whoever stays awake is answered once it sleeps."""
    waiter = waiter_in(world)
    waits, vain = 10_000, []
    for k in range(waits):
        before = world.awake
        world.wait(waiter, 110e-6 if waiter._is_awake else SOON)
        if world.awake > before:
            vain.append(k)
    rests = [later - sooner for sooner, later in itertools.pairwise(vain)]
    assert rests[:9] == sorted(rests[:9])
    assert all(rest >= 512 for rest in rests[9:])
    assert world.awake < 0.01 * waits * (SOON + WAKING)


def test_success_brings_back_who_was_in_vain(world: World) -> None:
    waiter = waiter_in(world)
    for _ in range(3000):
        world.wait(waiter, 110e-6 if waiter._is_awake else SOON)
    slow = [world.wait(waiter, SOON) > SOON + 2 * LOOK for _ in range(2000)]
    assert sum(slow) <= 514
    world.wait(waiter, 1e-3)
    for _ in range(600):
        world.wait(waiter, SOON)
    world.wait(waiter, 1e-3)  # a pause of the other side is forgiven at once
    assert sum(world.wait(waiter, SOON) > SOON + 2 * LOOK for _ in range(10)) <= 3


@pytest.mark.parametrize("is_awake", [False, True])
@pytest.mark.parametrize("patience", [-1.0, 0.0, 5e-6, 50e-6, 1e-3, 0.1])
def test_it_waits_until_then_and_no_longer(world: World, is_awake: bool, patience: float) -> None:
    waiter = waiter_in(world)
    world.wait(waiter, SOON)
    waiter._is_awake = is_awake
    begin = world.now
    assert waiter.receive(begin + patience) is None
    waited = world.now - begin - max(patience, 0.0)
    assert -1e-9 < waited < 3 * LOOK
    for past in (0.0, 1.0):  # what is there already is found, however late it is
        world.arrival = world.now
        assert waiter.receive(world.now - past) == "came"


def test_by_a_socket() -> None:
    """Two threads that speak in turn; then one falls silent, and is gone."""
    with (
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as ours,
        closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as theirs,
    ):
        for line in (ours, theirs):
            line.bind(("127.0.0.1", 0))
            line.setblocking(False)
        ours.connect(theirs.getsockname())
        theirs.connect(ours.getsockname())
        turns = 500

        def echo() -> None:
            waiter = Waiter(theirs, lambda: theirs.recv(100), 2)
            for _ in range(turns):
                said = waiter.receive(time.monotonic() + 60.0)
                assert said is not None
                theirs.send(said)

        other = threading.Thread(target=echo)
        other.start()
        waiter = Waiter(ours, lambda: ours.recv(100), 2)
        for k in range(turns):
            ours.send(str(k).encode())
            assert waiter.receive(time.monotonic() + 60.0) == str(k).encode()
        other.join()
        begin = time.monotonic()
        assert waiter.receive(begin + 0.02) is None
        assert time.monotonic() - begin >= 0.02
        theirs.close()
        for is_awake in (False, True):
            waiter._is_awake = is_awake
            ours.send(b"anybody?")
            with pytest.raises(ConnectionError):
                waiter.receive(time.monotonic() + 60.0)
