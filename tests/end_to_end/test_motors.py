"""Motors at joints from robot files to results: pendulums, arms and a hybrid robot."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from support.cases import sample_cases
from support.robots.one_link import one_link
from support.robots.random_robots import random_tree
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r, with_coordinates
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import Inertia, InputError, read_robot, revolute, write_sdf
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.hardware.protocol.signals import hardware_signature
from cardsflow_fmu.results.report.panels import all_panels
from cardsflow_fmu.results.viewer.scene.motion import motion_of
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.simulation.result import Result
from cardsflow_fmu.simulation.run import run, simulate
from sim_dart import CoreDynamics, DartDynamics, Plant

MASS, REACH, ABOUT, GRAVITY = 2.0, 0.3, 0.05, 9.81
J = ABOUT + MASS * REACH**2

PENDULUM = """
[robot]
path = "model.sdf"
[robot.joints.j]
motor = true
effort = {effort}
[reference]
spline = "quintic"
points = [{{ time = 0.0, q = {{ q = 0.3 }} }}, {{ time = 0.5, q = {{ q = 1.2 }} }}]
[controller]
kp = 400.0
kd = 40.0
[plant]
energy = true
[run]
step = 0.001
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    """Write a pendulum that rotates by q about -y, without muscles and motors in its file."""
    inertia = Inertia(MASS, (REACH, 0.0, 0.0), ABOUT, ABOUT, ABOUT)
    write_sdf(one_link(inertia, motions=revolute((0.0, -1.0, 0.0))), tmp_path)
    return tmp_path


def load(folder: Path, effort: object, **settings: Any) -> Experiment:
    (folder / "experiment.toml").write_text(PENDULUM.format(effort=effort))
    return Experiment.load(folder, settings)


@pytest.mark.parametrize("through", sample_cases(["native", "fmu", "direct"]))
def test_pendulum_with_a_motor_tracks(pendulum: Path, through: Any) -> None:
    """The torque matches J qdd + m g c cos(q), and the motion matches semi-implicit Euler."""
    result = simulate(load(pendulum, 50.0), **RUN_MODES[through])
    column = dict(zip(result.names, result.rows.T, strict=True))
    q, qd, tau = column["q.q"], column["qd.q"], column["tau.q"]
    desired = column["qdd_d.q"] + 40.0 * (column["qd_d.q"] - qd) + 400.0 * (column["q_d.q"] - q)
    weight = MASS * GRAVITY * REACH * np.cos(q)
    np.testing.assert_allclose(tau[:-1], (J * desired + weight)[:-1], rtol=1e-11)
    np.testing.assert_allclose(np.diff(qd), 1e-3 * (tau - weight)[:-1] / J, atol=1e-13)
    assert np.abs(column["q_d.q"] - q).max() < 1e-3
    kinetic = 0.5 * J * qd**2
    np.testing.assert_allclose(column["energy.kinetic"], kinetic, atol=1e-13)
    way = np.concatenate([[0.0], np.cumsum(tau[:-1] * 0.5e-3 * (qd[:-1] + qd[1:]))])
    np.testing.assert_allclose(column["work.outside"], way, atol=1e-12)
    assert result.units["tau.q"] == "N.m"


def test_weak_motor_saturates(pendulum: Path) -> None:
    result = simulate(load(pendulum, "[-1.0, 5.5]"), compute="python", coupling="direct")
    column = dict(zip(result.names, result.rows.T, strict=True))
    assert column["tau.q"].max() == 5.5
    assert column["tau.q"].min() >= -1.0
    assert column["infeasible"].any()
    assert (column["at_bound"][column["infeasible"] > 0] == 1).all()


