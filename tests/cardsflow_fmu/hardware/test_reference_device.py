"""Reference device in C, compiled like firmware and tested with the UDP link."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from support.hardware.hardware_devices import rejection
from support.hardware.hardware_fuzz import FRAMES, bad_frames

from cardsflow_fmu.experiment.settings.hardware import FailureSettings
from cardsflow_fmu.hardware.emulator.failures import Failures, Measurement
from cardsflow_fmu.hardware.links.udp import UdpLink
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES, Flag, Frame, Kind, pack, unpack
from cardsflow_fmu.hardware.protocol.handshake import Handshake

SOURCE = Path(__file__).parents[3] / "examples/hardware_in_the_loop/device.c"
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wshadow", "-Wconversion"]
SANITIZED = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
SIGNATURE = 0x0123_4567_89AB_CDEF
KEYS = [None, b"a pre-shared key of some length", b"k" * 100]
JOINTS, MUSCLES = 2, 4
COMMANDS, STATES = MUSCLES, 2 * JOINTS + 2 * MUSCLES
STEP, F_MIN, F_MAX = 1e-3, 10.0, 500.0
PULL = np.array([100.0, 20.0, 10.0, 300.0])
SOON = 30.0
"""Timeout that is sufficient even on a machine that is ten times slower, in [s]."""
SILENCE = 0.05
"""Time to wait for an answer that must not arrive, in [s]."""

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture(scope="session")
def built(compiler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile the device, for machines that are busy with other tests."""
    program = tmp_path_factory.mktemp("device") / "device"
    compile_device(compiler, program, ["-O2", "-DPEER_TIMEOUT=1000"])
    return program


