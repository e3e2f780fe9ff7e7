"""Links by UDP, by a serial line and in process, with and without faults."""

from __future__ import annotations

import math
import os
import select
import socket
import sys
import threading
import time
import tty
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress

import numpy as np
import pytest
from support.hardware.hardware_devices import (
    COMMANDS,
    KEY,
    SIGNATURE,
    STATES,
    STEP,
    handshake,
    make_device,
    rejection,
    robot_of,
    served,
)
from support.hardware.hardware_fuzz import FRAMES, bad_frames
from support.process_output import wait_until

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.server import DeviceServer
from cardsflow_fmu.hardware.emulator.faults import FaultyLine
from cardsflow_fmu.hardware.links.framed_link import FramedLink
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.links.serial import SerialLink
from cardsflow_fmu.hardware.links.udp import UdpLink, udp_address
from cardsflow_fmu.hardware.protocol.cobs import Unstuffer, encode
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import (
    MAX_BYTES,
    Flag,
    Frame,
    FrameError,
    Kind,
    pack,
    unpack,
)
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.session.open_link import open_link

PULL = np.array([3.0, 20.0, 50.0])
SOON = 30.0
"""Timeout that is sufficient even on a machine that is ten times slower, in [s]."""


@contextmanager
def serial_device(device: Device) -> Iterator[str]:
    """Serve a device at the other end of a serial line."""
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    ended = threading.Event()

    def run() -> None:
        unstuffer = Unstuffer(MAX_BYTES)
        while not ended.is_set():
            if select.select([ours], (), (), 0.01)[0]:
                with suppress(OSError):
                    for frame in unstuffer.take(os.read(ours, 4096)):
                        for answer in device.receive(frame, "line", time.monotonic()):
                            os.write(ours, encode(answer))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield f"serial://{os.ttyname(theirs)}?baud=2000000"
    finally:
        ended.set()
        thread.join()
        os.close(ours)
        os.close(theirs)


@contextmanager
def linked(kind: str, device: Device, key: bytes | None = None) -> Iterator[HardwareLink]:
    """Yield a link to a device that is not open yet."""
    with ExitStack() as stack:
        uri = "loopback:"
        if kind == "udp":
            uri = stack.enter_context(served(device))
        if kind == "serial":
            uri = stack.enter_context(serial_device(device))
        link = open_link(uri, key=key, make_device=lambda: device)
        stack.callback(link.close)
        yield link


def pull(link: HardwareLink, command=PULL, *, within: float = SOON) -> Exchange:
    return link.exchange(0.0, np.asarray(command, float), time.monotonic() + within)


KINDS = ["udp", "serial", "loopback"]


@pytest.mark.parametrize("key", [None, KEY])
@pytest.mark.parametrize("kind", KINDS)
def test_lockstep_works_with_every_link(kind: str, key: bytes | None) -> None:
    """The robot integrates u, so that x = h sum(u)."""
    device = make_device(key)
    rng = np.random.default_rng(0)
    commands = rng.uniform(2.0, 50.0, (50, COMMANDS))
    with linked(kind, device, key) as link:
        link.open(handshake(lockstep=True))
        assert link.run_id == device.run_id > 0
        assert link.agreed == handshake(lockstep=True)
        np.testing.assert_array_equal(link.start_state[:3], 0.0)
        for k, command in enumerate(commands, 1):
            came = pull(link, command)
            np.testing.assert_allclose(came.state[:3], STEP * commands[:k].sum(0), rtol=1e-13)
            assert came.seq == k
            assert 0 < came.round_trip < SOON
            assert 0 <= came.age < SOON
            assert came.device_flags & Flag.LOCKSTEP
        assert link.stop()
        assert device.state == "safe"
        assert not link.stop()
        link.close()
        link.close()


@pytest.mark.parametrize("kind", ["udp", "loopback"])
def test_in_real_time_the_device_advances_with_the_clock(kind: str) -> None:
    """It is never early, and late by more than two steps only if the machine is busy."""
    device = make_device(watchdog=10.0)
    with linked(kind, device) as link:
        for _ in range(200):
            link.open(handshake(watchdog=10.0))
            time.sleep(0.02)  # time before the run is not simulated
            begin = time.monotonic()
            pull(link)
            time.sleep(0.03)
            came = pull(link)
            passed = time.monotonic() - begin
            elapsed = came.state[3]
            assert elapsed <= passed + STEP
            np.testing.assert_allclose(came.state[:3], elapsed * PULL, rtol=1e-12)
            if passed - elapsed <= 3 * STEP:
                return
    pytest.fail("the device was always behind the clock")