def test_robot_without_muscles_and_motors_raises_an_error(
    pendulum: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    load(pendulum, 50.0)
    assert main(["run", str(pendulum), "--set", "robot.joints.j.motor=false"]) == 2
    assert "no muscles and no motors" in capsys.readouterr().err


def test_results_of_a_robot_without_muscles_can_be_opened(pendulum: Path, tmp_path: Path) -> None:
    results = tmp_path / "out"
    run(load(pendulum, 50.0, **{"run.duration": 0.1}), results)
    for words, name in (
        (["view", str(results), "--html"], "page.html"),
        (["report", str(results), "-o"], "report.html"),
        (["plot", str(results), "-o"], "figure.png"),
    ):
        assert main([*words, str(tmp_path / name)]) == 0
        assert (tmp_path / name).stat().st_size > 1000


AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}
ELBOW = {"robot.joints.joint_2.motor": True, "robot.joints.joint_2.effort": 3.0}
HAND = {"robot.coordinates.joint_3.actuated": True, "robot.coordinates.joint_3.tau_max": 40.0}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "joints": ("planar_2r", {"run.duration": 0.4}),
    "around": ("planar_2r", {"run.duration": 0.2, "controller.motor_weights": 0.1} | AROUND),
    "laws": ("planar_2r", {"run.duration": 0.2, "muscles.cable_1.model": "ideal"}),
    "tasks": ("roboy_left_arm", {"run.duration": 0.2}),
    "tasks around": ("roboy_left_arm", {"run.duration": 0.2} | AROUND),
}
SPRING = {"kind": "passive_spring", "K": 40.0, "l0": 0.4}


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_loop_in_c_commands_motors(case: str) -> None:
    example, settings = CASES[case]
    settings = (ELBOW if example == "planar_2r" else HAND) | settings
    if case == "laws":
        settings |= {
            f"muscles.cable_{k}.model": {"kind": "elastic_cable", "stiffness": 2e3} for k in (2, 4)
        }
    recording = simulate(Experiment.load(EXAMPLES / example, settings), coupling="direct")
    (tau,) = (k for k, name in enumerate(recording.names) if name.startswith("tau."))
    assert np.abs(recording.rows[:, tau]).max() > 0.1


@pytest.mark.slow
def test_motor_is_an_additional_column_of_the_distribution() -> None:
    """F and tau have the minimum sum of squares of all solutions of -L'f + A tau."""
    settings = {"controller.motor_weights": 4.0, "robot.joints.joint_2.effort": 500.0}
    experiment = Experiment.load(PLANAR_2R, ELBOW | settings)
    result = simulate(experiment, compute="python", coupling="direct")
    column = dict(zip(result.names, result.rows.T, strict=True))
    robot = CoreDynamics(experiment.robot)
    free = 0
    for k in range(0, len(result.rows), 500):
        q = np.array([column["q.joint_1"][k], column["q.joint_2"][k]])
        f = np.array([column[f"f.cable_{i}"][k] for i in (1, 2, 3, 4)])
        y_elbow = 4.0 * column["tau.joint_2"][k]  # H x = A'y for values not at a limit
        L = robot.muscle_jacobian(q)
        inside = (f > 10.0 + 1e-6) & (f < 100.0 - 1e-6)
        free += inside.sum()
        if inside.sum() >= 2:
            y, *_ = np.linalg.lstsq(-L[inside], f[inside], rcond=None)
            np.testing.assert_allclose(y[1], y_elbow, rtol=1e-6, atol=1e-6)
    assert free


