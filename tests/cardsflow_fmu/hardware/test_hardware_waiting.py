"""Waits for datagrams: busy polling is limited, and backs off after failures."""

from __future__ import annotations

import itertools
import math
import socket
import threading
import time
from contextlib import closing

import pytest

from cardsflow_fmu.hardware.links import datagram_wait as waiting
from cardsflow_fmu.hardware.links.datagram_wait import AdaptiveReceiver

READ, SOON, WAKE_UP = 1e-6, 20e-6, 30e-6
"""Durations of a read, of an answer, and of waking up, in [s]."""


class World:
    """Clock that advances with every read, and at most one datagram in transit.

    Attributes:
        arrival: Arrival time of the next datagram, in [s].
        polled: Total time of polling, in [s].
    """

    def __init__(self) -> None:
        self.now, self.arrival, self.polled = 10.0, math.inf, 0.0

    def monotonic(self) -> float:
        return self.now

    perf_counter = monotonic

    def select(self, readers: object, writers: object, others: object, seconds: float) -> tuple:
        over = self.now + seconds
        if self.arrival > over:
            self.now = over
            return [], [], []
        self.now = max(self.now, self.arrival) + WAKE_UP
        return [self], [], []

    def read(self) -> str:
        self.now += READ
        if self.arrival <= self.now:
            self.arrival = math.inf
            return "came"
        self.polled += READ
        raise BlockingIOError

    def wait(self, receiver: AdaptiveReceiver[str], comes_in: float, limit: float = 1.0) -> float:
        """Wait for a datagram that arrives after a time. Return the wait, in [s]."""
        begin = self.now
        self.arrival = begin + comes_in
        assert receiver.receive(begin + limit) == "came"
        return self.now - begin


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> World:
    world = World()
    monkeypatch.setattr(waiting, "time", world)
    monkeypatch.setattr(waiting, "select", world)
    return world


def receiver_in(world: World, cores: int = 2) -> AdaptiveReceiver[str]:
    with socket.socket() as line:
        return AdaptiveReceiver(line, world.read, cores)


def test_waits_poll_after_quick_answers(world: World) -> None:
    receiver = receiver_in(world)
    assert world.wait(receiver, SOON) >= SOON + WAKE_UP
    for _ in range(100):
        assert world.wait(receiver, SOON) < SOON + 2 * READ


def test_one_core_never_polls(world: World) -> None:
    receiver = receiver_in(world, cores=1)
    for _ in range(100):
        assert world.wait(receiver, SOON) >= SOON + WAKE_UP
    assert world.polled == 0


@pytest.mark.parametrize("comes_in", [300e-6, 1e-3, 0.1])
def test_long_waits_block(world: World, comes_in: float) -> None:
    """An example is a device between the set points of a run at 1 kHz."""
    receiver = receiver_in(world)
    for _ in range(100):
        assert world.wait(receiver, comes_in) < comes_in + WAKE_UP + 2 * READ
    assert world.polled == 0


def test_polling_takes_at_most_a_tenth_of_a_millisecond(world: World) -> None:
    receiver = receiver_in(world)
    world.wait(receiver, 150e-6)
    world.wait(receiver, 150e-6)
    assert 0 < world.polled <= 100e-6 + READ


def test_failed_polling_backs_off(world: World) -> None:
    """An example is a device that needs the same core and answers only if this thread blocks."""
    receiver = receiver_in(world)
    waits, vain = 10_000, []
    for k in range(waits):
        before = world.polled
        world.wait(receiver, 110e-6 if receiver._is_polling else SOON)
        if world.polled > before:
            vain.append(k)
    rests = [later - sooner for sooner, later in itertools.pairwise(vain)]
    assert rests[:9] == sorted(rests[:9])
    assert all(rest >= 512 for rest in rests[9:])
    assert world.polled < 0.01 * waits * (SOON + WAKE_UP)


def test_polling_returns_after_successes(world: World) -> None:
    receiver = receiver_in(world)
    for _ in range(3000):
        world.wait(receiver, 110e-6 if receiver._is_polling else SOON)
    slow = [world.wait(receiver, SOON) > SOON + 2 * READ for _ in range(2000)]
    assert sum(slow) <= 514
    world.wait(receiver, 1e-3)
    for _ in range(600):
        world.wait(receiver, SOON)
    world.wait(receiver, 1e-3)  # a single pause of the other side has no effect
    assert sum(world.wait(receiver, SOON) > SOON + 2 * READ for _ in range(10)) <= 3


@pytest.mark.parametrize("is_polling", [False, True])
@pytest.mark.parametrize("limit", [-1.0, 0.0, 5e-6, 50e-6, 1e-3, 0.1])
def test_a_wait_ends_at_its_deadline(world: World, is_polling: bool, limit: float) -> None:
    receiver = receiver_in(world)
    world.wait(receiver, SOON)
    receiver._is_polling = is_polling
    begin = world.now
    assert receiver.receive(begin + limit) is None
    waited = world.now - begin - max(limit, 0.0)
    assert -1e-9 < waited < 3 * READ
    for past in (0.0, 1.0):  # a datagram that has arrived is returned even after the deadline
        world.arrival = world.now
        assert receiver.receive(world.now - past) == "came"


def test_waits_on_a_socket() -> None:
    """Two threads send in turn; then one stops and closes its socket."""
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
            receiver = AdaptiveReceiver(theirs, lambda: theirs.recv(100), 2)
            for _ in range(turns):
                said = receiver.receive(time.monotonic() + 60.0)
                assert said is not None
                theirs.send(said)

        other = threading.Thread(target=echo)
        other.start()
        receiver = AdaptiveReceiver(ours, lambda: ours.recv(100), 2)
        for k in range(turns):
            ours.send(str(k).encode())
            assert receiver.receive(time.monotonic() + 60.0) == str(k).encode()
        other.join()
        begin = time.monotonic()
        assert receiver.receive(begin + 0.02) is None
        assert time.monotonic() - begin >= 0.02
        theirs.close()
        for is_polling in (False, True):
            receiver._is_polling = is_polling
            ours.send(b"anybody?")
            with pytest.raises(ConnectionError):
                receiver.receive(time.monotonic() + 60.0)