@pytest.mark.parametrize("kind", KINDS)
def test_a_link_can_be_opened_again(kind: str) -> None:
    device = make_device()
    with linked(kind, device) as link:
        runs = set()
        for _ in range(3):
            link.open(handshake(lockstep=True))
            assert pull(link).seq == 1
            runs.add(link.run_id)
        assert len(runs) == 3


def test_set_points_and_states_are_scaled() -> None:
    device = make_device(scale=8.0)
    with linked("udp", device) as link:
        link.open(Handshake(SIGNATURE, STEP, 8.0, 0.02, COMMANDS, STATES, True))
        came = pull(link)
    np.testing.assert_array_equal(robot_of(device).given[0], PULL)
    np.testing.assert_allclose(came.state[:3], STEP * PULL, rtol=1e-14)


def test_the_watchdog_expires_without_set_points() -> None:
    """It expires in real time, within the timeout plus two ticks of the server."""
    device = make_device()
    with linked("udp", device) as link:
        link.open(handshake())
        pull(link)
        begin = time.monotonic()
        while device.state == "running":
            assert time.monotonic() < begin + SOON
            time.sleep(1e-4)
        came = pull(link)
    assert came.device_flags & Flag.SAFE
    assert device.counters["watchdog"] == 1


def test_a_missing_answer_is_an_error() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        uri = f"udp://127.0.0.1:{silent.getsockname()[1]}"
        for key, word in ((None, "is it running"), (KEY, "the same key")):
            link = UdpLink(uri, key=key, timeout=0.2)
            begin = time.monotonic()
            with pytest.raises(HardwareError, match=f"no device answers at {uri}.*{word}"):
                link.open(handshake())
            assert time.monotonic() - begin >= 0.2
    with pytest.raises(HardwareError, match="no device answers"):
        UdpLink(uri, timeout=0.1).open(handshake())  # the port is closed


def test_a_device_with_a_key_drops_unsigned_frames() -> None:
    with served(make_device(KEY)) as uri:
        for key in (None, KEY[::-1]):
            with pytest.raises(HardwareError, match="no device answers"):
                UdpLink(uri, key=key, timeout=0.15).open(handshake())
        with UdpLink(uri, key=KEY) as link:
            link.open(handshake())


def test_a_link_with_a_key_requires_a_device_with_the_key() -> None:
    """A device without the key cannot verify the frames and does not answer."""
    with served(make_device()) as uri, pytest.raises(HardwareError, match="same key"):
        UdpLink(uri, key=KEY, timeout=0.15).open(handshake())


@pytest.mark.parametrize(
    ("asked", "word"),
    [
        (Handshake(1, STEP, 1.0, 0.02, COMMANDS, STATES, False), "signals"),
        (Handshake(SIGNATURE, STEP, 2.0, 0.02, COMMANDS, STATES, False), "scale"),
        (handshake(step=0.0015, lockstep=True), "time step"),
        (handshake(step=0.1), "watchdog"),
    ],
)
def test_a_rejected_run_names_the_reason(asked: Handshake, word: str) -> None:
    with (
        served(make_device()) as uri,
        UdpLink(uri, timeout=1e4) as link,
        pytest.raises(HardwareError, match=f"rejected the run: .*{word}"),
    ):
        link.open(asked)


def test_a_second_sender_is_rejected_and_the_run_continues() -> None:
    device = make_device(watchdog=10.0)
    with served(device) as uri, UdpLink(uri) as link:
        link.open(handshake(watchdog=10.0))
        pull(link)
        assert "another run uses it" in rejection(uri, handshake())
        assert pull(link).seq == 2
        assert device.run_id == link.run_id


def test_a_device_becomes_free_during_the_handshake() -> None:
    """The process of the previous run was killed: the watchdog frees the device."""
    with served(make_device(watchdog=0.2)) as uri:
        killed = UdpLink(uri)
        killed.open(handshake(watchdog=0.2))
        pull(killed)
        with UdpLink(uri) as link:
            link.open(handshake(watchdog=0.2))
            assert pull(link).seq == 1
        killed.close()


