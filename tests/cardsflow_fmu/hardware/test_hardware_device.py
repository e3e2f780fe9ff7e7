"""Device: peers that may command the robot, run states, and the watchdog."""

from __future__ import annotations

import math
import struct
from collections.abc import Hashable

import numpy as np
import pytest
from support.hardware.hardware_devices import (
    COMMANDS,
    F_MAX,
    F_MIN,
    KEY,
    SIGNATURE,
    STATES,
    STEP,
    Integrator,
    handshake,
    make_device,
    robot_of,
)
from support.hardware.hardware_fuzz import FRAMES, bad_frames, with_checksum

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.device.device import PEER_TIMEOUT, Device
from cardsflow_fmu.hardware.protocol.frame import Flag, Frame, Keys, Kind, pack, unpack
from cardsflow_fmu.hardware.protocol.handshake import ErrorCode, Handshake, join_uint64

PEER, OTHER = ("127.0.0.1", 4000), ("127.0.0.1", 4001)
PULL = np.array([3.0, 20.0, 50.0])


class Talk:
    """Peer of a device, with a separate clock."""

    def __init__(
        self,
        device: Device,
        *,
        key: bytes | None = None,
        run: int = 77,
        peer: Hashable = PEER,
        now: float = 10.0,
    ) -> None:
        self.device, self.run, self.peer, self.now = device, run, peer, now
        self.keys = Keys(key)
        self.seq = 0

    def frame(self, kind: Kind, values=(), *, seq: int = 0, flags: int = 0) -> bytes:
        sent = int(self.now * 1e9)
        frame = Frame(kind, flags, self.run, seq, 0.0, sent, 0, values)
        return pack(frame, self.keys.key_for(kind))

    def send(self, data: bytes) -> list[Frame]:
        answers = self.device.receive(data, self.peer, self.now)
        return [self.keys.unpack(answer) for answer in answers]

    def handshake(self, request: Handshake | None = None) -> Frame:
        request = request or handshake()
        flags = int(Flag.LOCKSTEP) if request.lockstep else 0
        (answer,) = self.send(self.frame(Kind.HELLO, request.values(), flags=flags))
        if answer.kind is Kind.HELLO_ACK:
            nonce = join_uint64(*map(float, answer.values[7:9]))
            assert nonce is not None
            self.keys = self.keys.for_run(self.run, nonce)
        return answer

    def ping(self, request: Handshake | None = None) -> list[Frame]:
        """Confirm the run, like a link with a key."""
        request = request or handshake()
        flags = int(Flag.LOCKSTEP) if request.lockstep else 0
        return self.send(self.frame(Kind.PING, request.values(), flags=flags))

    def pull(self, command=PULL, *, seq: int | None = None) -> list[Frame]:
        self.seq = self.seq + 1 if seq is None else seq
        return self.send(self.frame(Kind.SETPOINT, command, seq=self.seq))


def talking(key: bytes | None = None, *, lockstep: bool = False, watchdog: float = 0.02) -> Talk:
    talk = Talk(make_device(key, watchdog=watchdog), key=key)
    assert talk.handshake(handshake(lockstep=lockstep, watchdog=watchdog)).kind is Kind.HELLO_ACK
    return talk


@pytest.mark.parametrize("key", [None, KEY])
def test_a_run_from_hello_to_stop(key: bytes | None) -> None:
    device = make_device(key)
    robot = robot_of(device)
    talk = Talk(device, key=key)
    assert (device.state, robot.safes) == ("idle", 1)
    answer = talk.handshake()
    assert device.state == "ready"
    assert not robot.given
    assert Handshake.from_values(answer.values[:7], False) == handshake()
    np.testing.assert_array_equal(answer.values[9:], robot.state())
    (state,) = talk.pull()
    assert device.state == "running"
    assert (state.kind, state.seq, state.run_id) == (Kind.STATE, 1, 77)
    assert state.echo_ns == int(talk.now * 1e9)
    np.testing.assert_array_equal(robot.given, [PULL])
    (stopped,) = talk.send(talk.frame(Kind.STOP))
    assert stopped.kind is Kind.STOPPED
    assert stopped.flags & Flag.SAFE
    assert (device.state, robot.safes) == ("safe", 2)


def test_the_robot_does_not_move_before_the_first_set_point() -> None:
    talk = Talk(make_device())
    for expected in ("idle", "ready"):
        assert talk.device.state == expected
        talk.device.advance(0.1)
        assert robot_of(talk.device).time == 0.0
        talk.handshake()
    talk.pull()
    talk.device.advance(0.1)
    np.testing.assert_allclose(robot_of(talk.device).x, 0.1 * PULL, rtol=1e-15)


