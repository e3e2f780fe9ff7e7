"""Core and laws on a Cortex-M without a C library: what they need, and what they give.

QEMU's user mode runs the very instructions; where it is missing, the programs are only built.
"""

from __future__ import annotations

import importlib.util
import subprocess
from pathlib import Path

import pytest
from support.native.elf import program_names, program_sizes
from support.native.example import write_example
from support.native.replay import replay_vectors
from support.native.targets import (
    PROGRAMS,
    ROOT,
    SOURCES,
    TARGETS,
    ZIG,
    build_program,
    environment,
    find_runner,
    run_program,
    single_flags,
)
from support.native.vector_file import write_vectors
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.runtime import sources

pytestmark = pytest.mark.cross

FREESTANDING = ROOT / sources.FREESTANDING
FLAGS = ["-std=gnu99", "-ffp-contract=off", "-fno-math-errno", "-ffreestanding", "-fno-builtin"]
FLAGS += ["-Wall", "-Wextra", "-Werror", "-DCARDSFLOW_INSIDE", "-nostdinc"]
FLAGS += ["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections", "-fno-unwind-tables"]
PROCESSORS = {"none": "cortex_m7", "double": "cortex_m7+fp_armv8d16"}
"""By the floating point unit that it has: none that is used, or one for double precision too."""

SINGLE_PROCESSORS = {"M4F": "cortex_m4+vfp4d16sp", "M7": "cortex_m7+fp_armv8d16sp"}
"""Those whose unit knows single precision only."""

SINGLE_FLAGS = ("-DCARDSFLOW_FLOAT", "-Xclang", "-cl-single-precision-constant")
DOUBLES = {"sqrt", "fmod", "ceil", "round", "fabs"}
"""Functions of doubles; those of single precision end with an f."""

EMULATOR = "qemu-arm-static"
STACK, FLASH = 4096, 131072  # in bytes; every tension law is in, whether the robot has it or not


def build(program: Path, processor: str, *own: str, flags: tuple[str, ...] = ()) -> Path:
    """Compile a program for the machine; nothing but this repository and the compiler is used."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    files = [PROGRAMS / name for name in ("bare_machine.c", *own)]
    files += [FREESTANDING / "libc.c", *map(Path, SOURCES)]
    compiler = Path(importlib.util.find_spec("ziglang").origin).parent  # type: ignore[union-attr, arg-type]
    headers = [FREESTANDING, ROOT, PROGRAMS, program.parent, compiler / "lib/include"]
    cpu = (PROCESSORS | SINGLE_PROCESSORS)[processor]
    target = ["thumb-freestanding-eabihf", f"-mcpu={cpu}"]
    command = [*ZIG, *target, *FLAGS, *flags, *(f"-I{folder}" for folder in headers)]
    done = subprocess.run(
        [*command, *map(str, files), "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
        env=environment(),
    )
    assert done.returncode == 0, done.stderr
    return program


def run(program: Path) -> list[str]:
    """What the program says; skips without the emulator."""
    emulator = find_runner(EMULATOR)
    if emulator is None:
        pytest.skip(f"no {EMULATOR}")
    done = subprocess.run(
        [emulator, "-cpu", "max", str(program)],
        capture_output=True,
        text=True,
        check=False,
        env=environment(),
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines() or done.stderr.splitlines()


@pytest.mark.parametrize("processor", PROCESSORS)
def test_the_vectors_give_the_same_bits(processor: str, tmp_path: Path) -> None:
    """Without a unit for double precision too: then the compiler's library computes."""
    vectors = write_vectors(tmp_path / "vectors.bin")
    program = build(
        tmp_path / "replay.elf",
        processor,
        "replay_bare.c",
        "replay_vectors.c",
        flags=("-O2", f'-DVECTORS="{vectors}"'),
    )
    assert run(program) == replay_vectors(vectors)[0]


