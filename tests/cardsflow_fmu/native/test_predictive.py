"""Model predictive control in experiments: tracking, limits, fallback, rejected experiments."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.fmu.fmu_host import running
from support.fmu.native_states import check_states_repeat
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import build
from cardsflow_fmu import run as simulate
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.utils.arrays import FloatArray

TICK, TICKS = 0.002, 10
PLANAR = {"controller.type": "mpc", "controller.nodes": 8, "run.duration": 0.1}


def run(example: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the columns of a run in C."""
    recording = native_loop(Experiment.load(EXAMPLES / example, settings)).run()
    assert recording.failure is None
    return dict(zip(recording.names, recording.rows.T, strict=True))


def tracking_error(columns: dict[str, Any], q: str = "q", d: str = "q_d") -> Any:
    """Return the largest error of each followed signal."""
    names = [name for name in columns if name.startswith(f"{d}.")]
    return np.array([abs(columns[n] - columns[n.replace(d, q, 1)]).max() for n in names])


def test_arm_follows_reference_in_joint_space() -> None:
    columns = run("planar_2r", PLANAR)
    assert tracking_error(columns).max() < 5e-5
    assert not columns["fallback"].any()
    forces = np.array([columns[f"f.cable_{k}"] for k in (1, 2, 3, 4)])
    assert forces.min() >= 10.0
    assert forces.max() <= 100.0


@pytest.mark.parametrize("scale", [0.8, 1.2])
def test_hand_with_wrong_masses_is_nearer_than_with_computed_torque(scale: float) -> None:
    """The observer's load is part of the predicted motion."""
    settings = {"controller.observer": 30.0, "plant.mass_scale": scale, "run.duration": 0.4}
    expected = tracking_error(run("roboy_left_arm", settings), "y", "y_d")
    settings |= {"controller.type": "mpc", "controller.nodes": 5, "controller.horizon": 0.1}
    columns = run("roboy_left_arm", settings)
    assert (tracking_error(columns, "y", "y_d") < expected).all()


def test_true_masses_need_no_load_of_the_observer() -> None:
    """Forces are constant between ticks: terms at the begin of a tick would be a false load."""
    settings = PLANAR | {"controller.period": 0.005, "run.duration": 0.3}
    without = tracking_error(run("planar_2r", settings)).max()
    observed = tracking_error(run("planar_2r", settings | {"controller.observer": 30.0})).max()
    assert observed < 1.1 * without


def test_arm_recovers_where_computed_torque_falls() -> None:
    """0.3 rad off at the start, with 60 of 100 N: computed torque saturates and falls."""
    settings = {"start": {"q": [-0.2, 0.8]}, "muscles": {"*": {"f_max": 60.0}}}
    settings |= {"run.duration": 0.5, "controller.period": 0.002}
    falling = run("planar_2r", settings)
    assert falling["infeasible"][-10:].all()
    late = {name: values[-10:] for name, values in run("planar_2r", PLANAR | settings).items()}
    assert tracking_error(late).max() < 5e-3


@pytest.mark.parametrize(
    ("joint", "pose", "f_max"),
    [(1, [1.53, 0.01, 0.3, -0.76], 85.0), (2, [1.63, -0.55, 0.29, -1.28], 79.0)],
)
def test_default_horizon_is_long_enough_to_return(
    joint: int, pose: list[float], f_max: float
) -> None:
    """The muscles are 5 % stronger than the pose requires, and a joint is 0.3 rad off."""
    start = [q - 0.3 * (k == joint) for k, q in enumerate(pose)]
    settings = {"start": {"q": start}, "muscles": {"*": {"f_max": f_max}}, "run.duration": 0.8}
    settings["reference"] = {"points": [{"time": t, "q": pose} for t in (0.0, 1.0)]}
    law = {"kp": 400.0, "kd": 40.0, "period": 0.004}
    for kind, recovers in (("joint_space", False), ("mpc", True)):
        columns = run("roboy_left_arm", settings | {"controller": law | {"type": kind}})
        late = {name: values[-10:] for name, values in columns.items()}
        assert (tracking_error(late).max() < 5e-3) == recovers


def test_default_horizon_follows_slowest_error() -> None:
    """The slowest eigenvalues are -10 of -10 and -15, -10 ± 10i due to the costs, and -1."""
    for kp, kd, time in ((150.0, 25.0, 0.4), (200.0, 0.0, 0.4), (1.0, 2.0, 1.0)):
        settings = PLANAR | {"controller.kp": [kp, 2000.0], "controller.kd": [kd, 90.0]}
        controller = Experiment.load(EXAMPLES / "planar_2r", settings).controller
        assert controller.predicted_time == pytest.approx(time)


def test_stiff_joint_is_predicted_with_more_runge_kutta_steps() -> None:
    """Its fastest motion decays by exp(-7.8) in an interval, which one step cannot represent."""
    settings = {"robot.coordinates.joint_1.damping": 20.0, "run.duration": 0.05}
    settings |= {"controller.horizon": 0.4, "controller.nodes": 20}
    columns = run("planar_2r", PLANAR | settings)
    assert not columns["fallback"].any()
    assert tracking_error(columns).max() < 1e-5


