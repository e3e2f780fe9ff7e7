"""Emulated robot: states of the plant, and errors of motors and sensors of known size."""

from __future__ import annotations

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.experiment.settings.hardware import CommandKind, EmulatorSettings, MotorSettings
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds
from cardsflow_fmu.hardware.session.motors import MotorMap
from cardsflow_fmu.simulation.run import simulate
from controllers import SpringMotors

STEP = 1e-3
N, M = 2, 4
PULL = np.array([30.0, 12.0, 25.0, 11.0])


@cache
def simulated(name: str, changes: tuple[tuple[str, object], ...]) -> Result:
    settings: dict[str, object] = {}
    for key, value in changes:
        settings[key] = dict(value) if isinstance(value, tuple) else value
    return simulate(Experiment.load(EXAMPLES / name, settings), coupling="direct")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("planar_2r", (("run.duration", 0.4),)),
        ("planar_2r", (("run.duration", 0.4), ("plant.step", 2.5e-4))),
        ("planar_2r", (("run.duration", 0.3), ("plant.mass_scale", 1.3))),
        (
            "roboy_left_arm",
            (
                ("run.duration", 0.3),
                ("disturbance.force", (("hand", (3.0, -4.0, 5.0)),)),
                ("disturbance.begin", 0.083),
                ("disturbance.end", 0.211),
            ),
        ),
    ],
)
def test_an_ideal_emulated_robot_has_the_states_of_the_plant(
    name: str, changes: tuple[tuple[str, object], ...]
) -> None:
    """The states are bit-identical with the forces, masses and disturbance of a simulation."""
    result = simulated(name, changes)
    experiment = result.experiment
    robot = experiment.robot
    emulated = EmulatedRobot.from_experiment(experiment)
    names = [
        *coordinate_signals("q", robot),
        *coordinate_signals("qd", robot),
        *muscle_signals("l", robot),
    ]
    expected = result.columns(names)
    forces = result.columns(muscle_signals("f", robot))
    np.testing.assert_array_equal(emulated.state()[: len(names)], expected[0])
    for force, row in zip(forces, expected[1:], strict=False):
        emulated.apply(force)
        emulated.advance(experiment.run.step)
        state = emulated.state()
        np.testing.assert_array_equal(state[: len(names)], row)
        np.testing.assert_allclose(state[len(names) :], force, rtol=0, atol=1e-9)


def test_a_new_run_begins_in_the_start_state() -> None:
    emulated = EmulatedRobot.from_experiment(
        Experiment.load(PLANAR_2R), EmulatorSettings(motor_lag=0.01)
    )
    runs = []
    for _ in range(2):
        emulated.reset()
        rows = [emulated.state()]
        for _ in range(20):
            emulated.apply(PULL)
            emulated.advance(STEP)
            rows.append(emulated.state())
        runs.append(rows)
    np.testing.assert_array_equal(runs[0], runs[1])
    np.testing.assert_array_equal(runs[0][0][:2], [-0.5, 0.5])


def test_the_remainder_of_a_time_beyond_whole_steps_is_kept() -> None:
    emulated = EmulatedRobot(planar_2r(), STEP)
    for _ in range(1000):
        emulated.advance(0.7e-3)
    assert emulated.plant.time == pytest.approx(0.7, abs=STEP)


@pytest.mark.slow
@given(
    kind=st.sampled_from(["force", "length", "velocity"]),
    lag=st.sampled_from([0.0, 0.004]),
    data=st.data(),
)
def test_tensions_stay_within_limits_for_any_command(
    kind: str, lag: float, data: st.DataObject
) -> None:
    robot = planar_2r()
    f_min, f_max = actuator_bounds(robot)
    emulated = EmulatedRobot(
        robot, STEP, motors=MOTORS[kind], emulator=EmulatorSettings(motor_lag=lag)
    )
    numbers = st.floats(-1e6, 1e6)
    for _ in range(5):
        command = np.array(data.draw(st.lists(numbers, min_size=M, max_size=M)))
        emulated.apply(command)
        emulated.advance(STEP)
        tension = emulated.state()[2 * N + M :]
        assert np.all(tension >= (f_min if kind == "force" else 0.0))
        assert np.all(tension <= f_max)


STIFFNESS, DAMPING = (5e3,) * M, (20.0,) * M
MOTORS = {
    "force": MotorSettings(),
    "length": MotorSettings(command="length", stiffness=STIFFNESS, damping=DAMPING),
    "velocity": MotorSettings(command="velocity", stiffness=STIFFNESS, damping=DAMPING),
}


