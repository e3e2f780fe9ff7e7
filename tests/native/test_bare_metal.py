"""Core and laws on a Cortex-M without a C library: their memory, and their results.

QEMU's user mode runs the same instructions. Without QEMU the programs are only built.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import NamedTuple

import pytest
from support.cases import LONG, with_marks
from support.native.elf import program_names, program_sizes
from support.native.example import write_example
from support.native.precision import STRICT
from support.native.targets import (
    GCC,
    PROGRAMS,
    ROOT,
    SOURCES,
    ZIG,
    build_program,
    find_runner,
    run,
    single_flags,
)
from support.native.vector_file import REPLAY, write_vectors
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.runtime import sources

pytestmark = pytest.mark.cross

FREESTANDING = ROOT / sources.FREESTANDING
FLAGS = ["-std=gnu99", "-ffp-contract=off", "-fno-math-errno", "-ffreestanding", "-fno-builtin"]
FLAGS += ["-Wall", "-Wextra", "-Werror", "-DCARDSFLOW_INSIDE", "-nostdinc"]
FLAGS += ["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections", "-fno-unwind-tables"]
FIRMWARE = ("firmware.c", "example_loop.c")


class Processor(NamedTuple):
    """Processor with its floating point unit, and whether its programs use single precision."""

    cpu: str
    single: bool = False


PROCESSORS = {
    "M4F": Processor("cortex_m4+vfp4d16sp", True),
    "none": Processor("cortex_m7"),
    "double": Processor("cortex_m7+fp_armv8d16"),
    "M7": Processor("cortex_m7+fp_armv8d16sp", True),
}
"""Without a unit the compiler's library is used; two units support single precision only."""

SINGLE_FLAGS = ("-DCARDSFLOW_FLOAT", "-Xclang", "-cl-single-precision-constant")
DOUBLES = {"sqrt", "fmod", "ceil", "round", "fabs"}
"""Functions for doubles; functions for single precision end with an f."""

EMULATOR = "qemu-arm-static"
STACK = 4608
FLASH, FLASH_OF_ALL_PARTS = 81920, 204800  # in bytes
PARTS = '-DCARDSFLOW_PARTS="parts.h"'


def build(program: Path, cpu: str, own: tuple[str, ...], flags: tuple[str, ...]) -> Path:
    """Compile a program for the machine, with this repository and the compiler only."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    files = [PROGRAMS / name for name in ("bare_machine.c", *own)]
    files += [FREESTANDING / "libc.c", *map(Path, SOURCES)]
    compiler = Path(importlib.util.find_spec("ziglang").origin).parent  # type: ignore[union-attr, arg-type]
    headers = [FREESTANDING, ROOT, PROGRAMS, program.parent, compiler / "lib/include"]
    target = ["thumb-freestanding-eabihf", f"-mcpu={cpu}"]
    command = [*ZIG, *target, *FLAGS, *flags, *(f"-I{folder}" for folder in headers)]
    run([*command, *files, "-o", program])
    return program


def emulate(program: Path) -> list[str]:
    """Return the output of the program; skip the test without the emulator."""
    emulator = find_runner(EMULATOR)
    if emulator is None:
        pytest.skip(f"no {EMULATOR}")
    return run([emulator, "-cpu", "max", program]).splitlines()


@pytest.mark.parametrize(
    "processor", ["M4F", *(with_marks(one, LONG) for one in ("none", "double"))]
)
def test_vectors_are_bit_identical(processor: str, tmp_path: Path) -> None:
    """The results equal those of this machine; test_float.py compares both precisions."""
    cpu, single = PROCESSORS[processor]
    vectors = write_vectors(tmp_path / "vectors.bin", single=single)
    own, flags = ("replay_bare.c", "replay_vectors.c"), ("-O2", "-g", f'-DVECTORS="{vectors}"')
    program = build(tmp_path / "replay.elf", cpu, own, (*flags, *SINGLE_FLAGS * single))
    assert not single or not arithmetic_helpers(program)
    own_flags = (*single_flags(GCC), *STRICT) if single else ()  # as other tests compile
    replay = build_program(GCC, tmp_path, REPLAY, *own_flags)
    assert emulate(program) == run([*replay, vectors]).splitlines()


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("example", "processor", "has_all_parts"),
    [
        (example, processor, has_all_parts)
        for has_all_parts in (False, True)
        for example in ("planar_2r", "roboy_left_arm")
        for processor in PROCESSORS
    ],
)
def test_controller_of_an_example_fits(
    example: str, processor: str, has_all_parts: bool, tmp_path: Path
) -> None:
    """Print the sizes in flash and memory, and the stack of a tick."""
    cpu, single = PROCESSORS[processor]
    experiment = Experiment.load(EXAMPLES / example)
    blob = write_example(tmp_path / "example.h", experiment, single=single)
    flags = ("-Os", "-g", *[PARTS] * (not has_all_parts), *SINGLE_FLAGS * single)
    program = build(tmp_path / "firmware.elf", cpu, FIRMWARE, flags)
    assert not single or not arithmetic_helpers(program)
    sizes = program_sizes(program)
    print(f"\n{example}, {processor}, all parts {has_all_parts}: code {sizes.code},", end=" ")
    print(f"constants {sizes.constants} including the robot {blob}, memory {sizes.memory} bytes")
    assert sizes.code + sizes.constants < (FLASH_OF_ALL_PARTS if has_all_parts else FLASH)
    said = {what: int(number) for what, number in map(str.split, emulate(program))}
    print(f"  robot {said['robot']}, law {said['law']}, stack {said['stack']} bytes")
    assert said["stack"] < STACK


@LONG
def test_doubles_are_detected(tmp_path: Path) -> None:
    """Firmware in double precision contains them if the processor does not support doubles."""
    write_example(tmp_path / "example.h", Experiment.load(EXAMPLES / "planar_2r"))
    program = build(
        tmp_path / "firmware.elf", PROCESSORS["M4F"].cpu, FIRMWARE, ("-Os", "-g", PARTS)
    )
    assert {"__aeabi_dmul", "__aeabi_dadd", "sqrt"} <= arithmetic_helpers(program)


def arithmetic_helpers(program: Path) -> set[str]:
    """Return functions that replace the floating point unit, or compute with doubles."""
    names = program_names(program)
    assert "control_loop_tick" in names or "replay_vectors" in names  # not stripped
    helpers = {name for name in names if name.startswith("__aeabi_")}
    return {name for name in helpers if not name.startswith("__aeabi_mem")} | names & DOUBLES