def test_free_arm_without_rates_is_predicted() -> None:
    """Without gravity, damping and pretension, the arm has no rate that determines the steps."""
    settings = PLANAR | {f"robot.coordinates.joint_{k}.damping": 0.0 for k in (1, 2)}
    settings |= {f"robot.muscles.cable_{k}.f_min": 0.0 for k in (1, 2, 3, 4)}
    experiment = Experiment.load(EXAMPLES / "planar_2r", settings)
    robot = replace(experiment.robot, gravity=(0.0, 0.0, 0.0))
    recording = native_loop(replace(experiment, robot=robot)).run()
    columns = dict(zip(recording.names, recording.rows.T, strict=True))
    assert not columns["fallback"].any()
    assert tracking_error(columns).max() < 5e-5


def test_hill_muscles_without_force_limits() -> None:
    """The first tick needs more iterations than the limit of the others."""
    settings = {"controller.type": "mpc", "run.duration": 0.05}
    columns = run("hill_arm", settings)
    assert not columns["fallback"].any()
    assert tracking_error(columns, "y", "y_d").max() < 1e-4


def test_motor_without_limits_has_solutions() -> None:
    """The controller's limits are then those of numbers, -1.8e308 N·m to 1.8e308 N·m."""
    columns = run("planar_2r", PLANAR | {"robot.joints.joint_2": {"motor": True}})
    assert tracking_error(columns).max() < 5e-5
    assert not columns["fallback"].any()


def test_tick_without_solution_uses_computed_torque() -> None:
    """One iteration never converges: all forces are those of the fallback."""
    columns = run("planar_2r", {**PLANAR, "controller.iterations": 1, "run.duration": 0.01})
    assert columns["fallback"][:-1].all()
    expected = run("planar_2r", {"run.duration": 0.01})
    for name, values in expected.items():
        np.testing.assert_array_equal(columns[name], values)


def test_late_ticks_use_computed_torque() -> None:
    columns = run("planar_2r", {**PLANAR, "controller.deadline": 1e-9, "run.duration": 0.01})
    assert columns["late"][:-1].all()
    assert columns["fallback"][:-1].all()
    expected = run("planar_2r", {"run.duration": 0.01})
    for name, values in expected.items():
        np.testing.assert_array_equal(columns[name], values)


def test_planned_forces_keep_own_bounds() -> None:
    """Without them, the first cable needs 51 N, and two cables are at 10 N."""
    settings = {"controller.bounds": {"f_min": 11.0, "f_max": {"cable_1": 50.0}}}
    settings |= {"start": {"q": [-0.52, 0.5]}, "run.duration": 0.02}
    columns = run("planar_2r", PLANAR | settings)
    assert not columns["fallback"].any()
    forces = np.array([columns[f"f.cable_{k}"] for k in (1, 2, 3, 4)])[:, :-1]
    assert forces.min() == pytest.approx(11.0, abs=1e-3)
    assert forces[0].max() == pytest.approx(50.0, abs=1e-3)
    assert (forces >= 11.0).all()
    assert (forces[0] <= 50.0).all()


@pytest.mark.slow
def test_python_and_native_fmus_compute_the_same_bits(tmp_path: Path) -> None:
    """Experiments in FMUs keep settings that only name some coordinates."""
    settings = PLANAR | {"controller.bounds.q_max": {"joint_1": 0.7}, "run.compute": "c"}
    native = simulate(Experiment.load(EXAMPLES / "planar_2r", settings), tmp_path / "c")
    settings["run.compute"] = "python"
    python = simulate(Experiment.load(EXAMPLES / "planar_2r", settings), tmp_path / "python")
    for name in native.names:
        np.testing.assert_array_equal(native[name], python[name])


class Driven(NamedTuple):
    """Native FMU of a predictive controller; its inputs and forces in a run in C, by name."""

    file: Path
    experiment: Experiment
    inputs: dict[str, FloatArray]
    forces: dict[str, FloatArray]