def compile_device(compiler: str, program: Path, options: list[str]) -> None:
    command = [compiler, *STRICT, *options, "-o", str(program), str(SOURCE), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@contextmanager
def running(
    program: Path, folder: Path, key: bytes | None = None, faults: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the address of a running device, which must end without output on stderr."""
    arguments = [str(program), "127.0.0.1", "0", f"{SIGNATURE:x}"]
    if key is not None:
        (folder / "key.bin").write_bytes(key)
        arguments.append(str(folder / "key.bin"))
    arguments += [word for fault in faults for word in ("--fault", fault)]
    device = subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={}
    )
    try:
        yield device.stdout.readline().strip()
        assert device.poll() is None, "the device has ended by itself"
    finally:
        device.send_signal(signal.SIGTERM)
        _, complaints = device.communicate(timeout=600)
    assert (device.returncode, complaints) == (0, "")


def handshake(*, lockstep: bool = False, step: float = STEP) -> Handshake:
    return Handshake(SIGNATURE, step, 1.0, 0.02, COMMANDS, STATES, lockstep)


def pull(link: UdpLink, command=PULL, *, within: float = SOON) -> Exchange:
    return link.exchange(0.0, np.asarray(command, float), time.monotonic() + within)


def followed(commands: np.ndarray, h: float, failures: Failures | None = None) -> np.ndarray:
    """Return the expected states: a first-order lag by the backward Euler method.

    Failures are those of the emulator.
    """
    failures = failures or Failures((), (), ())
    tension, q = np.full(MUSCLES, F_MIN), np.zeros(JOINTS)
    turn = 1e-3 * np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])
    rows = []
    for k, command in enumerate(commands):
        tension, time_ = (0.005 * tension + h * command) / (0.005 + h), (k + 1) * h
        pull_ = failures.change_tensions(tension, length_of(q), time_)
        q_before, q = q, (0.1 * q + h * turn @ pull_) / (0.1 + h)
        pull_ = failures.change_tensions(tension, length_of(q), time_)
        lengths = failures.motor_lengths(length_of(q)).copy()
        seen = Measurement(q.copy(), (q - q_before) / h, lengths, pull_.copy())
        failures.change_measurement(seen, time_)
        rows.append([*seen.q, *seen.qd, *seen.lengths, *seen.tensions])
    return np.array(rows)


def length_of(q: np.ndarray) -> np.ndarray:
    return 0.3 - 0.02 * np.array([q[0], q[1], -q[0], -q[1]])


@pytest.mark.slow
def test_failures_are_those_of_the_emulator(built: Path, tmp_path: Path) -> None:
    names = [str(k) for k in range(MUSCLES)]
    kinds = {
        "broken": None, "jammed": 5e4, "weak": 0.5, "off_pulley": 0.01, "length_stuck": None,
        "length_bias": -0.02, "length_drift": 1.0, "length_scale": 1.5, "length_swapped": "3",
        "tension_stuck": None, "tension_dead": None, "encoder_stuck": None,
    }  # fmt: skip
    commands = np.random.default_rng(0).uniform(F_MIN, F_MAX, (12, COMMANDS))
    for k, (kind, value) in enumerate(kinds.items()):
        part = str(k % JOINTS if kind == "encoder_stuck" else k % 3)
        other = {"other": value} if kind == "length_swapped" else {}
        number = {} if other or value is None else {"value": value}
        settings = FailureSettings(kind=kind, part=part, time=4.5e-3, **number, **other)
        expected = followed(commands, STEP, Failures([settings], names, names[:JOINTS]))
        text = f"{kind}:{part}" + ("" if value is None else f"={value}") + "@4.5e-3"
        with running(built, tmp_path, None, [text]) as uri, UdpLink(uri, timeout=SOON) as link:
            link.open(handshake(lockstep=True))
            for command, state in zip(commands, expected, strict=True):
                came = pull(link, command)
                np.testing.assert_allclose(came.state, state, rtol=1e-9, atol=1e-12, err_msg=text)
            assert link.stop()


@pytest.mark.parametrize("fault", ["brokn:1@2", "broken:9@2", "broken:1=3@2", "weak:1@2", "x"])
def test_wrong_failures_are_rejected(built: Path, fault: str) -> None:
    words = [str(built), "127.0.0.1", "0", "ff", "--fault", fault]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("device: --fault must be KIND:NUMBER[=VALUE]@TIME")


def test_the_source_is_short_and_does_not_allocate_memory() -> None:
    assert len(SOURCE.read_text().splitlines()) < 300
    for file in SOURCE.parent.glob("*.[ch]"):
        assert re.search(r"\b([mc]alloc|realloc|alloca|free)\b", file.read_text()) is None


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("step", [STEP, 5 * STEP])
def test_lockstep(built: Path, tmp_path: Path, key: bytes | None, step: float) -> None:
    commands = np.random.default_rng(0).uniform(F_MIN, F_MAX, (100, COMMANDS))
    expected = followed(commands, step)
    with running(built, tmp_path, key) as uri, UdpLink(uri, key=key, timeout=SOON) as link:
        link.open(handshake(lockstep=True, step=step))
        np.testing.assert_array_equal(link.start_state, [0] * 4 + [0.3] * 4 + [F_MIN] * 4)
        for command, state in zip(commands, expected, strict=True):
            came = pull(link, command)
            np.testing.assert_allclose(came.state, state, rtol=1e-9, atol=1e-12)
        assert link.stop()


@pytest.mark.slow
def test_in_real_time_tensions_follow_and_the_watchdog_expires(built: Path, tmp_path: Path) -> None:
    with running(built, tmp_path) as uri, UdpLink(uri, timeout=SOON) as link:
        for _ in range(100):  # a busy machine may delay set points for too long
            link.open(handshake())
            begin, came = time.monotonic(), pull(link)
            while time.monotonic() < begin + 0.1 and not came.device_flags & Flag.SAFE:
                time.sleep(1e-3)
                came = pull(link)
            if not came.device_flags & Flag.SAFE:
                break
        np.testing.assert_allclose(came.state[-4:], PULL, rtol=1e-4)
        time.sleep(0.2)
        came = pull(link)
        assert came.device_flags & Flag.SAFE
        np.testing.assert_allclose(came.state[-4:], F_MIN, rtol=1e-4)
        link.open(handshake())
        assert not pull(link).device_flags & Flag.SAFE


def test_forces_are_clamped(built: Path, tmp_path: Path) -> None:
    with running(built, tmp_path) as uri, UdpLink(uri, timeout=SOON) as link:
        link.open(handshake(lockstep=True))
        wild = np.array([-1e308, 1e308, 0.0, 501.0])
        came = [pull(link, wild) for _ in range(200)][-1]
        assert came.device_flags & Flag.CLAMPED
        np.testing.assert_allclose(came.state[-4:], [F_MIN, F_MAX, F_MIN, F_MAX], rtol=1e-9)
        assert not pull(link).device_flags & Flag.CLAMPED


def test_runs_are_rejected_with_a_reason(built: Path, tmp_path: Path) -> None:
    requests = [
        (Handshake(1, STEP, 1.0, 0.02, COMMANDS, STATES, False), "signals"),
        (Handshake(SIGNATURE, STEP, 1.0, 0.02, COMMANDS + 1, STATES, False), "signals"),
        (Handshake(SIGNATURE, STEP, 2.0, 0.02, COMMANDS, STATES, False), "scale"),
        (handshake(step=1.5 * STEP, lockstep=True), "time step"),
        (handshake(step=1e300, lockstep=True), "time step"),
        (handshake(step=0.011), "watchdog"),
    ]
    with running(built, tmp_path) as uri, UdpLink(uri, timeout=SOON) as link:
        for request, word in requests:
            with pytest.raises(HardwareError, match=f"rejected the run: .*{word}"):
                link.open(request)
        link.open(handshake(lockstep=True))
        pull(link)
        assert "another run uses it" in rejection(uri, handshake())
        assert pull(link).seq == 2


def test_with_a_key_only_signed_frames_are_accepted(built: Path, tmp_path: Path) -> None:
    key = KEYS[1]
    with running(built, tmp_path, key) as uri:
        for wrong in (None, key[::-1], key[:-1]):
            with pytest.raises(HardwareError, match="no device answers"):
                UdpLink(uri, key=wrong, timeout=0.1).open(handshake())
    (tmp_path / "short").write_bytes(b"short")
    arguments = [str(built), "127.0.0.1", "0", "1", str(tmp_path / "short")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "16 to 256 bytes" in done.stderr


def test_a_copy_is_answered_in_lockstep_and_dropped_in_real_time(
    built: Path, tmp_path: Path
) -> None:
    for lockstep in (True, False):
        with running(built, tmp_path) as uri, conversation(uri) as say:
            request = handshake(lockstep=lockstep)
            flags = int(Flag.LOCKSTEP) if lockstep else 0
            answer = say(Frame(Kind.HELLO, flags, 5, 0, 0.0, 1, 0, request.values()))
            assert answer.kind is Kind.HELLO_ACK
            first = say(Frame(Kind.SETPOINT, 0, 5, 1, 0.0, 22, 0, PULL))
            assert (first.kind, first.seq, first.echo_ns) == (Kind.STATE, 1, 22)
            within = SOON if lockstep else SILENCE
            again = say(Frame(Kind.SETPOINT, 0, 5, 1, 0.0, 33, 0, PULL), within)
            assert (again is not None) == lockstep
            assert say(Frame(Kind.SETPOINT, 0, 5, 0, 0.0, 33, 0, PULL), SILENCE) is None
            assert say(Frame(Kind.SETPOINT, 0, 6, 2, 0.0, 33, 0, PULL), SILENCE) is None
            assert say(Frame(Kind.SETPOINT, 0, 5, 2, 0.0, 33, 0, PULL[:3]), SILENCE) is None
            pong = say(Frame(Kind.PING, 0, 5, 7, 0.0, 44, 0, (1.0, 2.0)))
            assert (pong.kind, pong.echo_ns, list(pong.values)) == (Kind.PONG, 44, [1.0, 2.0])
            stopped = say(Frame(Kind.STOP, 0, 5, 8, 0.0, 55, 0, ()))
            assert stopped.kind is Kind.STOPPED
            assert stopped.flags & Flag.SAFE


def test_copies_of_a_hello_do_not_block_the_device(built: Path, tmp_path: Path) -> None:
    """Tested before and after a run, with more recorded HELLOs than a device could remember."""
    key = KEYS[1]

    def hello(run: int) -> bytes:
        return pack(Frame(Kind.HELLO, 0, run, 0, 0.0, 1, 0, handshake().values()), key)

    with (
        running(built, tmp_path, key) as uri,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as thief,
    ):
        host, port = uri.removeprefix("udp://").split(":")
        thief.connect((host, int(port)))
        thief.settimeout(SOON)

        runs = count(1)

        def copied() -> int:
            """Send a HELLO that the device has not received before. Return the answer."""
            thief.send(hello(next(runs)))
            return thief.recv(MAX_BYTES)[5]

        for _ in range(2):
            with UdpLink(uri, key=key, timeout=SOON) as link:
                send, first = link._send, {Kind.HELLO, Kind.PING}

                def attacked(
                    data: bytes,
                    send: Callable[[bytes], None] = send,
                    first: set[Kind] = first,
                ) -> None:
                    if data[5] in first:
                        first.remove(Kind(data[5]))
                        assert {copied() for _ in range(100)} == {Kind.HELLO_ACK}
                    send(data)

                link._send = attacked  # type: ignore[method-assign]
                link.open(handshake())  # the copies replace the run until its PING arrives
                link._send = send  # type: ignore[method-assign]
                assert first == set()
                assert {copied() for _ in range(100)} == {Kind.ERROR}
                assert pull(link).seq == 1


def test_without_a_key_it_warns_if_other_machines_can_reach_it(built: Path) -> None:
    for address, warned in (("0.0.0.0", True), ("127.0.0.1", False)):
        device = subprocess.Popen(
            [str(built), address, "0", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        assert device.stdout is not None
        assert device.stdout.readline().startswith(b"udp://")
        device.terminate()
        _, words = device.communicate(timeout=600)
        assert (b"anyone on the network can command the robot" in words) == warned


@contextmanager
def conversation(uri: str) -> Iterator[Callable[..., Frame | None]]:
    """Yield a function that sends a frame to a device and returns the answer, if there is one."""
    host, port = uri.removeprefix("udp://").split(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.connect((host, int(port)))

        def say(frame: Frame, within: float = SOON) -> Frame | None:
            line.settimeout(within)
            line.send(pack(frame))
            try:
                return unpack(line.recv(MAX_BYTES))
            except TimeoutError:
                return None

        yield say


@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize(
    ("key", "encoders"),
    [(None, JOINTS), (KEYS[1], JOINTS), (None, 0)],
    ids=["unsigned", "signed", "no joint encoders"],
)
def test_invalid_frames_have_no_effect_under_the_sanitizers(
    compiler: str, tmp_path: Path, key: bytes | None, encoders: int
) -> None:
    """Tensions stay within limits, and a valid link still receives answers."""
    program, asked = tmp_path / "sanitized", handshake(lockstep=True)
    asked = replace(asked, states=2 * encoders + 2 * MUSCLES)
    sizes = {"JOINTS": JOINTS, "MUSCLES": MUSCLES, "ENCODERS": encoders}
    compile_device(
        compiler, program, [*SANITIZED, *(f"-D{name}={size}" for name, size in sizes.items())]
    )
    with running(program, tmp_path, key) as uri, UdpLink(uri, key=key, timeout=SOON) as link:
        link.open(asked)
        assert (link.start_state[-MUSCLES:] == F_MIN).all()
        assert (link.start_state[-2 * MUSCLES : -MUSCLES] == 0.3).all()
        samples: list[bytes] = []
        send, line = link._send, link._socket
        assert line is not None
        link._send = lambda data: (samples.append(data), send(data))[1]  # type: ignore[method-assign]
        for _ in range(3):
            pull(link)
        link._send = send  # type: ignore[method-assign]
        others = [(Kind.HELLO, handshake().values()), (Kind.STOP, ()), (Kind.PING, [1.0])]
        for kind, values in others:
            samples.append(pack(Frame(kind, 2, link.run_id, 9, 0.0, 1, 0, values), key))
        answered = 0
        for k, frame in enumerate(bad_frames(samples, FRAMES // 2, seed=4)):
            line.send(frame)
            if k % 20 == 0:
                came = pull(link, within=SOON if key else 0.1)
                if came.state is None or came.device_flags & Flag.SAFE:
                    assert key is None  # a random frame with a valid checksum was a STOP
                    link.open(asked)
                    line = link._socket
                    assert line is not None
                    continue
                answered += 1
                assert (came.state[-4:] >= F_MIN - 1e-9).all()
                assert (came.state[-4:] <= F_MAX + 1e-9).all()
        assert answered > (k // 20 - 5 if key else k // 200)