def springs() -> SpringMotors:
    return SpringMotors([m.name for m in planar_2r().muscles], STIFFNESS, damping=DAMPING)


def test_motors_follow_with_their_time_constant() -> None:
    """f(t) = f_min + (u - f_min)(1 - exp(-t/T))."""
    emulated = EmulatedRobot(planar_2r(), STEP, emulator=EmulatorSettings(motor_lag=0.02))
    f_min = emulated.tension
    emulated.apply(PULL)
    for k in range(1, 60):
        emulated.advance(STEP)
        expected = f_min + (PULL - f_min) * -math.expm1(-k * STEP / 0.02)
        np.testing.assert_allclose(emulated.tension, expected, rtol=1e-12)


def test_motors_with_length_commands_have_the_spring_forces() -> None:
    """The forces are f = K (l - l0) + D l'; the initial l0 results in the initial tension."""
    motors = springs()
    start = {"q": [0.1, 0.2], "qd": [0.3, -0.4]}
    emulated = EmulatedRobot(planar_2r(), STEP, **start, motors=MOTORS["length"])
    plant = emulated.plant
    for _ in range(50):
        rates = plant.muscle_jacobian @ plant.qd
        lengths = plant.muscle_lengths
        emulated.apply(motors.set_points(lengths, rates, PULL))
        emulated.advance(STEP)
        np.testing.assert_allclose(emulated.tension, PULL, rtol=1e-9)
    assert np.abs(plant.qd).max() > 0.1


