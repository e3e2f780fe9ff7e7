"""Linear models at slack cables, compared with closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from support.fmu.fmu_host import running
from support.fmu.native_slopes import FloatArray
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.run_modes import COMPUTE

from addin_sdfusion.robot.model.muscle_laws import command_range
from cardsflow_fmu import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build
from sim_dart import CoreDynamics

pytestmark = pytest.mark.native

H = 1e-3
PULLS = {
    "no force": lambda f_min: np.zeros_like(f_min),
    "minus no force": lambda f_min: -np.zeros_like(f_min),
    "hardly any": lambda f_min: np.full_like(f_min, 1e-8),
    "f_min": lambda f_min: f_min,
    "inside": lambda f_min: f_min + np.linspace(5.0, 20.0, f_min.size),
}


def slopes(
    experiment: Experiment,
    folder: Path,
    fmi: FmiVersion,
    commands: FloatArray,
    of: str = "qd",
) -> tuple[FloatArray, FloatArray]:
    """Return derivatives of outputs after a step, by single commands and a mixed direction."""
    file = build(experiment, folder, compute="c", fmi=fmi, arrays=False)["plant"]
    with running(file, folder / "unpacked") as host:
        muscles = [n for n in host.references if n.split(".")[0] in ("f", "u")]
        inputs = [host.references[name] for name in muscles]
        outputs = [r for name, r in host.references.items() if name.startswith(f"{of}.")]
        host.slave.reset()
        host.start(**dict(zip(muscles, commands.tolist(), strict=True)))
        more = [len(outputs)] if fmi == "3.0" else []

        def along(knowns: list[int], seeds: FloatArray) -> list[float]:
            return list(host.slave.getDirectionalDerivative(outputs, knowns, list(seeds), *more))

        single = np.array([along([k], np.ones(1)) for k in inputs]).T
        mixed = np.array(along(inputs, directions(len(inputs))))
        host.slave.terminate()
    return single, mixed


def directions(count: int) -> FloatArray:
    return np.linspace(-1.0, 0.7, count)


def closed_form(experiment: Experiment) -> FloatArray:
    """Return -h (M + h D)^-1 L'."""
    dynamics, q = CoreDynamics(experiment.robot), np.array(experiment.start.q)
    M, L = dynamics.mass_matrix(q), dynamics.muscle_jacobian(q)
    rates: FloatArray = -H * np.linalg.solve(M + H * np.diag(dynamics.damping), L.T)
    return rates


@pytest.mark.cases(8)
@pytest.mark.slow
@pytest.mark.parametrize("version", ["3.0", "2.0"])
@pytest.mark.parametrize("pull", PULLS)
def test_cable_at_zero_force_has_the_derivative_of_a_pull(
    pull: str, version: FmiVersion, tmp_path: Path
) -> None:
    """B = -M^-1 L' for forces >= 0: the derivative on the side on which cables pull."""
    experiment = Experiment.load(PLANAR_2R)
    commands = PULLS[pull](np.array([muscle.f_min for muscle in experiment.robot.muscles]))
    expected = closed_form(experiment)
    size = np.abs(expected).max()
    single, mixed = slopes(experiment, tmp_path, version, commands)
    np.testing.assert_allclose(single, expected, atol=1e-7 * size)
    np.testing.assert_allclose(mixed, expected @ directions(commands.size), atol=1e-7 * size)


@pytest.mark.slow
@pytest.mark.parametrize("example", ["planar_2r", "hill_arm", "roboy_left_arm"])
def test_commands_start_with_those_before_the_first_tick(example: str, tmp_path: Path) -> None:
    """f_min for cables, the holding command for muscles with laws; both kinds agree."""
    experiment = Experiment.load(EXAMPLES / example)
    controller = ControllerModel(experiment)
    controller.initialize()
    first = {
        port.name: value for port, value in zip(controller.ports, controller.values, strict=True)
    }
    commands = [port for port in PlantModel.table(experiment) if port.name[:2] in ("f.", "u.")]
    assert {port.name: port.start for port in commands} == {p.name: first[p.name] for p in commands}
    if example == "planar_2r":
        assert [port.start for port in commands] == [m.f_min for m in experiment.robot.muscles]
    tables = []
    for native in (True, False):
        file = build(experiment, tmp_path / str(native), compute=COMPUTE[native])["plant"]
        variables = read_model_description(file).modelVariables
        tables.append({v.name: v.start for v in variables if v.causality == "input"})
    assert tables[0] == tables[1]
    assert {float(tables[0][port.name]) for port in commands} == {port.start for port in commands}


def test_cable_with_negative_force_is_slack(tmp_path: Path) -> None:
    """For any negative force, independent of other cables."""
    experiment = Experiment.load(PLANAR_2R)
    commands = np.array([-1e-9, 0.0, 3.0, -2.0])
    expected = closed_form(experiment) * (commands >= 0)
    size = np.abs(expected).max()
    single, mixed = slopes(experiment, tmp_path, "2.0", commands)
    assert not single[:, commands < 0].any()
    np.testing.assert_allclose(single, expected, atol=1e-7 * size)
    np.testing.assert_allclose(mixed, expected @ directions(commands.size), atol=1e-7 * size)


@pytest.mark.slow
@pytest.mark.parametrize("at_the_top", [False, True])
def test_commands_at_the_ends_of_their_range(at_the_top: bool, tmp_path: Path) -> None:
    """Muscles with laws have the derivative inside: pressures change by 1 - exp(-h / T)."""
    experiment = Experiment.load(EXAMPLES / "pneumatic_elbow", {"plant.energy": False})
    ranges = [command_range(muscle.model) for muscle in experiment.robot.muscles]
    ends = np.array(ranges)[:, int(at_the_top)]
    assert np.isfinite(ends).all()
    (T,) = {dict(m.model.parameters)["pressure_time_constant"] for m in experiment.robot.muscles}
    expected = (1 - np.exp(-H / T)) * np.eye(ends.size)
    single, mixed = slopes(experiment, tmp_path, "2.0", ends, "pressure")
    np.testing.assert_allclose(single, expected, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(mixed, expected @ directions(ends.size), rtol=1e-6)