@pytest.mark.parametrize("seed", range(3))
def test_mujoco_simulates_the_same_motion(seed: int, tmp_path: Path) -> None:
    """Compare accelerations and 100 steps of the written MJCF file with motors and tendons."""
    robot = with_coordinates(random_tree(seed), actuated=True, tau_min=-9.0, tau_max=9.0)
    (file,) = write_mjcf(robot, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.timestep = 1e-3
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    order = [model.joint(c.name).dofadr[0] for c in robot.coordinates]
    rng = np.random.default_rng(seed)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, f, tau = rng.uniform(-0.5, 0.5, n), rng.uniform(5, 50, m), rng.uniform(-9, 9, n)
    data.qpos[order], data.ctrl[:m] = q, f
    data.ctrl[m:] = tau
    plant = Plant(robot, step=1e-3)
    plant.reset(q)
    for _ in range(100):
        mujoco.mj_step(model, data)
        plant.step(f, tau)
    np.testing.assert_allclose(plant.q, np.array(data.qpos)[order], atol=1e-9)
    np.testing.assert_allclose(plant.qd, np.array(data.qvel)[order], atol=1e-7)


def test_published_hybrid_robot_tracks(shared: Path, tmp_path: Path) -> None:
    """FASTKIT has two motor-driven mobile bases and a cable-driven platform."""
    folder = shared / "robots/caspr/FASTKIT_Planar"
    file = tmp_path / "experiment.toml"
    file.write_text(
        f"""
[robot]
path = "{folder}/FASTKIT_Planar_bodies.xml"
[reference]
trajectory = "line_test"
[controller]
kp = 400.0
kd = 40.0
[run]
step = 0.001
duration = 1.0
"""
    )
    result = simulate(Experiment.load(file), coupling="direct")
    column = dict(zip(result.names, result.rows.T, strict=True))
    assert not column["infeasible"].any()
    for name in column:
        if name.startswith("q."):
            assert np.abs(column[name] - column[f"q_d{name[1:]}"]).max() < 1e-5
    assert [name for name in column if name.startswith("tau.")] == [
        *("tau.joint_1_x", "tau.joint_1_y", "tau.joint_1_gamma", "tau.joint_2")
    ]


@pytest.mark.parametrize("dynamics", [CoreDynamics, DartDynamics])
@pytest.mark.parametrize("seed", range(3))
def test_dynamics_of_a_published_hybrid_robot_match_caspr(
    shared: Path, dynamics: Any, seed: int
) -> None:
    """Compare FASTKIT with CASPR's equation, derived from its XML by complex steps."""
    robot = read_robot(shared / "robots/caspr/FASTKIT_Planar")
    terms = dynamics(robot)
    rng = np.random.default_rng(seed)
    q, qd = (
        rng.uniform([-1, -1, -3, 2, 0.5, 0.2, -3], [1, 1, 3, 4, 2.5, 2.0, 3]),
        rng.normal(size=7),
    )
    np.testing.assert_allclose(terms.muscle_lengths(q), cable_lengths(q).real, rtol=0, atol=1e-10)
    L = slopes(cable_lengths, q)
    np.testing.assert_allclose(terms.muscle_jacobian(q), L, rtol=0, atol=1e-10)
    A = np.eye(7)[:, :4]
    np.testing.assert_array_equal(terms.actuation, A)
    np.testing.assert_allclose(terms.actuator_jacobian(q), np.vstack([L, -A.T]), atol=1e-10)
    J = slopes(lambda x: np.concatenate([p for p, _ in bodies(x)]), q)
    turns = np.zeros((9, 7))
    turns[[2, 5, 8], 2] = 1.0  # every body rotates with the first base
    c, s = np.cos(q[2]), np.sin(q[2])
    turns[6:8, 6] = -s, c  # the platform also rotates about the rotated y axis
    mass = np.kron(np.diag([10.0, 10.0, 1.0]), np.eye(3))
    yaw = np.diag([1.0, 1.0, 0.1])
    inertia = np.zeros((9, 9))
    inertia[:3, :3] = inertia[3:6, 3:6] = (
        yaw  # rotations are only about z, and the inertia is symmetric about z
    )
    inertia[6:, 6:] = 0.1 * np.eye(3)
    M = J.T @ mass @ J + turns.T @ inertia @ turns
    np.testing.assert_allclose(terms.mass_matrix(q), M, rtol=0, atol=1e-10)
    G = 9.81 * J.T @ mass @ np.tile([0.0, 0.0, 1.0], 3)
    np.testing.assert_allclose(terms.gravity(q), G, rtol=0, atol=1e-10)
    assert terms.coriolis(q, qd) @ qd == pytest.approx(power_of_velocity_terms(terms, q, qd))


def power_of_velocity_terms(terms: Any, q: Any, qd: Any) -> float:
    """Return C'qd = 1/2 qd'M' qd, since C only changes kinetic energy."""
    h = 1e-6
    ahead, behind = terms.mass_matrix(q + h * qd), terms.mass_matrix(q - h * qd)
    return 0.5 * qd @ (ahead - behind) @ qd / (2 * h)


def bodies(q: Any) -> list[tuple[Any, Any]]:
    """Return position and rotation of each centre of mass, from bodies.xml of FASTKIT."""
    x, y, turn, reach, px, pz, pitch = q
    c, s, cp, sp = np.cos(turn), np.sin(turn), np.cos(pitch), np.sin(pitch)
    Rz = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    base = np.array([x, y, 0])
    up = np.array([0, 0, 0.35])
    return [
        (base + up, Rz),
        (base + Rz @ np.array([reach, 0, 0]) + up, Rz),
        (base + Rz @ np.array([px, 0, pz]), Rz @ Ry),
    ]


def cable_lengths(q: Any) -> Any:
    """Return the cable lengths of FASTKIT; cables.xml defines ends relative to the joints."""
    lengths = []
    (one, R1), (two, R2), (platform, R3) = bodies(q)
    for (centre, R), height, end in [
        ((one, R1), 0.75, (-0.0612, 0, -0.0354)),
        ((one, R1), 2.0, (-0.0612, 0, 0.0354)),
        ((two, R2), 0.75, (0.0612, 0, -0.0354)),
        ((two, R2), 2.0, (0.0612, 0, 0.0354)),
    ]:
        start = centre + R @ np.array([0, 0, height - 0.35])
        d = platform + R3 @ np.array(end) - start
        lengths.append(np.sqrt(d @ d))
    return np.array(lengths)


def slopes(function: Any, q: Any) -> Any:
    """Return the derivative by complex steps."""
    steps = 1e-30j * np.eye(len(q))
    return np.array([function(q + step).imag / 1e-30 for step in steps]).T


@pytest.mark.slow
def test_required_effort_of_a_motor(pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The effort is the largest |J qdd + m g c cos(q)| of the motion plus 20 %."""
    load(pendulum, 50.0)
    assert main(["size", str(pendulum), "--json"]) == 0
    sizes = json.loads(capsys.readouterr().out)
    (row,) = sizes["motors"]
    s = np.linspace(0.0, 1.0, 501)
    q = 0.3 + 0.9 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    qdd = 0.9 / 0.25 * (60 * s - 180 * s**2 + 120 * s**3)
    peak = np.abs(J * qdd + MASS * GRAVITY * REACH * np.cos(q)).max()
    assert row["peak"] == pytest.approx(peak, rel=1e-9)
    assert row["needed_effort"] == pytest.approx(1.2 * peak, rel=1e-9)
    assert (row["unit"], sizes["muscles"], sizes["least_peak"]["force"]) == ("N.m", [], 0.0)
    assert main(["size", str(pendulum)]) == 0
    assert "required effort [N·m]" in capsys.readouterr().out


def test_motors_hold_an_arm_with_slack_cables() -> None:
    """The motors of planar_2r produce G(q)."""
    robot = with_coordinates(planar_2r(), actuated=True)
    terms = CoreDynamics(robot)
    np.testing.assert_array_equal(terms.actuation, np.eye(2))
    q = np.array([0.3, -0.4])
    plant = Plant(robot)
    plant.reset(q)
    for _ in range(20):
        plant.step(np.zeros(4), terms.gravity(plant.q))
    np.testing.assert_allclose(plant.q, q, atol=1e-14)


HARDWARE = {
    "hardware.use": True,
    "hardware.link": "emulated:",
    "hardware.mode": "lockstep",
    "hardware.ramp_in": 0.0,
}


@pytest.mark.slow
@pytest.mark.parametrize("command", ["force", "length"])
def test_hardware_with_motors_moves_like_the_plant(command: str, tmp_path: Path) -> None:
    """An emulated robot with the complete protocol moves like the plant and returns torques."""
    settings = ELBOW | {"run.duration": 0.2}
    plain = simulate(Experiment.load(PLANAR_2R, settings), compute="python", coupling="direct")
    if command == "length":
        settings |= {"hardware.motors": {"command": "length", "stiffness": 1e5}}
    driven = run(
        Experiment.load(PLANAR_2R, settings | HARDWARE),
        tmp_path / "out",
        compute="python",
        coupling="direct",
    )
    before, after = (dict(zip(r.names, r.rows.T, strict=True)) for r in (plain, driven))
    tau = after["tau.joint_2"]
    assert np.abs(tau).max() > 0.5
    assert driven.units["torque.joint_2"] == "N.m"
    if command == "force":
        np.testing.assert_allclose(after["torque.joint_2"][1:], tau[:-1], atol=1e-12)
        for name in ("q.joint_1", "q.joint_2", "tau.joint_2"):
            np.testing.assert_allclose(after[name], before[name], atol=1e-9)
    np.testing.assert_allclose(after["q.joint_2"], before["q.joint_2"], atol=1e-3)


def test_hardware_requires_torque_limits_of_motors() -> None:
    settings = {"robot.joints.joint_2.motor": True} | HARDWARE
    with pytest.raises(InputError, match=r"joint_2\.tau_max: missing; hardware requires"):
        simulate(Experiment.load(PLANAR_2R, settings), compute="python", coupling="direct")


def test_signature_of_devices_without_motors_is_unchanged() -> None:
    """Compute the signature by hand, as in docs/reference/hardware_protocol.md."""
    experiment = Experiment.load(PLANAR_2R)
    names = [c.name for c in experiment.robot.coordinates]
    commands = [[f"f.cable_{k}", "N"] for k in (1, 2, 3, 4)]
    states = [[f"q.{n}", "rad"] for n in names] + [[f"qd.{n}", "rad/s"] for n in names]
    states += [[f"l.cable_{k}", "m"] for k in (1, 2, 3, 4)]
    states += [[f"tension.cable_{k}", "N"] for k in (1, 2, 3, 4)]

    def signature() -> int:
        text = json.dumps(
            ["force", "0x1.0000000000000p+0", commands, states], separators=(",", ":")
        )
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")

    assert hardware_signature(experiment.robot, experiment.hardware) == signature()
    commands.append(["tau.joint_2", "N.m"])
    states.append(["torque.joint_2", "N.m"])
    hybrid = Experiment.load(PLANAR_2R, ELBOW)
    assert hardware_signature(hybrid.robot, hybrid.hardware) == signature()


@pytest.mark.slow
def test_results_include_motors(pendulum: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check text, summary, figures, replay page, and the scene with an arrow of length tau."""
    load(pendulum, "[-50.0, 60.0]")
    out = pendulum / "results"
    assert main(["run", str(pendulum), "-o", str(out)]) == 0
    assert "N.m, limits -50 to 60" in capsys.readouterr().out
    result = Result.load(out)
    tau = result["tau.q"]
    (row,) = result.summary["torques"]["per_motor"].values()
    assert row == {
        "min": tau.min(),
        "max": tau.max(),
        "tau_min": -50.0,
        "tau_max": 60.0,
        "unit": "N.m",
    }
    labels = [panel.label for panel in all_panels(result)["torques"]]
    assert labels == ["motor command [N.m]"]
    stage = Stage(result.experiment.robot, motion_of(result.experiment.robot, result))
    torques = stage.motion.torques
    assert torques is not None
    for k in (0, len(stage) // 2, len(stage) - 1):
        (arrow,) = [shape for shape in stage.scene(k) if shape.name == "forces/motor/q"]
        way = arrow.end - arrow.start
        part = torques[k, 0] / np.abs(torques).max()
        np.testing.assert_allclose(way, [0.0, -0.16 * stage.reach * part, 0.0], atol=1e-12)
        np.testing.assert_allclose(arrow.start, 0.0, atol=1e-12)
    page = pendulum / "page.html"
    assert main(["report", str(out), "-o", str(page)]) == 0
    assert "tau_max" in page.read_text()


def test_info_includes_motors(shared: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(shared / "robots/caspr/FASTKIT_Planar")]) == 0
    text = capsys.readouterr().out
    assert "4 muscles, 4 motors" in text
    assert "joint_1_gamma  -unlimited  unlimited  N·m" in text


@pytest.mark.slow
def test_published_hybrid_robot_is_checked_and_sized(
    shared: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = shared / "robots/caspr/FASTKIT_Planar"
    assert main(["check", str(folder), "--verbose"]) == 0
    assert capsys.readouterr().out.count("[no-motor-limit]") == 4
    file = tmp_path / "experiment.toml"
    assert main(["init", str(folder), "-o", str(file)]) == 0
    assert main(["size", str(file), "--json"]) == 0
    capsys.readouterr()


def test_custom_law_commands_motors(tmp_path: Path) -> None:
    """Forces and torques are in one vector and are clipped to their limits."""
    (tmp_path / "mine.py").write_text(
        """
import numpy as np
from controllers import JointSpaceController

class CustomLaw(JointSpaceController):
    def solve(self, q, qd, q_d, qd_d, qdd_d, **loads):
        return np.array([20.0, 20.0, 20.0, 20.0, 99.0])
"""
    )
    settings = ELBOW | {
        "controller.type": f"{tmp_path / 'mine.py'}:CustomLaw",
        "run.duration": 0.01,
        "reference.trajectory": "simple_joint_motion",
    }
    result = simulate(Experiment.load(PLANAR_2R, settings), compute="python", coupling="direct")
    assert (result["tau.joint_2"][1:] == 3.0).all()
    assert result["infeasible"][1:].all()
    assert result["slack.joint_2"][-1] == pytest.approx(96.0)
