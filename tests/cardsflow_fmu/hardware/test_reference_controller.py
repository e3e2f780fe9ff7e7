"""Example controller in C with a device: its runs equal runs with the experiment's controller."""

from __future__ import annotations

import importlib.util
import math
import re
import shutil
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.hardware.hardware_fuzz import bad_frames, with_checksum
from support.native.targets import DERIVATIVES, FLAGS, SOURCES, TRANSITION, Target
from support.native.targets import compiled as compiled_objects
from support.process_output import wait_until
from support.robots.bent_cables import with_bent_cables
from support.robots.robots import EXAMPLES, HELD, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.device.server import DeviceServer
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.protocol.frame import MAX_BYTES, Frame, Kind, pack, unpack
from cardsflow_fmu.hardware.protocol.signals import hardware_signature
from cardsflow_fmu.simulation.run import simulate

ROOT = EXAMPLES.parent
FOLDER = EXAMPLES / "hardware_in_the_loop"
ARM = EXAMPLES / "roboy_left_arm"
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-Wshadow", "-Wconversion"]
NEEDED = [*SOURCES, DERIVATIVES, TRANSITION]
SANITIZED = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
COMMON = ["-O1", "-ffp-contract=off", "-DCARDSFLOW_INSIDE"]
SINGLE = ["-DCARDSFLOW_FLOAT", "-fsingle-precision-constant"]
SHORT = {"run.duration": 0.1}
SOFT_LYAPUNOV = {
    "controller.type": "lyapunov",
    "controller.kp": 20.0,
    "controller.kd": 2.0,
    "controller.norm": 1,
}
KEY = b"a pre-shared key of some length"
TIMEOUT = 300

pytestmark = pytest.mark.slow  # compiles the core and the muscle laws again

_spec = importlib.util.spec_from_file_location("make_controller", FOLDER / "make_controller.py")
assert _spec is not None
assert _spec.loader is not None
make_controller = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(make_controller)


@pytest.fixture(scope="session")
def libraries(compiler: str) -> list[str]:
    """Compile the object files of the core and the muscle laws."""
    return compiled_objects(Target([compiler, "-O1", "-fPIC"]), [*FLAGS, f"-I{ROOT}"], NEEDED)