def test_the_watchdog_expires_and_only_a_new_run_ends_the_safe_state() -> None:
    talk = talking()
    robot = robot_of(talk.device)
    talk.pull()
    talk.device.tick(talk.now + 0.0199)
    assert talk.device.state == "running"
    assert talk.device.next_deadline == pytest.approx(talk.now + 0.02)
    talk.device.tick(talk.now + 0.0201)
    assert talk.device.state == "safe"
    assert robot.safes == 2
    given = len(robot.given)
    talk.now += 0.03
    (state,) = talk.pull()
    assert state.flags & Flag.SAFE
    assert len(robot.given) == given
    assert Talk(talk.device, run=78).handshake().kind is Kind.HELLO_ACK
    assert talk.device.state == "ready"
    assert talk.device.counters["watchdog"] == 1


def test_a_set_point_after_the_watchdog_timeout_is_too_late() -> None:
    """Tested without a call of `tick` before the set point."""
    talk = talking()
    talk.pull()
    talk.now += 0.021
    (state,) = talk.pull()
    assert state.flags & Flag.SAFE
    assert len(robot_of(talk.device).given) == 1


def test_copies_and_old_set_points_do_not_reset_the_watchdog() -> None:
    talk = talking()
    talk.pull(seq=5)
    for k, seq in enumerate((5, 4, 1, 2**32 - 1)):
        talk.now += 0.006
        if k < 3:
            assert talk.pull(seq=seq) == []
    talk.device.tick(talk.now)
    assert talk.device.state == "safe"
    assert talk.device.counters["stale"] == 3
    assert len(robot_of(talk.device).given) == 1


def test_the_newest_of_reordered_set_points_is_used() -> None:
    talk = talking()
    for seq, force in ((1, 5.0), (3, 7.0), (2, 6.0), (4, 8.0)):
        talk.pull(np.full(COMMANDS, force), seq=seq)
    np.testing.assert_array_equal(np.array(robot_of(talk.device).given)[:, 0], [5.0, 7.0, 8.0])


def test_sequence_numbers_may_wrap_around() -> None:
    talk = talking()
    for seq in (2**31 - 1, 2**32 - 2, 2**32 - 1, 0, 1):
        assert len(talk.pull(seq=seq)) == 1
    assert talk.pull(seq=2**32 - 1) == []


def test_forces_are_clamped_with_a_flag() -> None:
    talk = talking()
    (state,) = talk.pull([-1e308, 10.0, 1e308])
    np.testing.assert_array_equal(robot_of(talk.device).given[-1], [F_MIN, 10.0, F_MAX])
    assert state.flags & Flag.CLAMPED
    (state,) = talk.pull()
    assert not state.flags & Flag.CLAMPED


def test_in_lockstep_a_set_point_is_one_step_and_its_copy_is_none() -> None:
    talk = talking(lockstep=True)
    robot = robot_of(talk.device)
    for k in range(1, 4):
        (state,) = talk.pull(seq=k)
        np.testing.assert_allclose(state.values[:3], k * STEP * PULL, rtol=1e-14)
        assert state.t_sim == pytest.approx(k * STEP)
        again = talk.pull(seq=k)
        assert again[0].values.tobytes() == state.values.tobytes()
    assert len(robot.given) == 3
    talk.device.advance(1.0)
    assert robot.time == pytest.approx(3 * STEP)
    talk.device.tick(talk.now + 1e6)
    assert talk.device.state == "running"


