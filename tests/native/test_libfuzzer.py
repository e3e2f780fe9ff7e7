"""libFuzzer with sanitizers on external inputs of the C code: files, saved states, frames.

CARDSFLOW_FUZZ_SECONDS is the time per target, CARDSFLOW_FUZZ_FOLDER the folder for findings.

    CARDSFLOW_FUZZ_SECONDS=600 nice python -m pytest -n 5 -s -m fuzz tests/native/test_libfuzzer.py
"""

from __future__ import annotations

import importlib.util
import os
import random
import resource
import shutil
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path

import fmpy
import pytest
from support.native.targets import DERIVATIVES, ROOT, TRANSITION, Target, build_program, environment
from support.robots.bent_cables import elastic_bent_cables
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r
from support.robots.wrapped import over_ellipsoids

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.runtime.sources import NATIVE
from cardsflow_fmu.runtime.sources import RUNTIME as RUNTIME_FOLDER
from cardsflow_fmu.simulation.build import build
from sim_dart import compile_blob

pytestmark = pytest.mark.fuzz

SECONDS = int(os.environ.get("CARDSFLOW_FUZZ_SECONDS", "1"))
SANITIZERS = "fuzzer,address,undefined,float-cast-overflow"
FUZZED = Target(["clang", "-O0", "-g", f"-fsanitize={SANITIZERS}", "-fno-sanitize-recover=all"])
LOOP = ROOT / "examples/hardware_in_the_loop"
FOLDERS = 8
"""Native FMUs among which `fuzz_native` selects."""


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """Return a folder for inputs, in memory if possible."""
    if shutil.which("clang") is None:
        pytest.skip("no clang")
    (tmp_path / "corpus").mkdir()
    (tmp_path / "scratch").mkdir()
    yield tmp_path
    kept = os.environ.get("CARDSFLOW_FUZZ_FOLDER")
    for found in tmp_path.glob("found-*"):
        if kept:
            shutil.copy(found, Path(kept) / f"{tmp_path.name}-{found.name}")


