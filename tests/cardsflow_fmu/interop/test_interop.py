"""Systems and FMUs in other tools, in an environment without this package and DART."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from support.fmu.bare_environment import BareEnvironment
from support.fmu.fmu_host import SUPPORT
from support.robots.robots import EXAMPLES
from support.run_modes import COMPUTE
from support.ssp_runs import simulate_system

from cardsflow_fmu import Experiment, build
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.participant import Form
from cardsflow_fmu.cosim.wiring import connect
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.ssp.reader import read_system, unpack_ssp

pytestmark = pytest.mark.interop

IMPORTERS = SUPPORT / "importers"
STEP = 1e-3
NATIVE_STEP, NATIVE_STEPS = 5e-3, 60
BUILDS: list[tuple[FmiVersion, bool]] = [("2.0", False), ("3.0", True), ("3.0", False)]

NATIVE_BUILDS = [("roboy_left_arm", "3.0", True), *(("hill_arm", *how) for how in BUILDS)]


class Case(NamedTuple):
    """System of an example, its coupling, and tolerances for results of other tools."""

    example: str
    steps: int
    native: bool = False
    step: float = STEP
    near: float = 1e-9


CASES = [
    Case("planar_2r", 1000),
    Case("roboy_left_arm", 100),
    *(
        Case(example, NATIVE_STEPS, True, NATIVE_STEP, 1e-12)
        for example in ("planar_2r", "roboy_left_arm", "hill_arm")
    ),
]


class System(NamedTuple):
    """System: its .ssp, the unpacked files, and the numeric outputs of its components."""

    case: Case
    path: Path
    unpacked: Path
    names: list[str]


def run_settings(step: float, steps: int) -> dict[str, float]:
    return {"run.duration": step * steps, "run.step": step, "controller.period": step}


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> BareEnvironment:
    folder = tmp_path_factory.mktemp("bare") / "venv"
    return BareEnvironment(folder, "libcosimpy", "ecospy", "fmpy", "numpy", "lxml")


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"{case.example}-{case.native}")
def system(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> System:
    case: Case = request.param
    folder = tmp_path_factory.mktemp(case.example)
    experiment = Experiment.load(EXAMPLES / case.example, run_settings(case.step, case.steps))
    build(experiment, folder, compute=COMPUTE[case.native])
    components = read_system(unpack_ssp(folder / "system.ssp", folder / "unpacked")).components
    names = [  # all except computing times
        f"{component.name}.{connector.name}"
        for component in components
        for connector in component.connectors
        if connector.kind == "output"
        and connector.type == "Real"
        and connector.name != "solve_time"
    ]
    return System(case, folder / "system.ssp", folder / "unpacked", names)


def run(bare: BareEnvironment, importer: str, system: System) -> np.ndarray:
    """Run the system in another tool, and return the rows of its outputs."""
    words = [str(system.path), str(system.case.step), str(system.case.steps), *system.names]
    rows = json.loads(bare.run([str(IMPORTERS / importer), *words]).splitlines()[-1])
    assert len(rows) == system.case.steps
    return np.array(rows)


@pytest.mark.cases(2)
@pytest.mark.parametrize("importer", ["with_ecos.py", "with_libcosim.py"])
def test_other_masters_compute_the_same_trajectories(
    bare: BareEnvironment, importer: str, system: System
) -> None:
    """Ecos and libcosim use the same coupling as `jacobi`."""
    if importer == "with_ecos.py":
        try:
            ctypes.CDLL("libtbb.so.12")
        except OSError:
            pytest.skip("ecos needs libtbb12")
    theirs, near = run(bare, importer, system), system.case.near
    ours = simulate_system(system.path, {"run.scheme": "jacobi"})
    for name, column in zip(system.names, theirs.T, strict=True):
        own = ours[name.split(".", 1)[1]][1:]
        np.testing.assert_allclose(column, own, rtol=near, atol=near, err_msg=name)


@pytest.mark.parametrize("system", CASES[:2], indirect=True, ids=lambda case: case.example)
def test_fmpy_runs_the_system(bare: BareEnvironment, system: System, tmp_path: Path) -> None:
    """FMPy uses the same coupling too, but its first step has zero inputs."""
    theirs = run(bare, "with_fmpy.py", system)
    structure = read_system(system.unpacked)
    fmus = [
        FmuInstance(c.name, system.unpacked / c.source, tmp_path / c.name)
        for c in structure.components
    ]
    wiring = {".".join(c.target): ".".join(c.source) for c in structure.connections}
    copies = [copy for some in connect(fmus, wiring, by_name=False).values() for copy in some]
    rows = []
    for fmu in fmus:
        for k, name in enumerate(fmu.input_names):
            if f"{fmu.name}.{name}" in wiring:
                fmu.inputs[k] = 0.0
    for k in range(system.case.steps):
        for fmu in fmus:
            fmu.step(k * STEP, STEP)
        for copy in copies:
            assert copy.form == Form.EXACT
            copy.target[copy.target_index] = copy.source[copy.source_index]
        values = {
            f"{f.name}.{n}": v for f in fmus for n, v in zip(f.output_names, f.outputs, strict=True)
        }
        rows.append([values[name] for name in system.names])
    for fmu in fmus:
        fmu.close()
    np.testing.assert_allclose(theirs, rows, rtol=1e-9, atol=1e-9)


@pytest.mark.cases(1)
@pytest.mark.parametrize(("version", "arrays"), BUILDS, ids=str)
def test_unconnected_plant_and_controller_run_in_fmpy(
    bare: BareEnvironment, tmp_path: Path, version: FmiVersion, arrays: bool
) -> None:
    """The arm falls without forces; the controller runs with zero inputs."""
    experiment = Experiment.load(EXAMPLES / "planar_2r", {"run.duration": 0.1})
    fmus = build(experiment, tmp_path, fmi=version, arrays=arrays, compute="python")
    for role, model in (("plant", PlantModel), ("controller", ControllerModel)):
        direct = model(experiment)
        direct.initialize()
        for k in range(100):
            direct.step(k * STEP, STEP)
        signals = {"plant": ("q.joint_1", "q.joint_2"), "controller": ("f.cable_1", "f.cable_4")}
        names = [signals[role][0][0]] if arrays else list(signals[role])
        arguments = [str(IMPORTERS / "with_fmpy_alone.py"), str(fmus[role]), str(STEP), "0.1"]
        values = np.ravel(json.loads(bare.run([*arguments, *names]).splitlines()[-1]))
        ports = [port.name for port in direct.ports]
        expected = [direct.values[ports.index(name)] for name in signals[role]]
        np.testing.assert_allclose([values[0], values[-1]], expected, rtol=1e-9)


@pytest.mark.cases(1)
@pytest.mark.parametrize(("example", "version", "arrays"), NATIVE_BUILDS)
def test_unconnected_native_plant_and_controller_run_in_fmpy(
    bare: BareEnvironment, example: str, version: FmiVersion, arrays: bool, tmp_path: Path
) -> None:
    """FMPy validates the FMUs; final positions and forces are the same as with FMI 2.0."""
    experiment = Experiment.load(EXAMPLES / example, run_settings(NATIVE_STEP, NATIVE_STEPS))
    fmus = build(experiment, tmp_path / "out", fmi=version, arrays=arrays, compute="c")
    plain = build(experiment, tmp_path / "plain", compute="c")
    signals = {
        "plant": ("q", [c.name for c in experiment.robot.coordinates]),
        "controller": ("f", [muscle.name for muscle in experiment.robot.muscles]),
    }
    for model, (prefix, names) in signals.items():
        one_by_one = [f"{prefix}.{name}" for name in names]
        asked = [one_by_one[0].split(".")[0]] if arrays else one_by_one
        assert last(bare, fmus[model], asked) == last(bare, plain[model], one_by_one)


def last(bare: BareEnvironment, file: Path, names: list[str]) -> list[float]:
    """Return the final values of some variables of an unconnected FMU."""
    arguments = [
        str(IMPORTERS / "with_fmpy_alone.py"),
        str(file),
        str(NATIVE_STEP),
        str(NATIVE_STEP * NATIVE_STEPS),
    ]
    values: list[float] = np.ravel(
        np.concatenate(json.loads(bare.run([*arguments, *names]).splitlines()[-1]))
    ).tolist()
    return values


@pytest.mark.cases(1)
@pytest.mark.parametrize(("example", "version", "arrays"), NATIVE_BUILDS)
def test_checkers_report_no_problems_in_native_fmus(
    example: str, version: FmiVersion, arrays: bool, tmp_path: Path
) -> None:
    """`fmpy validate` and, if it is installed, `fmutool -check`."""
    files = build(
        Experiment.load(EXAMPLES / example, run_settings(NATIVE_STEP, NATIVE_STEPS)),
        tmp_path,
        fmi=version,
        arrays=arrays,
        compute="c",
    )
    for file in files.values():
        assert validate_fmu(str(file)) == []
        if importlib.util.find_spec("fmu_manipulation_toolbox"):
            tool = Path(sys.executable).parent / "fmutool"
            done = subprocess.run(
                [tool, "-input", file, "-check"], capture_output=True, text=True, check=False
            )
            said = done.stdout + done.stderr
            assert f"compliant with FMI-{version}" in said
            assert not any(word in said for word in ("ERROR", "WARNING", "CRITICAL"))