@pytest.mark.parametrize("example", ["planar_2r", "roboy_left_arm"])
def test_the_controller_of_an_example_fits(example: str, tmp_path: Path) -> None:
    """Sizes for flash and memory, and the stack that a tick takes."""
    blob = write_example(tmp_path / "example.h", Experiment.load(EXAMPLES / example))
    program = build(
        tmp_path / "firmware.elf", "double", "firmware.c", "example_loop.c", flags=("-Os",)
    )
    sizes = program_sizes(program)
    print(f"\n{example}: code {sizes.code}, constants {sizes.constants} of which robot {blob},")
    print(f"  static memory {sizes.memory} bytes")
    assert sizes.code + sizes.constants < FLASH
    said = {what: int(number) for what, number in (line.split() for line in run(program))}
    print(f"  robot {said['robot']}, law {said['law']}, stack {said['stack']} bytes")
    assert said["stack"] < STACK


@pytest.fixture(scope="module")
def single_vectors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_vectors(tmp_path_factory.mktemp("vectors") / "vectors.bin", single=True)


@pytest.fixture(scope="module")
def replayed_here(single_vectors: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """On this machine."""
    here, folder = TARGETS["gcc -O2"], tmp_path_factory.mktemp("replay")
    sources = ("replay_hosted.c", "replay_vectors.c")
    program = build_program(here, folder, sources, *single_flags(here))
    return run_program(program, single_vectors).splitlines()


@pytest.mark.parametrize("processor", SINGLE_PROCESSORS)
def test_single_precision_gives_the_same_bits(
    processor: str, single_vectors: Path, replayed_here: list[str], tmp_path: Path
) -> None:
    """As on this machine; test_float.py says how far they are from those of double precision."""
    flags = ("-O2", "-g", f'-DVECTORS="{single_vectors}"', *SINGLE_FLAGS)
    own = ("replay_bare.c", "replay_vectors.c")
    program = build(tmp_path / "replay.elf", processor, *own, flags=flags)
    assert not arithmetic_helpers(program)
    assert run(program) == replayed_here


@pytest.mark.parametrize(("example", "processor"), [("planar_2r", "M7"), ("roboy_left_arm", "M4F")])
def test_the_controller_in_single_precision_fits(
    example: str, processor: str, tmp_path: Path
) -> None:
    """The floating point unit computes everything in it."""
    blob = write_example(tmp_path / "example.h", Experiment.load(EXAMPLES / example), single=True)
    own, flags = ("firmware.c", "example_loop.c"), ("-Os", "-g", *SINGLE_FLAGS)
    program = build(tmp_path / "firmware.elf", processor, *own, flags=flags)
    assert not arithmetic_helpers(program)
    sizes = program_sizes(program)
    print(f"\n{example}, {processor}, single precision: code {sizes.code},", end=" ")
    print(f"constants {sizes.constants} of which robot {blob}")
    assert sizes.code + sizes.constants < FLASH
    said = {what: int(number) for what, number in (line.split() for line in run(program))}
    print(f"  robot {said['robot']}, law {said['law']}, stack {said['stack']} bytes")
    assert said["stack"] < STACK


def test_the_check_sees_doubles(tmp_path: Path) -> None:
    """A firmware of double precision on a processor without is full of them."""
    write_example(tmp_path / "example.h", Experiment.load(EXAMPLES / "planar_2r"))
    own, flags = ("firmware.c", "example_loop.c"), ("-Os", "-g")
    program = build(tmp_path / "firmware.elf", "M4F", *own, flags=flags)
    assert {"__aeabi_dmul", "__aeabi_dadd", "sqrt"} <= arithmetic_helpers(program)


def arithmetic_helpers(program: Path) -> set[str]:
    """Functions that compute in the place of the floating point unit, or with doubles."""
    names = program_names(program)
    assert "control_loop_tick" in names or "replay_vectors" in names  # not stripped
    helpers = {name for name in names if name.startswith("__aeabi_")}
    return {name for name in helpers if not name.startswith("__aeabi_mem")} | names & DOUBLES