def fuzz(program: list[str], folder: Path, **variables: object) -> None:
    """Fuzz for a time; a finding fails the test."""
    own = (
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    )  # the peak of a child includes the memory of its parent
    limits = [f"-rss_limit_mb={own + 1000}", "-timeout=1200", "-max_len=65536"]
    options = [f"-max_total_time={SECONDS}", *limits]
    done = subprocess.run(
        [*program, *options, f"-artifact_prefix={folder}/found-", "-print_final_stats=1", "corpus"],
        cwd=folder,
        env=environment()
        | {name: str(value) for name, value in variables.items()}
        | {"ASAN_OPTIONS": "detect_leaks=1:allocator_may_return_null=1"},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    stats = [line for line in done.stderr.splitlines() if line.startswith("stat::number_of_exec")]
    print(f"\n{Path(program[0]).name}: {stats}")
    assert done.returncode == 0, done.stderr[-6000:]
    assert stats, done.stderr[-6000:]


def native_resources(folder: Path) -> list[Path]:
    """Return numbered resource folders of native FMUs of several robots."""
    found = []
    for example in ("planar_2r", "roboy_left_arm", "pneumatic_elbow", "hill_arm"):
        settings = {"controller.ki": 500.0, "controller.delay": 1}
        experiment = Experiment.load(EXAMPLES / example, settings)
        for name, file in build(experiment, folder / f"fmus_{example}", compute="c").items():
            if len(found) < FOLDERS and name != "reference":
                target = folder / "native" / str(len(found))
                fmpy.extract(str(file), str(folder / f"{example}_{name}"))
                shutil.copytree(folder / f"{example}_{name}" / "resources", target)
                found.append(target)
    return found


def runtime_sources(without: str = "none") -> list[str]:
    names = [name for name in NATIVE.sources() if name.startswith(RUNTIME_FOLDER)]
    files = [str(ROOT / name) for name in names if not name.endswith(without)]
    return ["-D_GNU_SOURCE", *files, DERIVATIVES, TRANSITION, "-ldl", "-lpthread"]


def test_robot_blobs(folder: Path) -> None:
    robots = [
        planar_2r(),
        every_joint(),
        over_ellipsoids(),
        elastic_bent_cables(random_robot(4)),
        *(random_robot(seed) for seed in range(3)),
    ]
    robots += [read_robot(EXAMPLES / name / "robot") for name in ("pneumatic_elbow", "hill_arm")]
    for k, robot in enumerate(robots):
        (folder / "corpus" / f"{k}.bin").write_bytes(compile_blob(robot))
    sources = ("fuzz_blobs.c", "mutate.c")
    program = build_program(FUZZED, folder, sources, "-DCARDSFLOW_LIBFUZZER", DERIVATIVES)
    fuzz(program, folder)


def test_native_models(folder: Path) -> None:
    for k, resources in enumerate(native_resources(folder)):
        data = (resources / "native.bin").read_bytes()
        (folder / "corpus" / f"{k}.bin").write_bytes(bytes([k]) + data)
    sources, flags = ("fuzz_native.c", "mutate.c"), ("-DCARDSFLOW_LIBFUZZER", *runtime_sources())
    program = build_program(FUZZED, folder, sources, *flags)
    fuzz(program, folder, FUZZ_RESOURCES=folder / "native", FUZZ_SCRATCH=folder / "scratch")


@pytest.mark.parametrize("number", [0, 1, 4], ids=["plant", "controller", "plant with states"])
def test_saved_states(folder: Path, number: int) -> None:
    resources = native_resources(folder)[number]
    flags = [f"-I{ROOT / RUNTIME_FOLDER}/fmi", *runtime_sources(without="fmi2.c")]
    program = build_program(FUZZED, folder, ("fuzz_fmu.c",), *flags)
    variables = environment() | {"FUZZ_RESOURCES": str(resources), "FUZZ_SEED": "corpus/seed"}
    subprocess.run(program, cwd=folder, env=variables, check=True)
    fuzz(program, folder, FUZZ_RESOURCES=resources)


def test_tables_of_ports(folder: Path) -> None:
    for k, resources in enumerate(native_resources(folder)):
        shutil.copy(resources / "ports.bin", folder / "corpus" / str(k))
    runtime = ROOT / RUNTIME_FOLDER
    files = [runtime / "model/port_table.c", *sorted((runtime / "platform").glob("*.c"))]
    flags = ["-DFUZZ_PORTS", "-D_GNU_SOURCE", *map(str, files)]
    program = build_program(FUZZED, folder, ("fuzz_fmu.c",), *flags, libraries=[])
    fuzz(program, folder, FUZZ_SCRATCH=folder / "scratch")


HEADER = struct.Struct("<IBBHIIdQQHHI")
HELLO, HELLO_ACK, SETPOINT, STOP, PING = 1, 2, 3, 5, 8


def frame(kind: int, values: list[float], flags: int = 0, seq: int = 1) -> bytes:
    """Return a frame after its length; the program corrects the checksum."""
    head = HEADER.pack(0, 1, kind, flags, 7, seq, 0.0, 1, 1, len(values), 0, 0)
    data = head + struct.pack(f"<{len(values)}d", *values)
    return struct.pack("<H", len(data)) + data


def seeds(folder: Path, hello: list[float], ack: list[float], commands: int) -> None:
    """Return runs of a device, signed and unsigned, in lockstep and in real time."""
    for key in (0, 1):
        for flags in (0, 2):
            frames = [frame(HELLO, hello, flags), frame(HELLO_ACK, ack, flags)]
            frames += [frame(SETPOINT, [20.0] * commands, flags, seq) for seq in (1, 2, 2, 3)]
            frames += [frame(PING, []), frame(STOP, [])]
            (folder / "corpus" / f"{key}{flags}").write_bytes(bytes([key]) + b"".join(frames))


def test_frames_of_the_device(folder: Path) -> None:
    seeds(folder, [1.0, 2.0, 1e-3, 1.0, 0.02, 4.0, 12.0], [0.0] * 21, 4)
    flags = [f'-DFUZZ_PROGRAM="{LOOP}/device.c"', "-DFUZZ_DEVICE", "-Wno-unused-function"]
    fuzz(build_program(FUZZED, folder, ("fuzz_frames.c",), *flags, libraries=[]), folder)


def test_frames_of_the_controller(folder: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_controller", LOOP / "make_controller.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.write_controller(Experiment.load(EXAMPLES / "planar_2r", {}), folder / "robot")
    rng = random.Random(1)
    ack = [1.0, 2.0, 1e-3, 1.0, 0.02, 4.0, 12.0, 4e9, 5.0, *(rng.random() for _ in range(12))]
    seeds(folder, ack[:7], ack, 4)
    flags = [f'-DFUZZ_PROGRAM="{LOOP}/controller.c"', f"-I{folder}/robot", "-Wno-unused-function"]
    fuzz(build_program(FUZZED, folder, ("fuzz_frames.c",), *flags), folder)