def test_values_are_scaled_both_ways() -> None:
    device = make_device(scale=4.0)
    talk = Talk(device)
    talk.handshake(Handshake(SIGNATURE, STEP, 4.0, 0.02, COMMANDS, STATES, True))
    (state,) = talk.pull([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(robot_of(device).given[-1], [4.0, 8.0, 12.0])
    np.testing.assert_allclose(4 * state.values, robot_of(device).state(), rtol=1e-15)
    assert talk.pull([1e308, 2.0, 3.0]) == []
    assert device.counters["not finite"] == 1


REQUESTS = [
    (handshake(), None),
    (Handshake(SIGNATURE ^ 1, STEP, 1.0, 0.02, COMMANDS, STATES, False), ErrorCode.PORTS),
    (Handshake(SIGNATURE, STEP, 1.0, 0.02, COMMANDS + 1, STATES, False), ErrorCode.PORTS),
    (Handshake(SIGNATURE, STEP, 1.0, 0.02, COMMANDS, STATES - 1, False), ErrorCode.PORTS),
    (Handshake(SIGNATURE, STEP, 2.0, 0.02, COMMANDS, STATES, False), ErrorCode.SCALE),
    (handshake(step=0.5 * STEP, lockstep=True), ErrorCode.STEP),
    (handshake(step=1.5 * STEP, lockstep=True), ErrorCode.STEP),
    (handshake(step=5 * STEP, lockstep=True), None),
    (handshake(step=1000 * STEP, lockstep=True), None),
    (handshake(step=1001 * STEP, lockstep=True), ErrorCode.STEP),
    (handshake(step=1e308, lockstep=True), ErrorCode.STEP),
    (handshake(step=1e308), ErrorCode.WATCHDOG),
    (handshake(step=0.0), ErrorCode.STEP),
    (handshake(step=-1.0), ErrorCode.STEP),
    (handshake(step=-1.0, lockstep=True), ErrorCode.STEP),
    (Handshake(SIGNATURE, STEP, 0.0, 0.02, COMMANDS, STATES, False), ErrorCode.SCALE),
    (handshake(watchdog=-1.0), ErrorCode.WATCHDOG),
    (handshake(watchdog=-1.0, lockstep=True), ErrorCode.WATCHDOG),
    (handshake(step=0.5 * STEP), None),
    (handshake(step=0.011), ErrorCode.WATCHDOG),
    (handshake(watchdog=0.0015), ErrorCode.WATCHDOG),
    (handshake(watchdog=0.0), None),
]


@pytest.mark.parametrize(("asked", "refusal"), REQUESTS)
def test_a_device_accepts_valid_handshakes_only(
    asked: Handshake, refusal: ErrorCode | None
) -> None:
    talk = Talk(make_device())
    answer = talk.handshake(asked)
    if refusal is None:
        assert answer.kind is Kind.HELLO_ACK
    else:
        assert (answer.kind, answer.values[0]) == (Kind.ERROR, refusal)
        assert talk.device.state == "idle"


@pytest.mark.parametrize(
    ("requested", "agreed"), [(0.005, 0.005), (0.02, 0.02), (1.0, 0.02), (0, 0.02)]
)
def test_the_shorter_watchdog_is_used(requested: float, agreed: float) -> None:
    talk = Talk(make_device())
    assert talk.handshake(handshake(watchdog=requested)).values[4] == agreed
    talk.pull()
    assert talk.device.next_deadline == pytest.approx(talk.now + agreed)


def test_a_repeated_hello_has_the_same_answer_until_the_first_set_point() -> None:
    """The answer may have been lost. The nonce does not change, and the robot is not reset."""
    talk = Talk(make_device())
    first, again = talk.handshake(), talk.handshake()
    assert first.values.tobytes() == again.values.tobytes()
    assert robot_of(talk.device).resets == 2  # in the constructor, and once for the run
    talk.pull()
    assert talk.send(talk.frame(Kind.HELLO, handshake().values())) == []
    assert talk.device.state == "running"


@pytest.mark.parametrize("peer", [PEER, OTHER])
def test_another_peer_cannot_replace_a_running_run(peer: Hashable) -> None:
    talk = talking(watchdog=60.0)
    talk.pull()
    thief = Talk(talk.device, run=78, peer=peer)
    for thief.now in (10.0, 10.0 + 3 * PEER_TIMEOUT):
        answer = thief.handshake()
        assert (answer.kind, answer.values[0]) == (Kind.ERROR, ErrorCode.BUSY)
    assert talk.device.run_id == 77
    assert len(talk.pull()) == 1


@pytest.mark.parametrize("lockstep", [False, True])
def test_another_peer_may_replace_an_idle_run_after_the_timeout(lockstep: bool) -> None:
    talk = talking(lockstep=lockstep)
    if lockstep:
        talk.pull()
    other = Talk(talk.device, run=78, peer=OTHER)
    assert other.handshake().kind is Kind.ERROR
    other.now += 1.01 * PEER_TIMEOUT
    assert other.handshake().kind is Kind.HELLO_ACK
    assert talk.pull() == []
    assert talk.device.counters["run"] == 1


def test_frames_of_another_run_or_peer_are_dropped() -> None:
    talk = talking()
    talk.pull()
    for stranger in (Talk(talk.device, run=78), Talk(talk.device, peer=OTHER)):
        for kind in (Kind.SETPOINT, Kind.STOP, Kind.PING):
            assert stranger.send(stranger.frame(kind, PULL, seq=9)) == []
    assert talk.device.state == "running"
    assert len(robot_of(talk.device).given) == 1
    assert (talk.device.counters["run"], talk.device.counters["peer"]) == (3, 3)


def test_before_a_run_only_a_hello_is_accepted() -> None:
    talk = Talk(make_device(), run=0, peer=None)
    for kind in (Kind.SETPOINT, Kind.STOP, Kind.PING, Kind.STATE, Kind.ERROR):
        assert talk.send(talk.frame(kind, PULL, seq=1)) == []
    assert talk.send(talk.frame(Kind.HELLO, handshake().values())) == []  # a run id must not be 0
    assert talk.device.state == "idle"


def test_kinds_of_frames_that_devices_send_are_dropped() -> None:
    talk = talking()
    for kind in (Kind.HELLO_ACK, Kind.STATE, Kind.STOPPED, Kind.ERROR, Kind.PONG):
        assert talk.send(talk.frame(kind, np.zeros(STATES), seq=1)) == []
    assert talk.device.counters["type"] == 5


def test_a_set_point_of_another_length_is_dropped() -> None:
    talk = talking()
    for count in (0, COMMANDS - 1, COMMANDS + 1):
        assert talk.pull(np.ones(count)) == []
    assert talk.device.state == "ready"
    assert talk.device.counters["count"] == 3


def test_a_ping_is_answered_with_its_values() -> None:
    talk = talking(KEY)
    (pong,) = talk.send(talk.frame(Kind.PING, [1.0, 2.0], seq=4))
    assert (pong.kind, pong.seq, list(pong.values)) == (Kind.PONG, 4, [1.0, 2.0])
    assert talk.device.state == "ready"


@pytest.mark.parametrize("how", ["failing", "broken"])
@pytest.mark.parametrize("lockstep", [False, True])
def test_a_failed_robot_enters_the_safe_state_with_a_flag(how: str, lockstep: bool) -> None:
    talk = talking(lockstep=lockstep)
    robot = robot_of(talk.device)
    talk.pull()
    if how == "failing":
        robot.failing = True
        talk.device.advance(STEP)
    else:
        robot.broken = math.nan
    (state,) = talk.pull()
    assert talk.device.state == "safe"
    assert state.flags & Flag.SAFE
    assert state.flags & Flag.FAULT
    assert np.isfinite(state.values).all()
    assert talk.device.failure
    answer = Talk(talk.device, run=78).handshake()
    assert answer.kind is (Kind.ERROR if how == "broken" else Kind.HELLO_ACK)


def test_signed_frames_of_an_earlier_run_are_dropped() -> None:
    """Even if the attacker starts a run with the recorded handshake."""
    talk = talking(KEY)
    recorded = [talk.frame(Kind.SETPOINT, PULL, seq=k) for k in range(1, 20)]
    first_hello = talk.frame(Kind.HELLO, handshake().values())
    talk.pull()
    talk.send(talk.frame(Kind.STOP))
    assert Talk(talk.device, key=KEY, run=80).handshake().kind is Kind.HELLO_ACK
    given = len(robot_of(talk.device).given)
    assert len(talk.device.receive(first_hello, PEER, talk.now)) == 1
    assert talk.device.run_id == 77
    assert [talk.device.receive(frame, PEER, talk.now) for frame in recorded] == 19 * [[]]
    assert len(robot_of(talk.device).given) == given
    assert talk.device.state == "ready"
    assert talk.device.counters["signature"] == 19


@pytest.mark.parametrize(
    "settings",
    [
        {"f_min": [1.0, 2.0], "f_max": 3.0},
        {"f_min": math.nan, "f_max": 3.0},
        {"f_min": 4.0, "f_max": 3.0},
        {"f_min": 0.0, "f_max": 3.0, "watchdog": 0.0},
        {"f_min": 0.0, "f_max": 3.0, "scale": math.inf},
        {"f_min": 0.0, "f_max": 3.0, "key": b"short"},
    ],
)
def test_invalid_capabilities_are_rejected(settings) -> None:
    with pytest.raises(InputError):
        Device(Integrator(), 1, STEP, **settings)


def is_acceptable(data: bytes, run: int, key: bytes | None) -> bool:
    """Return whether a device may process a frame, according to the protocol."""
    if key is not None or len(data) < 48 or data[:5] != b"CFHW\1" or data[6] & 1:
        return False
    count = struct.unpack_from("<H", data, 40)[0]
    if len(data) != 48 + 8 * count or with_checksum(data) != data:
        return False
    numbers = [*struct.unpack_from("<d", data, 16), *struct.unpack_from(f"<{count}d", data, 48)]
    mine = data[5] == Kind.HELLO or struct.unpack_from("<I", data, 8)[0] == run
    return mine and all(map(math.isfinite, numbers)) and data[5] in (1, 3, 5, 8)


@pytest.mark.parametrize("lockstep", [False, True])
@pytest.mark.parametrize("key", [None, KEY])
def test_invalid_frames_have_no_effect(key: bytes | None, lockstep: bool) -> None:
    """The device does not crash, forces stay within limits, and frames of others are dropped."""
    talk = talking(key, lockstep=lockstep, watchdog=60.0)
    old = Talk(make_device(key), key=key, run=5)
    old.handshake()
    samples = [
        talk.frame(Kind.HELLO, handshake().values()),
        *(talk.frame(Kind.SETPOINT, PULL, seq=seq) for seq in (1, 2, 50, 2**31)),
        talk.frame(Kind.STOP),
        talk.frame(Kind.PING, [1.0]),
        old.frame(Kind.SETPOINT, PULL, seq=3),
    ]
    device, robot = talk.device, robot_of(talk.device)
    owner: Hashable = PEER
    answered = 0
    for k, data in enumerate(bad_frames(samples, FRAMES // 4, seed=2)):
        now, peer = talk.now + 1e-4 * k, PEER if k % 3 else OTHER
        device.tick(now)
        before = (device.state, device.run_id, len(robot.given), robot.resets)
        may = is_acceptable(data, device.run_id, key) and (peer == owner or data[5] == Kind.HELLO)
        answers = device.receive(data, peer, now)
        after = (device.state, device.run_id, len(robot.given), robot.resets)
        answered += len(answers)
        if not may:
            assert answers == []
            assert after == before
        for answer in map(unpack, answers):
            assert np.isfinite(answer.values).all()
            owner = peer if answer.kind is Kind.HELLO_ACK else owner
        if key is None and device.state == "safe":
            talk, owner = Talk(device, run=k + 100, now=now), PEER
            assert talk.handshake(handshake(lockstep=lockstep)).kind is Kind.HELLO_ACK
        if len(robot.given) > 100:
            check_bounds(robot)
    check_bounds(robot)
    assert (answered > 0) == (key is None)
    if key is not None:
        talk.now = now
        assert len(talk.pull(seq=60)) == 1


def check_bounds(robot: Integrator) -> None:
    given = np.array(robot.given)
    assert ((given >= F_MIN) & (given <= F_MAX)).all()
    robot.given.clear()


def recorded_run(device: Device, run: int = 77, *, lockstep: bool = False) -> bytes:
    """Return the HELLO of a run that has ended."""
    talk = Talk(device, key=KEY, run=run)
    flags = int(Flag.LOCKSTEP) if lockstep else 0
    hello = talk.frame(Kind.HELLO, handshake(lockstep=lockstep).values(), flags=flags)
    assert talk.handshake(handshake(lockstep=lockstep)).kind is Kind.HELLO_ACK
    talk.pull()
    talk.send(talk.frame(Kind.STOP))
    assert device.state == "safe"
    return hello


def kinds(answers: list[bytes]) -> list[int]:
    return [answer[5] for answer in answers]


def test_hellos_of_earlier_runs_do_not_block_the_device() -> None:
    """An attacker may send recorded HELLOs repeatedly from any address."""
    device = make_device(KEY)
    hellos = [recorded_run(device, run) for run in (70, 71, 72)]
    for k in range(30):
        device.receive(hellos[k % 3], OTHER if k % 2 else ("127.0.0.1", 5000 + k), 20.0 + 0.1 * k)
    assert device.state == "ready"
    talk = Talk(device, key=KEY, run=78, now=23.0)
    assert talk.handshake().kind is Kind.HELLO_ACK
    assert len(talk.pull()) == 1


def test_copies_of_a_hello_do_not_keep_a_device_ready() -> None:
    """Also not a HELLO that the device has never received before."""
    device = make_device(KEY)
    thief, talk = Talk(device, key=KEY, run=90, peer=OTHER), Talk(device, key=KEY, run=78)
    hello = thief.frame(Kind.HELLO, handshake().values())
    for now in (10.0, 10.4, 10.8, 10.0 + PEER_TIMEOUT):
        assert kinds(device.receive(hello, OTHER, now)) == [Kind.HELLO_ACK]
        talk.now = now
        assert talk.handshake().kind is Kind.HELLO_ACK
    assert [answer.kind for answer in talk.ping()] == [Kind.PONG]
    for k in range(10):  # nor does it replace a confirmed run
        assert kinds(device.receive(hello, OTHER, talk.now + 0.1 * k)) == [Kind.ERROR]
    talk.now += 0.99 * PEER_TIMEOUT
    assert len(talk.pull()) == 1
    assert device.state == "running"


@pytest.mark.parametrize("source", [PEER, OTHER], ids=["forged address", "other address"])
@pytest.mark.parametrize("lockstep", [False, True])
def test_recorded_hellos_do_not_delay_a_run(source: Hashable, lockstep: bool) -> None:
    """An attacker has more recorded HELLOs than any device remembers, and sends them always."""
    device, request = make_device(KEY), handshake(lockstep=lockstep)
    thieves = (Talk(device, key=KEY, run=1000 + k) for k in range(2000))
    hellos = [thief.frame(Kind.HELLO, handshake().values()) for thief in thieves]

    def replay(count: int) -> None:
        for _ in range(count):
            device.receive(hellos.pop(), source, talk.now)

    for run in (78, 79):
        talk = Talk(device, key=KEY, run=run, now=float(run))
        replay(300)
        assert talk.handshake(request).kind is Kind.HELLO_ACK
        replay(300)
        assert [answer.kind for answer in talk.ping(request)] == [Kind.PONG]
        replay(300)
        (state,) = talk.pull()
        assert bool(state.flags & Flag.LOCKSTEP) == lockstep
        talk.send(talk.frame(Kind.STOP))


def test_recorded_pings_confirm_no_run() -> None:
    device = make_device(KEY)
    old = Talk(device, key=KEY)
    hello = old.frame(Kind.HELLO, handshake().values())
    old.handshake()
    pings = [old.frame(Kind.PING, handshake().values()) for _ in range(2)]
    assert kinds(device.receive(pings[0], PEER, 10.0)) == [Kind.PONG]
    old.send(old.frame(Kind.STOP))
    recorded_run(device, 80)
    for now in (10.1, 10.2):
        assert kinds(device.receive(hello, PEER, now)) == [Kind.HELLO_ACK]
        assert [device.receive(ping, PEER, now) for ping in pings] == [[], []]
    assert device.counters["signature"] == 4
    assert Talk(device, key=KEY, run=78, now=10.2).handshake().kind is Kind.HELLO_ACK


def test_the_first_of_two_peers_to_confirm_its_run_gets_the_device() -> None:
    device = make_device(KEY)
    slow, fast = Talk(device, key=KEY, run=78), Talk(device, key=KEY, run=79, peer=OTHER)
    for talk in (fast, slow):
        assert talk.handshake().kind is Kind.HELLO_ACK
    assert [answer.kind for answer in fast.ping()] == [Kind.PONG]
    assert slow.ping() == []
    assert slow.handshake().kind is Kind.ERROR
    assert len(fast.pull()) == 1


def test_copies_of_set_points_do_not_prolong_a_run_in_lockstep() -> None:
    talk = talking(KEY, lockstep=True)
    talk.pull()
    copy = talk.frame(Kind.SETPOINT, PULL, seq=1)
    for now in (10.5, 11.0, 11.5):
        assert kinds(talk.device.receive(copy, PEER, now)) == [Kind.STATE]
    other = Talk(talk.device, key=KEY, run=78, peer=OTHER, now=11.5)
    assert other.handshake().kind is Kind.HELLO_ACK


def test_a_set_point_clears_a_failure_and_a_copied_hello_does_not() -> None:
    device = make_device(KEY)
    hello = recorded_run(device)
    talk = Talk(device, key=KEY, run=78)
    talk.handshake()
    talk.pull()
    robot_of(device).failing = True
    device.advance(STEP)
    assert "hinges" in device.failure
    for now in (11.0, 11.5):
        assert kinds(device.receive(hello, OTHER, now)) == [Kind.HELLO_ACK]
        assert device.state == "ready"
        assert "hinges" in device.failure
    robot_of(device).failing = False
    talk = Talk(device, key=KEY, run=79, now=12.0)
    assert not talk.handshake().flags & Flag.FAULT
    assert "hinges" in device.failure
    (state,) = talk.pull()
    assert not state.flags & (Flag.FAULT | Flag.SAFE)
    assert device.failure == ""
