"""Native FMUs in a host in C, on several platforms and compilers, are bit-identical."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zlib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import fmpy
import pytest
from support.native.targets import PROGRAMS, TARGETS, Target, require, run
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.fmu.platforms import libraries_for
from cardsflow_fmu.simulation.build import build

STEPS = 200
EMULATED = {
    "zig linux64": "x86_64-linux",
    "zig linux-aarch64, qemu": "aarch64-linux",
    "zig win64, wine": "x86_64-windows",
}
MODELS = [
    ("roboy_left_arm", "plant"),
    ("roboy_left_arm", "controller"),
    ("roboy_left_arm", "reference"),
    ("hill_arm", "plant"),
    ("hill_arm", "controller"),
]
MAX_PACKED, MAX_UNPACKED = 400_000, 650_000
"""Maximum size of a library in an FMU, and next to it, in bytes."""


class Unpacked(NamedTuple):
    """Native FMU of FMI 2.0, and its library for this platform."""

    folder: Path
    library: Path


@pytest.fixture(scope="module", params=MODELS, ids="-".join)
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    example, model = request.param
    return unpacked(example, model, tmp_path_factory.mktemp(f"{example}_{model}"))


def unpacked(example: str, model: str, folder: Path, fmi: FmiVersion = "2.0") -> Unpacked:
    experiment = Experiment.load(EXAMPLES / example)
    file = build(experiment, folder / "out", compute="c", fmi=fmi)[model]
    fmpy.extract(str(file), str(folder / "fmu"))
    platform = "linux64" if fmi == "2.0" else "x86_64-linux"
    return Unpacked(folder / "fmu", folder / f"fmu/binaries/{platform}/{model}.so")


@cache
def host(name: str, folder: Path) -> list[str]:
    """Return the compiled host for a target, and the command that runs it."""
    target = TARGETS[name]
    runner = require(target)
    program = folder / f"host{target.suffix}"
    source = PROGRAMS / "fmu_trajectory.c"
    headers = Path(fmpy.__file__).parent / "c-code"
    libraries = [] if target.suffix == ".exe" else ["-ldl"]
    # its inputs must be equal as well; and ziglang has compiled the C library of small programs
    flags = ["-ffp-contract=off", "-Os", f"-I{headers}"]
    command = [*target.compiler, *flags, str(source), "-o", str(program), *libraries]
    run(command)
    return [*runner, str(program)]


def trajectory(command: list[str], library: Path, fmu: Unpacked, *, drive: str = "") -> str:
    """Return the output of the host."""
    description = fmpy.read_model_description(str(fmu.folder))
    references = {
        causality: [
            v.valueReference
            for v in description.modelVariables
            if v.causality == causality and v.type == "Real" and v.name != "solve_time"
        ]
        for causality in ("input", "output")
    }
    step = round(1e3 * float(description.defaultExperiment.stepSize))
    numbers = [STEPS, step, len(references["input"])]
    numbers += references["input"] + references["output"]
    resources = f"file:///{drive}{fmu.folder / 'resources'}".replace(":////", ":///")
    arguments = [library, description.guid, resources, *map(str, numbers)]
    return run([*command, *arguments], Path("/"))


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("hosts")


@pytest.mark.cross
@pytest.mark.parametrize("name", EMULATED)
def test_results_are_bit_identical_on_every_platform(
    name: str, fmu: Unpacked, programs: Path, tmp_path: Path
) -> None:
    require(TARGETS[name])
    own = trajectory(host("gcc -O2", programs), fmu.library, fmu)
    folder = programs / name.replace(" ", "_")
    folder.mkdir(exist_ok=True)
    try:
        (library,) = libraries_for([EMULATED[name]], tmp_path, native=True).values()
    except CardsflowError as error:
        pytest.skip(str(error))
    if name == "zig linux64":
        library = zig_library(tmp_path)
    drive = "Z:/" if TARGETS[name].suffix == ".exe" else ""
    other = trajectory(host(name, folder), library, fmu, drive=drive)
    assert len(set(own.split())) > 20
    assert own.splitlines() == other.splitlines()


def zig_library(folder: Path) -> Path:
    """Return the prebuilt library of this platform, which the installed library replaces."""
    from cardsflow_fmu.fmu.platforms import compile_for
    from cardsflow_fmu.runtime.library import prebuilt_libraries

    there = prebuilt_libraries().get("x86_64-linux")
    return there or compile_for("x86_64-linux", folder, native=True)


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(("version", "example"), [("2.0", "hill_arm"), ("3.0", "roboy_left_arm")])
def test_sources_can_be_compiled(
    version: FmiVersion, example: str, programs: Path, tmp_path: Path
) -> None:
    """Compile with the files of the FMU only, as its build description specifies."""
    require(Target(["gcc"]))
    fmu = unpacked(example, "plant", tmp_path, version)
    sources = fmu.folder / "sources"
    own = tmp_path / "own.so"
    if version == "2.0":
        root = ET.parse(fmu.folder / "modelDescription.xml").getroot()
        files = [file.attrib["name"] for file in root.iterfind("CoSimulation/SourceFiles/File")]
        options = ["-std=c99", "-O1"]
    else:
        root = ET.parse(sources / "buildDescription.xml").getroot()
        (kit,) = root.iterfind("BuildConfiguration/SourceFileSet")
        files = [file.attrib["name"] for file in kit.iterfind("SourceFile")]
        options = kit.attrib["compilerOptions"].split()
        assert kit.attrib["compiler"] == "gcc"
    quick = "-O0"  # to compile; this does not change the results
    run(["gcc", *options, quick, "-fPIC", "-shared", *files, "-o", own, "-lm"], sources)
    twin = fmu if version == "2.0" else unpacked(example, "plant", tmp_path / "twin")
    command = host("gcc -O2", programs)
    assert trajectory(command, own, twin) == trajectory(command, twin.library, twin)


@pytest.mark.slow  # after .ci/run has compiled them
def test_prebuilt_libraries_are_small() -> None:
    """Check libraries of other platforms, if they exist; see hatch_build.py --platforms.

    Libraries for Windows are compared by their compressed size in the FMU.
    """
    from cardsflow_fmu.runtime.library import prebuilt_libraries
    from cardsflow_fmu.runtime.sources import PREBUILT_PLATFORMS

    there = prebuilt_libraries()
    if not there:
        pytest.skip("none here: python hatch_build.py --platforms all")
    unpacked_sizes = {name: file.stat().st_size for name, file in there.items()}
    sizes = {name: len(zlib.compress(file.read_bytes())) for name, file in there.items()}
    print(f"\n{sizes}, unpacked {unpacked_sizes}")
    assert all(size < MAX_PACKED for size in sizes.values())
    assert all(s < MAX_UNPACKED for name, s in unpacked_sizes.items() if "windows" not in name)
    assert set(sizes) <= set(PREBUILT_PLATFORMS)