@pytest.fixture(scope="module", params=["planar_2r", "roboy_left_arm"])
def driven(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Driven:
    settings = {"controller.type": "mpc", "controller.period": TICK}
    settings |= {"run.step": TICK, "run.duration": TICKS * TICK}
    columns = run(request.param, settings)
    assert not columns["fallback"].any()
    experiment = Experiment.load(EXAMPLES / request.param, settings)
    file = build(experiment, tmp_path_factory.mktemp("fmus"), compute="c")["controller"]
    ports = [port.name for port in ControllerModel(experiment).ports if port.causality == "input"]
    inputs = {name: columns[name] for name in ports if name in columns}
    forces = {name: columns[name] for name in columns if name.startswith("f.")}
    return Driven(file, experiment, inputs, forces)


@pytest.mark.native
def test_restored_states_are_bit_identical(driven: Driven, tmp_path: Path) -> None:
    check_states_repeat(driven.file, tmp_path / "unpacked", step=TICK)


def test_model_in_python_and_fmu_in_fmpy_compute_the_same_bits(
    driven: Driven, tmp_path: Path
) -> None:
    model = ControllerModel(driven.experiment)
    place = {port.name: k for k, port in enumerate(model.ports)}
    model.initialize()
    with running(driven.file, tmp_path / "unpacked") as host:
        for k in range(TICKS):
            given = {name: float(column[k]) for name, column in driven.inputs.items()}
            expected = [column[k] for column in driven.forces.values()]
            model.values[[place[name] for name in given]] = list(given.values())
            model.step(k * TICK, TICK)
            host.set(**given)
            host.slave.doStep(k * TICK, TICK)
            assert model.values[[place[name] for name in driven.forces]].tolist() == expected
            assert host.get(*driven.forces) == expected
    assert len(expected) == len(driven.experiment.robot.muscles)


@pytest.mark.interop
@pytest.mark.skipif(shutil.which("fmusim") is None, reason="needs fmusim of the Reference FMUs")
def test_fmusim_computes_the_same_forces(driven: Driven, tmp_path: Path) -> None:
    """Inputs change just before the next tick, since fmusim interpolates them linearly."""
    begins = np.arange(TICKS) * TICK
    times = np.ravel(np.column_stack([begins, begins + TICK - 1e-9]))
    held = [np.repeat(column[:TICKS], 2) for column in driven.inputs.values()]
    given, found = tmp_path / "inputs.csv", tmp_path / "outputs.csv"
    names = ",".join(["time", *driven.inputs])
    np.savetxt(given, np.column_stack([times, *held]), "%.17g", ",", header=names, comments="")
    words = ["fmusim", "--input-file", str(given), "--output-file", str(found)]
    words += ["--stop-time", str(TICKS * TICK), "--output-interval", str(TICK)]
    words += [word for name in driven.forces for word in ("--output-variable", name)]
    subprocess.run([*words, str(driven.file)], check=True)
    rows = np.genfromtxt(found, delimiter=",", names=True, deletechars="")
    for name, column in driven.forces.items():
        np.testing.assert_allclose(rows[name][1:], column[:-1], rtol=1e-12, err_msg=name)


def test_copied_controller_has_same_forces() -> None:
    """The last motion is part of the state."""
    model = ControllerModel(Experiment.load(EXAMPLES / "planar_2r", PLANAR))
    model.views["q"][:], model.views["reference"][:2] = [0.1, -0.2], [0.0, 0.1]
    model.initialize()
    model.step(0.0, 1e-3)
    state, forces = model.get_state(), []
    for _ in range(2):
        model.set_state(state)
        model.step(1e-3, 1e-3)
        forces.append(model.views["forces"].copy())
    np.testing.assert_array_equal(*forces)


@pytest.mark.parametrize(
    ("example", "settings", "message"),
    [
        ("pick_up", {}, "'mpc' does not support contacts"),
        ("planar_2r", {"plant.engine": "dart"}, 'does not support plant.engine = "dart"'),
        ("planar_2r", {"controller.engine": "dart"}, 'not support controller.engine = "dart"'),
        ("planar_2r", {"controller.solver": "daqp"}, "solver: must be 'dual_newton' for 'mpc'"),
        ("bicycle", {}, "'mpc' does not support closed kinematic loops"),
        ("cable_robot", {"controller.space": "operational"}, 'set controller.space = "joint"'),
        ("planar_2r", {"controller.nodes": 1}, "controller.nodes: .*at least 2"),
        ("planar_2r", {"controller.horizon": 0.001}, "controller.horizon: must be longer than"),
        ("planar_2r", {"controller.deadline": 0.01}, "controller.deadline: must be at most the"),
        *(
            ("planar_2r", {"controller.bounds": bounds}, f"controller.bounds.{message}")
            for bounds, message in [
                ({"f_min": {"cable_1": 30.0}, "f_max": 20.0}, "f_max.cable_1: must be at least"),
                ({"f_min": 5.0}, "f_min.cable_1: must be within the limits of the robot, 10 to"),
                ({"f_max": {"cable_3": 300.0}}, "f_max.cable_3: must be within the limits of"),
                ({"q_min": 1.0, "q_max": 0.5}, "q_max.joint_1: must be at least the minimum, 1"),
                ({"f_max": {"cable_9": 20.0}}, "f_max.cable_9: no"),
                ({"qd_max": -1.0}, "qd_max: "),
                ({"fmax": 20.0}, "fmax: no key 'fmax'; did you mean 'f_max'"),
            ]
        ),
        ("planar_2r", {"controller.cost": {"tracing": 1.0}}, "no key 'tracing'; did you mean"),
    ],
)
def test_unsupported_experiments_are_rejected_by_name(
    example: str, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Experiment.load(EXAMPLES / example, {"controller.type": "mpc", **settings})


def test_keys_of_mpc_are_rejected_for_other_laws() -> None:
    with pytest.raises(InputError, match=r"controller.horizon: no key 'horizon'"):
        Experiment.load(EXAMPLES / "planar_2r", {"controller.horizon": 0.2})
