"""Native FMUs in other tools, from an environment without this package."""

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

from cardsflow_fmu import Experiment, build
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.simulation.run import simulate_system
from cardsflow_fmu.ssp.reader import read_system, unpack_ssp

pytestmark = pytest.mark.interop

IMPORTERS = SUPPORT / "importers"
STEP, STEPS = 5e-3, 60
SETTINGS = {"run.duration": STEP * STEPS, "run.step": STEP, "controller.period": STEP}
NAMES = ("planar_2r", "roboy_left_arm", "hill_arm")
BUILDS: list[tuple[FmiVersion, bool]] = [("2.0", False), ("3.0", True), ("3.0", False)]


class System(NamedTuple):
    """A native system: its .ssp, and the numbers that its components give."""

    path: Path
    names: list[str]


def experiment_of(example: str) -> Experiment:
    return Experiment.load(EXAMPLES / example, SETTINGS)


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> BareEnvironment:
    folder = tmp_path_factory.mktemp("bare") / "venv"
    return BareEnvironment(folder, "libcosimpy", "ecospy", "fmpy", "numpy", "lxml")


@pytest.fixture(scope="module", params=NAMES)
def system(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> System:
    folder = tmp_path_factory.mktemp(request.param)
    build(experiment_of(request.param), folder, native=True)
    components = read_system(unpack_ssp(folder / "system.ssp", folder / "unpacked")).components
    names = [
        f"{component.name}.{connector.name}"
        for component in components
        for connector in component.connectors
        if connector.kind == "output"
        and connector.type == "Real"
        and connector.name != "solve_time"
    ]
    return System(folder / "system.ssp", names)


@pytest.mark.parametrize("importer", ["with_ecos.py", "with_libcosim.py"])
def test_other_masters_give_our_trajectories(
    bare: BareEnvironment, importer: str, system: System
) -> None:
    """Both couple all participants at once, as our `jacobi` does: the same bits."""
    if importer == "with_ecos.py":
        try:
            ctypes.CDLL("libtbb.so.12")
        except OSError:
            pytest.skip("ecos needs libtbb12")
    arguments = [str(IMPORTERS / importer), str(system.path), str(STEP), str(STEPS)]
    theirs = np.array(json.loads(bare.run([*arguments, *system.names]).splitlines()[-1]))
    ours = simulate_system(system.path, {"run.coupling": "jacobi"})
    assert len(theirs) == STEPS
    for name, column in zip(system.names, theirs.T, strict=True):
        own = ours[name.split(".", 1)[1]][1:]
        np.testing.assert_allclose(column, own, rtol=1e-12, atol=1e-12, err_msg=name)


@pytest.mark.parametrize(("version", "arrays"), BUILDS, ids=str)
@pytest.mark.parametrize("example", ["roboy_left_arm", "hill_arm"])
def test_fmpy_runs_each_alone(
    bare: BareEnvironment, example: str, version: FmiVersion, arrays: bool, tmp_path: Path
) -> None:
    """It validates too; positions and forces in the end are those of FMI 2.0."""
    experiment = experiment_of(example)
    fmus = build(experiment, tmp_path / "out", fmi=version, arrays=arrays, native=True)
    plain = build(experiment, tmp_path / "plain", native=True)
    signals = {
        "plant": ("q", [c.name for c in experiment.robot.coordinates]),
        "controller": ("f", [muscle.name for muscle in experiment.robot.muscles]),
    }
    for model, (prefix, names) in signals.items():
        one_by_one = [f"{prefix}.{name}" for name in names]
        asked = [one_by_one[0].split(".")[0]] if arrays else one_by_one
        assert last(bare, fmus[model], asked) == last(bare, plain[model], one_by_one)


def last(bare: BareEnvironment, file: Path, names: list[str]) -> list[float]:
    """The last values of some variables, nothing being connected."""
    arguments = [str(IMPORTERS / "with_fmpy_alone.py"), str(file), str(STEP), str(STEP * STEPS)]
    values: list[float] = np.ravel(
        np.concatenate(json.loads(bare.run([*arguments, *names]).splitlines()[-1]))
    ).tolist()
    return values


@pytest.mark.parametrize(("version", "arrays"), BUILDS, ids=str)
@pytest.mark.parametrize("example", ["roboy_left_arm", "hill_arm"])
def test_checkers_find_nothing(
    example: str, version: FmiVersion, arrays: bool, tmp_path: Path
) -> None:
    """`fmpy validate` and, where it is installed, `fmutool -check`."""
    files = build(experiment_of(example), tmp_path, fmi=version, arrays=arrays, native=True)
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