def test_motors_with_velocity_commands_equal_those_with_length_commands() -> None:
    """Commands with the rates of l0 have the same effect as commands with l0."""
    robot = planar_2r()
    by_length = EmulatedRobot(robot, STEP, q=[0.1, 0.2], motors=MOTORS["length"])
    by_rate = EmulatedRobot(robot, STEP, q=[0.1, 0.2], motors=MOTORS["velocity"])
    motors = springs()
    l0 = motors.set_points(by_length.plant.muscle_lengths, np.zeros(M), by_length.tension)
    rng = np.random.default_rng(1)
    for _ in range(100):
        rate = rng.uniform(-0.1, 0.1, M)
        l0 = l0 + rate * STEP
        by_length.apply(l0)
        by_rate.apply(rate)
        for emulated in (by_length, by_rate):
            emulated.advance(STEP)
        np.testing.assert_allclose(by_rate.state(), by_length.state(), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("command", ["length", "velocity"])
@pytest.mark.parametrize("radius", [(), (0.01, 0.02, 0.03, 0.04)])
@pytest.mark.parametrize("scale", [(), (4096.0, 100.0, 1e5, 1.0)])
@pytest.mark.parametrize("offset", [None, (), (0.3, 0.1, 0.2, -0.1)])
def test_emulated_motors_are_the_inverse_of_the_motor_map(
    command: CommandKind, radius: tuple, scale: tuple, offset: tuple | None
) -> None:
    """Commands for given forces result in these forces."""
    settings = MotorSettings(
        command=command,
        stiffness=STIFFNESS,
        damping=DAMPING,
        spindle_radius=radius,
        encoder_scale=scale,
        offset=offset,
    )
    robot = planar_2r()
    emulated = EmulatedRobot(robot, STEP, q=[0.1, 0.2], qd=[0.3, -0.4], motors=settings)
    plant = emulated.plant
    rates = plant.muscle_jacobian @ plant.qd
    motors = MotorMap(settings, [m.name for m in robot.muscles])
    motors.calibrate(plant.muscle_lengths, rates, emulated.tension)
    for k in range(30):
        desired = PULL + 5.0 * math.sin(k)
        rates = plant.muscle_jacobian @ plant.qd
        arguments = (desired, plant.muscle_lengths, rates, emulated.tension, STEP)
        if command == "velocity":  # the correction of l0 uses tensions of the previous step
            arguments = (desired, plant.muscle_lengths, rates, np.zeros(0), STEP)
        emulated.apply(motors.commands(*arguments))
        emulated.advance(STEP)
        np.testing.assert_allclose(emulated.tension, desired, rtol=1e-8)


def test_states_do_not_contain_quantities_that_are_not_measured() -> None:
    for positions, lengths, tensions in product((False, True), repeat=3):
        emulated = EmulatedRobot(
            planar_2r(),
            STEP,
            q=[0.1, 0.2],
            has_positions=positions,
            has_lengths=lengths,
            has_tensions=tensions,
        )
        plant = emulated.plant
        parts = [plant.q, plant.qd] if positions else []
        parts += [plant.muscle_lengths] if lengths else []
        parts += [emulated.tension] if tensions else []
        np.testing.assert_array_equal(emulated.state(), np.concatenate([[], *parts]))
        assert emulated.states == sum(map(len, parts))


@pytest.mark.parametrize("kind", ["force", "length", "velocity"])
def test_the_safe_state_has_the_minimum_tension(kind: str) -> None:
    robot = planar_2r()
    f_min, _ = actuator_bounds(robot)
    emulated = EmulatedRobot(robot, STEP, motors=MOTORS[kind])
    emulated.apply(np.full(M, 0.05))
    emulated.advance(STEP)
    emulated.safe()
    emulated.advance(STEP)
    np.testing.assert_array_equal(emulated.tension, f_min)
    slack = EmulatedRobot(robot, STEP, safe_forces=0.0)
    slack.advance(STEP)
    np.testing.assert_array_equal(slack.tension, np.zeros(M))


def read(sensors: EmulatorSettings, steps: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Return measurements of a motion and true values, as rows of q, qd and l."""
    robot = planar_2r()
    pair = [EmulatedRobot(robot, STEP, q=[0.1, 0.2], emulator=s) for s in (sensors, None)]
    rows: list[list[np.ndarray]] = [[e.state()[: 2 * N + M]] for e in pair]
    for k in range(steps):
        command = PULL if (k // 40) % 2 else PULL[::-1]
        for emulated, own in zip(pair, rows, strict=True):
            emulated.apply(command)
            emulated.advance(STEP)
            own.append(emulated.state()[: 2 * N + M])
    return np.array(rows[0]), np.array(rows[1])


def test_encoders_quantise() -> None:
    joint, length = 2000.0, 50e3
    readings, true = read(EmulatorSettings(joint_counts=joint, length_counts=length))
    for columns, counts in ((slice(0, N), joint), (slice(2 * N, None), length)):
        counted = readings[:, columns] * counts
        np.testing.assert_allclose(counted, np.round(counted), rtol=0, atol=1e-6)
        error = np.abs(readings - true)[:, columns].max()
        assert 0.25 / counts < error <= 0.5 / counts * (1 + 1e-9)
    np.testing.assert_array_equal(readings[:, N : 2 * N], true[:, N : 2 * N])


def test_counts_finer_than_float_precision_have_no_effect() -> None:
    readings, true = read(EmulatorSettings(joint_counts=1e308, length_counts=1e308))
    np.testing.assert_allclose(readings, true, rtol=1e-15)


def test_lengths_have_offsets() -> None:
    """The other measurements have no offsets."""
    offsets = (1e-3, 0.0, -2e-3, 5e-4)
    readings, true = read(EmulatorSettings(length_offset=offsets))
    np.testing.assert_allclose((readings - true)[:, 2 * N :], [offsets] * len(true), atol=1e-15)
    np.testing.assert_array_equal(readings[:, : 2 * N], true[:, : 2 * N])
    with pytest.raises(InputError, match="length_offset must be 4 numbers, not 1"):
        EmulatedRobot(planar_2r(), STEP, emulator=EmulatorSettings(length_offset=(1e-3,)))


def test_velocities_may_be_finite_differences_of_counts() -> None:
    """The error is at most one count per step, plus half a step of acceleration."""
    counts = 1e5
    readings, true = read(EmulatorSettings(joint_counts=counts, differentiate_positions=True))
    q, qd = readings[:, :N], readings[:, N : 2 * N]
    np.testing.assert_allclose(qd[1:], np.diff(q, axis=0) / STEP, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(qd[0], 0.0)
    change = np.abs(np.diff(true[:, N : 2 * N], axis=0))
    error = np.abs(qd - true[:, N : 2 * N])[1:]
    assert np.all(error <= 1 / (counts * STEP) + change + 1e-9)


@pytest.mark.slow
def test_noise_has_the_specified_size_and_depends_on_the_seed() -> None:
    readings, true = read(EmulatorSettings(noise=2e-3, seed=5), 1000)
    again, _ = read(EmulatorSettings(noise=2e-3, seed=5), 1000)
    other, _ = read(EmulatorSettings(noise=2e-3, seed=6), 1000)
    noise = (readings - true).ravel()
    assert np.std(noise) == pytest.approx(2e-3, rel=0.05)
    assert abs(np.mean(noise)) < 4 * 2e-3 / math.sqrt(noise.size)
    np.testing.assert_array_equal(readings, again)
    assert np.abs(readings - other).min() > 0
