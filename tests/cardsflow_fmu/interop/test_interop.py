"""The .ssp in other tools, from an environment without this package and without DART."""

from __future__ import annotations

import ctypes
import json
from pathlib import Path

import numpy as np
import pytest
from support.fmu.bare_environment import BareEnvironment
from support.fmu.fmu_host import SUPPORT

from cardsflow_fmu import Experiment, build
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.wiring import connect
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.run import simulate_system
from cardsflow_fmu.ssp.reader import read_system, unpack_ssp

pytestmark = pytest.mark.interop

IMPORTERS = SUPPORT / "importers"
EXAMPLES = Path(__file__).parents[3] / "examples"
STEP = 1e-3
STEPS = {"planar_2r": 1000, "roboy_left_arm": 100}


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> BareEnvironment:
    folder = tmp_path_factory.mktemp("bare") / "venv"
    return BareEnvironment(folder, "libcosimpy", "ecospy", "fmpy", "numpy", "lxml")


@pytest.fixture(scope="module", params=STEPS)
def system(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    steps = STEPS[request.param]
    settings = {"run.duration": steps * STEP, "run.step": STEP, "controller.period": STEP}
    experiment = Experiment.load(EXAMPLES / request.param, settings)
    return built(experiment, tmp_path_factory.mktemp(request.param))


def built(experiment: Experiment, folder: Path) -> Path:
    """The system that is built beside the FMUs."""
    build(experiment, folder)
    return folder / "system.ssp"


def signals(path: Path, folder: Path) -> list[str]:
    """All numbers that the components give, but times of computation."""
    components = read_system(unpack_ssp(path, folder)).components
    return [
        f"{component.name}.{connector.name}"
        for component in components
        for connector in component.connectors
        if connector.kind == "output"
        and connector.type == "Real"
        and connector.name != "solve_time"
    ]


def loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def steps_of(path: Path) -> int:
    return next(steps for name, steps in STEPS.items() if name in str(path))


def run(bare: BareEnvironment, importer: str, path: Path, names: list[str]) -> np.ndarray:
    steps = steps_of(path)
    printed = bare.run([str(IMPORTERS / importer), str(path), str(STEP), str(steps), *names])
    rows = json.loads(printed.splitlines()[-1])
    assert len(rows) == steps
    return np.array(rows)


@pytest.mark.parametrize("importer", ["with_ecos.py", "with_libcosim.py"])
def test_other_masters_give_our_trajectories(
    bare: BareEnvironment, importer: str, system: Path, tmp_path: Path
) -> None:
    """Both, ecos and libcosim, couple all participants at once, as our `jacobi` does."""
    if importer == "with_ecos.py" and not loads("libtbb.so.12"):
        pytest.skip("ecos needs libtbb12")
    names = signals(system, tmp_path / "unpacked")
    theirs = run(bare, importer, system, names)
    ours = simulate_system(system, {"run.coupling": "jacobi"})
    for name, column in zip(names, theirs.T, strict=True):
        own = ours[name.split(".", 1)[1]][1:]
        np.testing.assert_allclose(column, own, rtol=1e-9, atol=1e-9, err_msg=name)


def test_fmpy_runs_the_system(bare: BareEnvironment, system: Path, tmp_path: Path) -> None:
    """FMPy's system simulation steps all at once too, but the first time with inputs of zero."""
    names = signals(system, tmp_path / "unpacked")
    theirs = run(bare, "with_fmpy.py", system, names)
    structure = read_system(tmp_path / "unpacked")
    fmus = [
        FmuInstance(c.name, tmp_path / "unpacked" / c.source, tmp_path / c.name)
        for c in structure.components
    ]
    wiring = {".".join(c.target): ".".join(c.source) for c in structure.connections}
    copies = [copy for some in connect(fmus, wiring, by_name=False).values() for copy in some]
    rows = []
    for fmu in fmus:
        for k, name in enumerate(fmu.input_names):
            if f"{fmu.name}.{name}" in wiring:
                fmu.inputs[k] = 0.0
    for k in range(steps_of(system)):
        for fmu in fmus:
            fmu.step(k * STEP, STEP)
        for copy in copies:
            copy()
        values = {
            f"{f.name}.{n}": v for f in fmus for n, v in zip(f.output_names, f.outputs, strict=True)
        }
        rows.append([values[name] for name in names])
    for fmu in fmus:
        fmu.close()
    np.testing.assert_allclose(theirs, rows, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("version", "arrays"), [("2.0", False), ("3.0", True), ("3.0", False)], ids=str
)
def test_plant_and_controller_run_in_fmpy_alone(
    bare: BareEnvironment, tmp_path: Path, version: FmiVersion, arrays: bool
) -> None:
    """The arm falls, nothing pulling; the controller ticks with inputs of zero."""
    experiment = Experiment.load(EXAMPLES / "planar_2r", {"run.duration": 0.1})
    fmus = build(experiment, tmp_path, fmi=version, arrays=arrays)
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