def compiled(
    compiler: str, libraries: list[str], experiment: Experiment, folder: Path, *more: str
) -> Path:
    """Compile the controller of an experiment and write its reference to the same folder."""
    make_controller.write_controller(experiment, folder)
    program = folder / "controller"
    command = [compiler, *STRICT, *COMMON, *more, f"-I{folder}", str(FOLDER / "controller.c")]
    done = subprocess.run(
        [*command, *libraries, "-o", str(program), "-lm"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return program


def compiled_in_single_precision(experiment: Experiment, folder: Path) -> Path:
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    make_controller.write_controller(experiment, folder, single=True)
    program = folder / "controller"
    command = ["gcc", *STRICT, *COMMON, "-O0", *SINGLE, f"-I{folder}"]
    command += [
        str(FOLDER / "controller.c"),
        '-DCARDSFLOW_PARTS="parts.h"',
        "-Wno-conversion",
        "-Wno-shadow",
        *NEEDED,
        "-o",
        str(program),
        "-lm",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program


@pytest.fixture(scope="session")
def planar(compiler: str, libraries: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile the controller of the two-link arm with a longer timeout."""
    made = Experiment.load(PLANAR_2R, SHORT)
    patient = "-DMAX_MISSED=1000000"  # for machines that are busy with other tests
    return compiled(compiler, libraries, made, tmp_path_factory.mktemp("planar"), patient)


class NoisyLine:
    """Line with invalid frames, not signed with the run key, before every answer of a device."""

    next_due = math.inf

    def __init__(self, device: Device) -> None:
        self._device, self._sent, self._seed = device, list[tuple[bytes, Hashable]](), 0

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        for answer in self._device.receive(data, peer, now):
            self._seed += 1
            self._sent += [(frame, peer) for frame in bad_frames([answer], 8, self._seed)]
            self._sent.append((answer, peer))

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        due, self._sent = self._sent, []
        return due


class BlindLine:
    """Line to a device without joint encoders whose lengths stay constant from a time on."""

    next_due = math.inf

    def __init__(self, device: Device, stuck: float = math.inf) -> None:
        self._device, self._stuck, self._sent = device, stuck, list[tuple[bytes, Hashable]]()
        self._lengths: np.ndarray | None = None

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        self._sent += [(self._blind(a), peer) for a in self._device.receive(data, peer, now)]

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        due, self._sent = self._sent, []
        return due

    def _blind(self, answer: bytes) -> bytes:
        frame = unpack(answer)
        if frame.kind not in (Kind.HELLO_ACK, Kind.STATE):
            return answer
        values = frame.values.copy()
        state = values[-(2 * 4 + 2 * 11) :]
        state[:8] = 0.0
        if self._lengths is None or frame.t_sim < self._stuck:
            self._lengths = state[8:19].copy()
        state[8:19] = self._lengths
        return with_checksum(answer[:48] + values.astype("<f8").tobytes())


@contextmanager
def served(
    experiment: Experiment,
    key: bytes | None = None,
    way: Callable[[Device], Any] = lambda device: None,
) -> Iterator[tuple[Device, str]]:
    """Serve the experiment's robot in a thread of this process."""
    device, over = emulated_device(experiment, experiment.hardware, key), threading.Event()
    with DeviceServer(device, "udp://127.0.0.1:0", line=way(device)) as server:
        thread = threading.Thread(target=server.run, args=(over.is_set,))
        thread.start()
        try:
            yield device, server.uri.rsplit(":", 1)[1]
        finally:
            over.set()
            thread.join()


def driven(program: Path, port: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the controller to the end."""
    with (program.parent / "reference.f64").open("rb") as reference:
        return subprocess.run(
            [str(program), "127.0.0.1", port, *words],
            stdin=reference,
            capture_output=True,
            text=True,
            check=False,
            timeout=TIMEOUT,
        )


def rows(text: str) -> np.ndarray:
    """Return time, q and f, one row per tick."""
    return np.array([[float(word) for word in line.split(",")] for line in text.splitlines()])


def test_the_source_is_short() -> None:
    assert len((FOLDER / "controller.c").read_text().splitlines()) < 300


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("folder", "settings"),
    [(ARM, SHORT | {"run.step": 0.005, "run.duration": 0.25}), (PLANAR_2R, SHORT)],
)
def test_a_controller_in_single_precision_differs_little(
    folder: Path, settings: dict[str, Any], tmp_path: Path
) -> None:
    """The tolerances are 1e-6 rad and 1e-4 of the maximum force."""
    made = Experiment.load(folder, settings)
    program = compiled_in_single_precision(made, tmp_path)
    with served(made) as (_, port):
        done = driven(program, port, "lockstep")
        assert (done.returncode, done.stderr) == (0, "")
    expected, found = simulate(made, coupling="direct"), rows(done.stdout)
    n, ticks = len(made.robot.coordinates), made.run.steps
    q = np.array([expected[f"q.{c.name}"] for c in made.robot.coordinates])[:, :ticks]
    f = np.array([expected[f"f.{muscle.name}"] for muscle in made.robot.muscles])[:, :ticks]
    np.testing.assert_allclose(found[:, 1 : 1 + n].T, q, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[:, 1 + n :].T, f, rtol=0, atol=1e-4 * f.max())


@pytest.mark.cases(3)
@pytest.mark.parametrize("with_key", [False, True])
@pytest.mark.parametrize(
    ("folder", "settings"),
    [
        (PLANAR_2R, SHORT),
        (PLANAR_2R, SHORT | {"controller.ki": 500.0, "controller.delay": 1}),
        (PLANAR_2R, SHORT | SOFT_LYAPUNOV),
        (ARM, SHORT | {"run.step": 0.005, "run.duration": 0.25}),
        (ARM, SHORT | {"run.step": 0.005, "controller.priorities": [2, 1, 1]}),
    ],
)
def test_in_lockstep_it_agrees_with_the_controller_of_the_experiment(
    folder: Path,
    settings: dict[str, Any],
    with_key: bool,
    compiler: str,
    libraries: list[str],
    tmp_path: Path,
) -> None:
    """The tolerances are 1e-9 rad and 1e-6 of the maximum force, due to rounding errors."""
    made = Experiment.load(folder, settings)
    program = compiled(compiler, libraries, made, tmp_path)
    (tmp_path / "key.bin").write_bytes(KEY)
    words = ["lockstep", str(tmp_path / "key.bin")] if with_key else ["lockstep"]
    with served(made, KEY if with_key else None) as (device, port):
        done = driven(program, port, *words)
        assert (done.returncode, done.stderr) == (0, "")
        assert device.state == "safe"
        assert device.counters["stops"] > 0
    expected, found = simulate(made, coupling="direct"), rows(done.stdout)
    q = [expected[f"q.{c.name}"] for c in made.robot.coordinates]
    f = [expected[f"f.{muscle.name}"] for muscle in made.robot.muscles]
    n, ticks = len(q), made.run.steps
    assert len(found) == ticks
    np.testing.assert_allclose(found[:, 1 : 1 + n].T, np.array(q)[:, :ticks], rtol=0, atol=1e-9)
    forces = np.array(f)[:, :ticks]
    np.testing.assert_allclose(found[:, 1 + n :].T, forces, rtol=0, atol=1e-6 * forces.max())


@pytest.mark.cases(1)
@pytest.mark.parametrize("single", [True, False])
def test_without_joint_encoders_the_pose_is_estimated(
    single: bool, compiler: str, libraries: list[str], tmp_path: Path
) -> None:
    """The motion is close to a run with the true pose; constant sensors end a run with a ramp."""
    settings: dict[str, Any] = {"run.step": 0.005, "run.duration": 1.0}
    own = {"estimator.exact_transition": False, "plant.mass_scale": 1.0}
    own["estimator.offset_drift"] = 1e-6 * single
    made = Experiment.load(EXAMPLES / "no_joint_encoders", settings | own)
    if single:
        program = compiled_in_single_precision(made, tmp_path)
    else:
        program = compiled(compiler, libraries, made, tmp_path)
    with served(made, way=BlindLine) as (_, port):
        done = driven(program, port, "lockstep")
        assert (done.returncode, done.stderr) == (0, "")
    true = simulate(Experiment.load(ARM, settings), coupling="direct")
    found = rows(done.stdout)
    names = [c.name for c in made.robot.coordinates]
    q = np.array([true[f"q.{name}"] for name in names])[:, : len(found)]
    assert len(found) == made.run.steps
    assert np.abs(found[:, 1:5].T - q).max() < 5e-3
    with served(made, way=partial(BlindLine, stuck=0.5)) as (device, port):
        done = driven(program, port, "lockstep")
        assert (done.returncode, done.stderr) == (1, "controller: the estimate is lost\n")
        assert device.state == "safe"


def test_invalid_answers_have_no_effect_under_the_sanitizers(
    compiler: str, libraries: list[str], tmp_path: Path
) -> None:
    """Eight random or mutated frames before each answer do not change a signed run."""
    made = Experiment.load(PLANAR_2R, SHORT)
    program = compiled(compiler, libraries, made, tmp_path, *SANITIZED)
    (tmp_path / "key.bin").write_bytes(KEY)
    outputs = []
    for way in (lambda device: None, NoisyLine):
        with served(made, KEY, way) as (device, port):
            done = driven(program, port, "lockstep", str(tmp_path / "key.bin"))
            assert (done.returncode, done.stderr) == (0, "")
            assert device.state == "safe"
        outputs.append(done.stdout)
    assert outputs[0] == outputs[1]


@pytest.mark.parametrize(
    ("halves", "words"),
    [
        ((1e300, 1.0), "the device rejects the run"),
        ((1.0, -1.0), "the device rejects the run"),
        ((0.5, 1.0), "the device rejects the run"),
        ((4294967296.0, 1.0), "the device rejects the run"),
        ((math.nan, 1.0), "no answer, or the device is in use"),
        ((1.0, math.inf), "no answer, or the device is in use"),
    ],
)
def test_a_nonce_that_is_not_an_integer_of_64_bits_is_rejected(
    planar: Path, halves: tuple[float, float], words: str
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))

        def answer() -> None:
            while True:
                data, peer = line.recvfrom(MAX_BYTES)
                if not data:
                    return
                hello = unpack(data)
                values = np.array([*hello.values, *halves, *np.zeros(int(hello.values[6]))])
                empty = np.zeros(len(values))
                head = pack(Frame(Kind.HELLO_ACK, 0, hello.run_id, 0, 0.0, 1, 0, empty))[:48]
                line.sendto(with_checksum(head + values.tobytes()), peer)

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            done = driven(planar, str(line.getsockname()[1]), "lockstep")
        finally:
            line.sendto(b"", line.getsockname())
            thread.join()
    assert done.returncode == 1
    assert words in done.stderr


def test_forces_that_are_not_finite_are_not_sent(planar: Path) -> None:
    """A gap in the reference causes such forces."""
    made = Experiment.load(PLANAR_2R, SHORT)
    reference = np.fromfile(planar.parent / "reference.f64").reshape(-1, 6)
    reference[5, 0] = math.nan
    with served(made) as (device, port):
        done = subprocess.run(
            [str(planar), "127.0.0.1", port, "lockstep"],
            input=reference.tobytes(),
            capture_output=True,
            check=False,
            timeout=TIMEOUT,
        )
        assert device.counters["not finite"] == 0
        assert device.counters["received"] > 6
    assert done.returncode == 1
    assert b"no forces found" in done.stderr


def test_in_real_time_it_tracks_and_stops(planar: Path) -> None:
    """A busy machine delays set points, and the robot drifts; one of several runs must track."""
    made = Experiment.load(PLANAR_2R, SHORT | HELD | {"hardware.watchdog": 10.0})
    expected = simulate(made, coupling="direct")
    joints = np.array([expected["q.joint_1"], expected["q.joint_2"]])[:, :100].T
    for _ in range(20):
        with served(made) as (device, port):
            done = driven(planar, port, "realtime")
            assert (done.returncode, done.stderr) == (0, "")
            assert device.state == "safe"
            assert device.counters["stops"] > 0
        follows = np.abs(rows(done.stdout)[:, 1:3] - joints).max() <= 0.01
        if follows and device.counters["setpoints"] > 300:  # the run and most of the ramp down
            return
    pytest.fail("no run tracked its reference")


def test_a_signal_ends_the_run_in_the_safe_state(planar: Path) -> None:
    made = Experiment.load(PLANAR_2R, HELD | {"hardware.watchdog": 10.0})
    with served(made) as (device, port):
        command = [str(planar), "127.0.0.1", port, "realtime"]
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        ) as process:
            process.stdin.write((planar.parent / "reference.f64").read_bytes())
            process.stdin.flush()
            assert wait_until(lambda: device.counters["setpoints"] > 20)
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=TIMEOUT)
        assert (process.returncode, error) == (1, b"controller: interrupted\n")
        assert device.state == "safe"
        assert device.counters["stops"] > 0


def test_a_robot_far_from_its_start_pose_does_not_move(planar: Path) -> None:
    made = Experiment.load(PLANAR_2R, {"start.q": [0.0, 0.0]})
    with served(made) as (device, port):
        done = driven(planar, port, "realtime")
        assert (done.returncode, done.stderr) == (
            1,
            "controller: the robot is too far from its start\n",
        )
        assert device.counters["setpoints"] == 0
        assert device.state == "safe"


def test_errors_are_reported_as_messages(planar: Path, tmp_path: Path) -> None:
    (tmp_path / "key.bin").write_bytes(b"short")
    assert driven(planar, "9", "lockstep", str(tmp_path / "key.bin")).returncode == 2
    assert driven(planar, "9").returncode == 2
    done = driven(planar, "9", "lockstep")
    assert (done.returncode, done.stdout) == (1, "")
    assert "no answer, or the device is in use" in done.stderr
    with served(Experiment.load(ARM)) as (device, port):
        done = driven(planar, port, "lockstep")
        assert (done.returncode, device.state) == (1, "idle")
        assert "the device rejects the run" in done.stderr


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"run.step": 0.001, "controller.period": 0.005}, "set run.step to controller.period"),
        ({"hardware.has_positions": False}, "expects positions and velocities"),
        ({"hardware.has_tensions": False}, "expects lengths and tensions"),
        ({"hardware.scale": 2.0}, "in SI units"),
        ({"controller.type": "mpc"}, "has no predictive control"),
    ],
)
def test_unsupported_settings_are_rejected(
    settings: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        make_controller.write_controller(Experiment.load(PLANAR_2R, settings), tmp_path)


def test_unsupported_robots_are_rejected(tmp_path: Path) -> None:
    """Closed loops and cable friction are not supported."""
    settings = {"run.step": 0.005, "controller.period": 0.005}
    arm = Experiment.load(ARM, settings)
    rough = replace(arm, robot=with_bent_cables(arm.robot, 0.1, arm.start.q))
    for made, message in (
        (Experiment.load(EXAMPLES / "bicycle", settings), "does not support closed loops"),
        (rough, "does not support cable friction"),
    ):
        with pytest.raises(InputError, match=message):
            make_controller.write_controller(made, tmp_path)
    assert not list(tmp_path.iterdir())


def test_controller_and_device_in_c_run_in_lockstep(
    compiler: str, planar: Path, tmp_path: Path
) -> None:
    """The commands of the README: the device begins at the start pose of the experiment."""
    experiment = Experiment.load(PLANAR_2R, SHORT)
    start = ",".join(map(repr, experiment.start.q))
    device = tmp_path / "device"
    source = str(FOLDER / "device.c")
    for flags in ([], [f"-DSTART={start}"]):
        subprocess.run([compiler, *STRICT, *flags, source, "-o", device, "-lm"], check=True)
        signature = f"{hardware_signature(experiment.robot, experiment.hardware):016x}"
        command = [device, "127.0.0.1", "0", signature]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as served:
            try:
                port = served.stdout.readline().rpartition(":")[2].strip()
                done = driven(planar, port, "lockstep")
            finally:
                served.terminate()
        if flags:
            assert (done.returncode, done.stderr) == (0, "")
            assert len(done.stdout.splitlines()) == experiment.run.steps
        else:
            assert "too far from its start" in done.stderr
