"""Directional derivatives, compared with closed forms, by FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from array_model import ARRAYS, INDEX, PORTS, ArrayModel
from support.fmu.fmu_host import load, require_error, unpacked
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.models.reference import ReferenceModel
from cardsflow_fmu.runtime.model import FloatArray, FmuModel
from sim_dart import DartDynamics

pytestmark = pytest.mark.native

STEP = 1e-2
ARM = EXAMPLES / "roboy_left_arm"

Ask = Callable[[Sequence[str], Sequence[str], Sequence[float]], FloatArray]


def jacobian(model: FmuModel, h: float, unknowns: Sequence[str], knowns: Sequence[str]) -> Any:
    """Return the directional derivatives, one column for each known."""
    index = {port.name: k for k, port in enumerate(model.ports)}
    rows = np.array([index[name] for name in unknowns])
    columns = [
        model.directional_derivative(0.0, h, rows, np.array([index[name]]), np.ones(1))
        for name in knowns
    ]
    return np.array(columns).T


def names(model: FmuModel, prefix: str) -> list[str]:
    return [port.name for port in model.ports if port.name.startswith(f"{prefix}.")]


@pytest.fixture
def moving() -> ArrayModel:
    model = ArrayModel()
    model.initialize()
    model.inputs[:2] = 0.7, -0.4
    model.step(0.0, STEP)
    return model


def closed_form(model: ArrayModel, h: float) -> dict[str, FloatArray]:
    u, gain, x = model.inputs[:2], model.parameters[:2], model.outputs[:2]
    return {
        "u": np.diag(3 * h * gain * u**2),
        "x": np.diag(1 - h * np.cos(x)),
        "gain": np.diag(h * u**3),
    }


def test_derivatives_over_a_step(moving: ArrayModel) -> None:
    for prefix, expected in closed_form(moving, STEP).items():
        found = jacobian(moving, STEP, ["x.a", "x.b"], [f"{prefix}.a", f"{prefix}.b"])
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_derivatives_at_the_start(moving: ArrayModel) -> None:
    moving.initialize()
    found = jacobian(moving, 0.0, ["x.a", "x.b"], ["x_start.a", "x_start.b", "u.a"])
    expected = np.column_stack([np.diag(np.cos(moving.parameters[2:])), np.zeros(2)])
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_derivatives_are_linear(moving: ArrayModel) -> None:
    known = np.array([INDEX[name] for name in ("u.a", "x.a", "gain.a", "u.a")])
    seeds = np.array([1e3, -2.0, 0.5, 10.0])
    (found,) = moving.directional_derivative(0.0, STEP, np.array([INDEX["x.a"]]), known, seeds)
    parts = closed_form(moving, STEP)
    expected = 1010 * parts["u"] - 2 * parts["x"] + 0.5 * parts["gain"]
    assert found == pytest.approx(expected[0, 0], rel=1e-7)


def test_derivatives_do_not_change_the_model(moving: ArrayModel) -> None:
    before = moving.values.copy(), moving.get_state()
    jacobian(moving, STEP, ["x.a", "calls"], ["u.a", "x.b", "gain.a"])
    assert (moving.values == before[0]).all()
    assert moving.get_state() == before[1]


def test_counters_have_zero_derivatives(moving: ArrayModel) -> None:
    assert jacobian(moving, STEP, ["calls"], ["u.a", "x.a"]).tolist() == [[0.0, 0.0]]


def test_zero_direction_has_zero_derivative(moving: ArrayModel) -> None:
    one = np.array([INDEX["x.a"]])
    assert moving.directional_derivative(0.0, STEP, one, one, np.zeros(1)) == [0.0]


@pytest.mark.parametrize(("h", "known"), [(STEP, "x_start.a"), (STEP, "on.a"), (0.0, "x.a")])
def test_variables_that_are_not_knowns_are_rejected(
    moving: ArrayModel, h: float, known: str
) -> None:
    with pytest.raises(InputError, match=f"with respect to {known}"):
        jacobian(moving, h, ["x.a"], [known])


def test_models_without_derivatives_reject_requests() -> None:
    experiment = Experiment.load(PLANAR_2R)
    model = ReferenceModel(experiment)
    model.initialize()
    with pytest.raises(InputError, match="no directional derivatives"):
        model.directional_derivative(0.0, STEP, np.array([0]), np.array([0]), np.ones(1))


@pytest.mark.parametrize("folder", [PLANAR_2R, ARM])
def test_plant_against_closed_forms(folder: Path) -> None:
    """qd+ = qd + h (M + h D)^-1 (-L'f - C - G - D qd), q+ = q + h qd+: the integrator of DART."""
    experiment = Experiment.load(folder)
    model, h = PlantModel(experiment), experiment.plant.step
    dynamics = DartDynamics(experiment.robot)
    model.initialize()
    model.inputs[: dynamics.m] = np.linspace(5.0, 20.0, dynamics.m)
    for k in range(5):
        model.step(k * h, h)
    n, at = dynamics.n, model.inputs.size
    q, qd = model.outputs[:n].copy(), model.outputs[n : 2 * n].copy()
    assert model.ports[at].name == names(model, "q")[0]
    rate = -np.linalg.solve(
        dynamics.mass_matrix(q) + h * np.diag(dynamics.damping), dynamics.muscle_jacobian(q).T
    )
    qd_f = jacobian(model, h, names(model, "qd"), names(model, "f"))
    np.testing.assert_allclose(qd_f, h * rate, rtol=1e-5, atol=1e-8)
    after = q + h * qd
    q_f = jacobian(model, h, names(model, "q"), names(model, "f"))
    np.testing.assert_allclose(q_f, h * qd_f, rtol=1e-5, atol=1e-8)
    l_f = jacobian(model, h, names(model, "l"), names(model, "f"))
    np.testing.assert_allclose(l_f, dynamics.muscle_jacobian(after) @ q_f, rtol=1e-3, atol=1e-8)
    l_q = jacobian(model, h, names(model, "l"), names(model, "q"))
    q_q = jacobian(model, h, names(model, "q"), names(model, "q"))
    np.testing.assert_allclose(l_q, dynamics.muscle_jacobian(after) @ q_q, rtol=2e-3, atol=1e-5)


def test_plant_at_the_start() -> None:
    experiment = Experiment.load(PLANAR_2R)
    model, dynamics = PlantModel(experiment), DartDynamics(experiment.robot)
    model.initialize()
    found = jacobian(model, 0.0, names(model, "l"), names(model, "q_start"))
    q = np.array(experiment.start.q)
    np.testing.assert_allclose(found, dynamics.muscle_jacobian(q), rtol=1e-6, atol=1e-9)


def test_controller_against_closed_forms() -> None:
    """-L' df = M kp dq_d, and the same for kd and the acceleration: eq. (3), away from bounds."""
    experiment = Experiment.load(PLANAR_2R)
    model, dynamics = ControllerModel(experiment), DartDynamics(experiment.robot)
    model.initialize()
    q = np.array(experiment.start.q)
    model.inputs[:2] = model.inputs[4:6] = q
    h = experiment.controller.period
    M, L = dynamics.mass_matrix(q), dynamics.muscle_jacobian(q)
    settings = experiment.controller
    for prefix, gain in (("q_d", settings.kp), ("qd_d", settings.kd), ("qdd_d", [1.0, 1.0])):
        found = jacobian(model, h, names(model, "f"), names(model, prefix))
        np.testing.assert_allclose(-L.T @ found, M @ np.diag(gain), rtol=1e-5, atol=1e-6)
    assert (jacobian(model, h, ["solve_time", "at_bound"], names(model, "q")) == 0.0).all()


def test_requests_do_not_change_a_run() -> None:
    experiment = Experiment.load(PLANAR_2R)
    rows = []
    for asks in (False, True):
        plant, controller = PlantModel(experiment), ControllerModel(experiment)
        for model in (plant, controller):
            model.initialize()
        for k in range(20):
            controller.inputs[:4] = plant.outputs[:4]
            if asks:
                jacobian(plant, 1e-3, ["q.joint_1"], names(plant, "f"))
                jacobian(controller, 1e-3, names(controller, "f"), names(controller, "q"))
            controller.step(k * 1e-3, 1e-3)
            plant.inputs[:] = controller.outputs[: plant.inputs.size]
            plant.step(k * 1e-3, 1e-3)
        rows.append(plant.outputs.copy())
    assert (rows[0] == rows[1]).all()


def open_fmu(folder: Path, version: str, arrays: bool) -> tuple[Any, Ask]:
    """Open an instance; return it and a function that requests derivatives by port names."""
    options = {"step": STEP, "fmi": version, "arrays": arrays}
    host = load(unpacked(folder / "two", ArrayModel, PORTS, **options))
    host.open()
    slave = host.slave

    def ask(unknowns: Sequence[str], knowns: Sequence[str], seeds: Sequence[float]) -> FloatArray:
        index = ARRAYS if arrays else INDEX
        references = [[index[name] for name in row] for row in (unknowns, knowns)]
        more = [2 * len(unknowns)] if arrays else []
        return np.array(slave.getDirectionalDerivative(*references, list(seeds), *more))

    return slave, ask


@pytest.mark.parametrize(("version", "arrays"), [("2.0", False), ("3.0", True), ("3.0", False)])
def test_derivatives_by_fmi_equal_python(
    tmp_path: Path, version: str, arrays: bool, moving: ArrayModel
) -> None:
    slave, ask = open_fmu(tmp_path, version, arrays)
    names = ("x", "u") if arrays else (["x.a", "x.b"], ["u.a", "u.b"])
    unknowns, knowns = ([names[0]], [names[1]]) if arrays else names
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    assert ask(unknowns, knowns, [1.0, 1.0]).tolist() == [0.0, 0.0]
    slave.exitInitializationMode()
    slave.setReal([0] if arrays else [0, 1], [0.7, -0.4])
    slave.doStep(0.0, STEP)
    expected = closed_form(moving, STEP)["u"] @ [2.0, -3.0]
    np.testing.assert_allclose(ask(unknowns, knowns, [2.0, -3.0]), expected, atol=1e-9)
    require_error(lambda: ask(knowns, knowns, [1.0, 1.0]))  # inputs are not unknowns
    require_error(lambda: ask(unknowns, knowns, [np.nan, 1.0]))
    require_error(
        lambda: (
            ask(unknowns, knowns, [1.0, 1.0, 1.0]) if version == "3.0" else ask([], ["on.a"], [1.0])
        )
    )
    slave.doStep(STEP, STEP)
    moving.step(STEP, STEP)
    if arrays:
        values = slave.getFloat64([ARRAYS["x"]], 2)
    else:
        values = slave.getReal([INDEX["x.a"], INDEX["x.b"]])
    assert values == moving.outputs[:2].tolist()
    slave.freeInstance()


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_descriptions_declare_derivatives(tmp_path: Path, version: str) -> None:
    files = build(Experiment.load(PLANAR_2R), tmp_path, fmi=version, compute="python")  # type: ignore[arg-type]
    flags = {}
    for name in ("plant", "controller", "reference"):
        with zipfile.ZipFile(files[name]) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
        slave = root.find("CoSimulation")
        assert slave is not None
        plural = "" if version == "2.0" else "s"
        flags[name] = (
            slave.get(f"providesDirectionalDerivative{plural}"),
            slave.get("canHandleVariableCommunicationStepSize"),
        )
    assert flags == {
        "plant": ("true", "false"),
        "controller": ("true", "false"),
        "reference": ("false", "true"),
    }