def test_a_device_that_restarts_during_a_run_needs_a_new_handshake() -> None:
    """The robot does not move before a new handshake."""
    request = handshake(watchdog=10.0)
    device, fresh = make_device(watchdog=10.0), make_device(watchdog=10.0)
    with served(device) as uri:
        link = UdpLink(uri)
        link.open(request)
        pull(link)
        old_run = link.run_id
    with served(fresh, uri), link:
        assert pull(link, within=0.05).state is None
        assert not link.stop()
        assert fresh.state == "idle"
        assert wait_until(lambda: fresh.counters["run"] > 0)
        assert not robot_of(fresh).given
        link.open(request)
        assert pull(link).seq == 1
        assert link.run_id != old_run


def test_only_frames_of_the_connected_peer_are_received() -> None:
    """Valid frames from another port are dropped by the system."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        link = UdpLink(f"udp://127.0.0.1:{line.getsockname()[1]}", timeout=SOON)
        answered = threading.Thread(target=answer_hello, args=(line,))
        answered.start()
        link.open(handshake())
        answered.join()
        here = link._socket.getsockname()
        assert here[0] == "127.0.0.1"
        forged = pack(Frame(Kind.STATE, 0, link.run_id, 1, 0.0, 1, 1, np.zeros(STATES)))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(forged, here)
            assert pull(link, within=0.05).state is None
            line.sendto(forged, here)
            assert pull(link, within=0.05).state is not None
        link.close()


def answer_hello(line: socket.socket) -> None:
    """Answer one handshake like a device."""
    device = make_device()
    data, peer = line.recvfrom(MAX_BYTES)
    for answer in device.receive(data, peer, 0.0):
        line.sendto(answer, peer)


class Line(FramedLink):
    """Link to a device without a clock, which lets a test change the frames.

    Attributes:
        waiting: Frames that the link receives next.
        inward: Function that sends a frame to the device and returns the answers.
    """

    def __init__(self, device: Device, key: bytes | None = None) -> None:
        super().__init__("line:", key=key, timeout=0.2)
        self.device, self.waiting = device, deque[bytes]()
        self.outward: Callable[[bytes], list[bytes]] = lambda data: [data]
        self.inward: Callable[[bytes], list[bytes]] = lambda data: [data]
        self.now = 0.0

    def _connect(self) -> None:
        pass

    def _disconnect(self) -> None:
        pass

    def _send(self, data: bytes) -> None:
        for frame in self.outward(data):
            for answer in self.device.receive(frame, "line", self.now):
                self.waiting.extend(self.inward(answer))

    def _receive(self, deadline: float) -> bytes | None:
        if not self.waiting:
            time.sleep(max(deadline - time.monotonic(), 0.0))
            return None
        return self.waiting.popleft()


def open_line(key: bytes | None = None, *, lockstep: bool = False) -> Line:
    line = Line(make_device(key), key)
    line.open(handshake(lockstep=lockstep))
    return line


def recorded_hello(k: int) -> bytes:
    """Return the HELLO of an earlier run, which an attacker has recorded."""
    return pack(Frame(Kind.HELLO, 0, 1000 + k, 0, 0.0, 1, 0, handshake().values()), KEY)


def test_a_link_with_a_key_gets_the_device_although_hellos_are_replayed() -> None:
    """A HELLO of an attacker arrives before every frame of the handshake, and after it."""
    line, sent = Line(make_device(KEY), KEY), list[int]()

    def attacked(data: bytes) -> list[bytes]:
        for _ in range(100):
            line.device.receive(recorded_hello(len(sent)), "attacker", 0.0)
            sent.append(data[5])
        return [data]

    line.outward = attacked
    line.open(handshake())
    assert set(sent) == {Kind.HELLO, Kind.PING}
    assert len(sent) == 200
    assert pull(line).seq == 1
    assert line.device.run_id == line.run_id


@pytest.mark.parametrize("lost", [Kind.PING, Kind.PONG])
def test_a_lost_confirmation_is_repeated(lost: Kind) -> None:
    line = Line(make_device(KEY), KEY)
    left = [lost]

    def lossy(data: bytes) -> list[bytes]:
        return [] if left and data[5] == left[0] and left.pop() else [data]

    line.outward = line.inward = lossy
    line.open(handshake())
    assert pull(line).seq == 1
    assert left == []


def test_a_run_that_is_replaced_before_its_first_set_point_begins_again() -> None:
    """A confirmed run is reserved for 1 s only, since its controller may have crashed."""
    line = open_line(KEY)
    line.now += 1.1
    line._confirmed_at -= 1.1
    line.device.receive(recorded_hello(0), "attacker", line.now)
    assert line.device.run_id != line.run_id
    assert pull(line).seq == 1
    assert line.device.run_id == line.run_id


def test_the_newest_state_is_used_and_copies_are_dropped() -> None:
    line = open_line()
    held: list[bytes] = []
    line.inward = lambda data: held.append(data) or []  # type: ignore[func-returns-value]
    for _ in range(3):
        assert pull(line, within=0.0).state is None
    line.inward = lambda data: [held[2], held[0], held[1], held[2], data, data]
    came = pull(line)
    assert (came.seq, line.counters["stale"]) == (4, 3)
    line.inward = lambda data: []
    assert pull(line, within=0.0).state is None  # the copy of state 4 is not a new state
    assert line.counters["stale"] == 4


def test_a_late_state_is_used_if_no_newer_state_has_arrived() -> None:
    line = open_line()
    held: list[bytes] = []
    line.inward = lambda data: held.append(data) or []  # type: ignore[func-returns-value]
    pull(line, within=0.0)
    line.inward = lambda data: [held[0]]
    came = pull(line, within=0.01)
    assert came.state is not None
    assert came.seq == 1
    assert came.round_trip < SOON


def test_missed_states_are_reported() -> None:
    line = open_line()
    assert math.isinf(pull_nothing(line).age)
    line.outward = lambda data: [data]
    assert pull(line).age < SOON
    time.sleep(0.02)
    came = pull_nothing(line)
    assert came.age >= 0.02
    assert (came.seq, came.device_flags) == (2, 0)
    assert math.isnan(came.round_trip)
    assert line.counters["missed"] == 2


def pull_nothing(line: Line) -> Exchange:
    line.outward = lambda data: []
    return pull(line, within=0.0)


@pytest.mark.parametrize("lost", ["outward", "inward"])
def test_in_lockstep_lost_frames_are_sent_again(lost: str) -> None:
    """The robot still advances exactly once per set point."""
    line = open_line(lockstep=True)
    sent = 0

    def every_third(data: bytes) -> list[bytes]:
        nonlocal sent
        sent += 1
        return [data] if sent % 3 == 0 else []

    setattr(line, lost, every_third)
    for k in range(1, 6):
        came = pull(line)
        np.testing.assert_allclose(came.state[:3], k * STEP * PULL, rtol=1e-13)
    assert line.counters["repeated"] == 10


def test_a_state_of_a_set_point_that_was_not_sent_is_dropped() -> None:
    line = open_line()
    forged = Frame(Kind.STATE, 0, line.run_id, 1000, 0.0, 1, 1, np.zeros(STATES))
    line.inward = lambda data: [pack(forged)]
    assert pull(line, within=0.0).state is None
    line.inward = lambda data: [data]
    assert pull(line).seq == 2


@pytest.mark.parametrize("key", [None, KEY])
def test_invalid_answers_have_no_effect(key: bytes | None) -> None:
    """The link does not crash or hang; with a key it only accepts answers of the device."""
    line = open_line(key)
    samples = []
    line.inward = lambda data: samples.append(data) or [data]  # type: ignore[func-returns-value]
    for _ in range(3):
        pull(line)
    batch = 10
    bad = bad_frames(samples, FRAMES // 2, seed=3)
    for _ in range(FRAMES // 2 // batch):
        some = [frame for frame, _ in zip(bad, range(batch), strict=False)]
        line.inward = lambda data, some=some: [*some, data]  # type: ignore[misc]
        came = pull(line)
        assert came.state is not None
        assert np.isfinite(came.state).all()
        if key is not None:
            np.testing.assert_array_equal(came.state, robot_of(line.device).state())
        line.waiting.clear()


def test_a_flood_of_frames_does_not_block_an_exchange() -> None:
    line = open_line()
    line.inward = lambda data: [b"noise"] * 5000
    assert pull(line, within=0.0).state is None
    assert line.waiting  # only some of the frames are read


@pytest.mark.parametrize(
    ("faults", "missed"),
    [
        (Faults(), 0.0),
        (Faults(loss=0.05, seed=1), 0.2),
        (Faults(duplicate=0.3, reorder=0.1, corrupt=0.05, seed=2), 0.35),
        (Faults(jitter=0.002, seed=3), 0.5),
    ],
)
def test_exchanges_tolerate_faults_of_the_line(faults: Faults, missed: float) -> None:
    device = make_device(watchdog=10.0)
    states = []
    with served(device, line=FaultyLine(device, faults)) as uri, UdpLink(uri, timeout=5.0) as link:
        link.open(handshake(watchdog=10.0))
        for _ in range(100):
            came = pull(link, within=0.1)
            if came.state is not None:
                states.append(came.state)
    assert len(states) >= 100 * (1 - missed) - 10
    times = np.array(states)[:, 3]
    assert (np.diff(times) >= 0).all()  # never returns to an older state
    np.testing.assert_allclose(np.array(states)[:, 1], 20.0 * times, rtol=1e-9)
    given = np.array(robot_of(device).given)
    assert (given == PULL).all()


def test_serving_ends_in_the_safe_state() -> None:
    device = make_device(watchdog=10.0)
    stop = threading.Event()
    with DeviceServer(device, "udp://:0") as server, UdpLink(server.uri) as link:
        assert server.uri.startswith("udp://127.0.0.1:")
        thread = threading.Thread(target=server.run, args=(stop.is_set,))
        thread.start()
        link.open(handshake(watchdog=10.0))
        pull(link)
        assert device.state == "running"
        stop.set()
        thread.join()
        link._moving = False
    assert device.state == "safe"


def test_an_address_in_use_is_rejected() -> None:
    with served(make_device()) as uri, pytest.raises(HardwareError, match="cannot listen on"):
        DeviceServer(make_device(), uri)


@pytest.mark.parametrize(
    ("uri", "address"),
    [
        ("udp://127.0.0.1:5005", ("127.0.0.1", 5005)),
        ("udp://:5005", ("127.0.0.1", 5005)),
        ("udp://robot.local:1", ("robot.local", 1)),
        ("udp://[::1]:65535", ("::1", 65535)),
    ],
)
def test_udp_addresses_are_parsed(uri: str, address: tuple[str, int]) -> None:
    assert udp_address(uri) == address


INVALID_ADDRESSES = {
    "invalid hardware address": [
        *("", "127.0.0.1:5005", "tcp://127.0.0.1:5005", "loopback:x", "emulated://planar_2r")
    ],
    "the form is udp://HOST:PORT": [
        *("udp", "udp://", "udp://127.0.0.1", "udp://127.0.0.1:0", "udp://127.0.0.1:65536"),
        *("udp://127.0.0.1:-1", "udp://127.0.0.1:5005/x", "udp://127.0.0.1:5005?x=1"),
        *("udp://me@127.0.0.1:5005", "udp://[::1"),
    ],
    "the form is serial:///dev/ttyACM0": [
        *("serial:", "serial://", "serial:///dev/ttyACM0?baud=fast"),
        *("serial:///dev/ttyACM0?baud=0", "serial:///dev/ttyACM0?bauds=9600"),
        "serial://host/dev/ttyACM0",
    ],
    "invalid serial address 'serial:": ["serial:///dev/ttyACM0?baud=" + "9" * 5000],
    "requires a device in this process": ["loopback:"],
}


@pytest.mark.parametrize(
    ("uri", "message"),
    [
        pytest.param(uri, message, id=uri[:40])
        for message, uris in INVALID_ADDRESSES.items()
        for uri in uris
    ],
)
def test_invalid_addresses_are_rejected(uri: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        open_link(uri)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: UdpLink("udp://no.such.host.invalid:5005"), "unknown host"),
        (lambda: UdpLink("udp://127.0.0.1:5005", bind="192.0.2.1"), "cannot connect"),
        (
            lambda: open_link("serial:///dev/no-such-line"),
            "cannot connect to serial:///dev/no-such-line",
        ),
    ],
)
def test_a_link_that_cannot_be_opened_is_named(
    make: Callable[[], HardwareLink], message: str
) -> None:
    with pytest.raises(HardwareError, match=message):
        make().open(handshake())


@pytest.mark.parametrize("host", ["224.0.0.1", "255.255.255.255", "[ff02::1]", "[ff02::1%1]"])
def test_multicast_and_broadcast_addresses_are_rejected(host: str) -> None:
    """Otherwise several robots could receive the commands."""
    with pytest.raises(HardwareError, match=r"must be the address of one machine|unknown host"):
        UdpLink(f"udp://{host}:5005").open(handshake())
    with pytest.raises(HardwareError, match=r"must be the address of one machine|unknown host"):
        DeviceServer(make_device(), f"udp://{host}:0")


def test_a_device_that_stops_and_restarts_during_exchanges() -> None:
    """A connected socket reports a missing listener; this does not end a wait early."""
    device, fresh = make_device(), make_device()
    with served(device) as uri:
        link = UdpLink(uri)
        link.open(handshake(lockstep=True))
        for _ in range(50):
            assert pull(link).state is not None
    for is_polling in (False, True):
        link._receiver._is_polling = is_polling
        begin = time.monotonic()
        assert pull(link, within=0.05).state is None
        assert time.monotonic() - begin >= 0.05
    assert link.counters["refused"] > 0
    with served(fresh, uri), link:
        assert pull(link, within=0.05).state is None
        assert fresh.state == "idle"
        link.open(handshake(lockstep=True))
        assert pull(link).seq == 1


def test_a_link_may_use_ipv6() -> None:
    try:
        with served(make_device(), "udp://[::1]:0") as uri, UdpLink(uri) as link:
            link.open(handshake(lockstep=True))
            assert pull(link).seq == 1
    except HardwareError as error:
        pytest.skip(str(error))


def test_a_serial_link_requires_pyserial(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(HardwareError, match="uv sync --extra serial"):
        open_link("serial:///dev/null").open(handshake())


def test_noise_on_a_serial_line_damages_at_most_one_frame() -> None:
    """Random bytes between frames damage at most one frame."""
    with linked("serial", make_device()) as link:
        link.open(handshake(lockstep=True))
        for k in range(1, 20):
            link._line.write(os.urandom(k))  # type: ignore[attr-defined]
            came = pull(link)
            np.testing.assert_allclose(came.state[:3], k * STEP * PULL, rtol=1e-13)


def test_a_full_serial_line_does_not_block() -> None:
    """If the buffer is full, frames are lost; a truncated frame does not damage the next one."""
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    link = SerialLink(f"serial://{os.ttyname(theirs)}", timeout=0.2)
    link._connect()
    frame = pack(Frame(Kind.PING, 0, 1, 1, 0.0, 0, 0, np.ones(100)))
    while not link.counters["not sent"]:
        link._send(frame)
    link._send(frame)
    unstuffer, found = Unstuffer(MAX_BYTES), list[bytes]()
    while select.select([ours], (), (), 0.1)[0]:
        found += unstuffer.take(os.read(ours, 4096))
    last = pack(Frame(Kind.PING, 0, 1, 2, 0.0, 0, 0, np.ones(100)))
    link._send(last)
    while found[-1] != last:
        assert select.select([ours], (), (), SOON)[0]
        found += unstuffer.take(os.read(ours, 4096))
    for stump in set(found) - {frame, last}:  # the length or the checksum is wrong
        with pytest.raises(FrameError):
            unpack(stump)
    link.close()
    os.close(ours)
    os.close(theirs)


def test_an_exchange_requires_an_open_link() -> None:
    with pytest.raises(HardwareError, match="not open"):
        pull(UdpLink("udp://127.0.0.1:5005"))
    assert not UdpLink("udp://127.0.0.1:5005").stop()


def test_an_answer_that_differs_from_the_handshake_is_rejected() -> None:
    line = Line(make_device())

    def other_step(data: bytes) -> list[bytes]:
        frame = unpack(data)
        values = np.array(frame.values)
        values[2] *= 2
        return [pack(frame._replace(values=values))]

    line.inward = other_step
    with pytest.raises(HardwareError, match="other parameters than requested"):
        line.open(handshake())
    line.inward = lambda data: [pack(unpack(data)._replace(values=(1.0,)))]
    with pytest.raises(HardwareError, match="invalid values"):
        line.open(handshake())
