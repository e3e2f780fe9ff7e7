"""Plants with muscle laws: states, tensions, initial states, and reachable tensions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.robots.plants import check_repeats, steps
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r, with_coordinates

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.model.muscle import CableKind, CableModel
from sim_dart import DartDynamics, MuscleDrive, Plant

every_engine = pytest.mark.usefixtures("every_engine")
WAYS: Any = [("core", "euler"), ("core", "rk4"), ("dart", "euler")]
"""Supported combinations of engine and integrator."""

HILL = {"max_isometric_force": 400.0, "fibre_damping": 0.1}
LIGAMENT = {"linear_stiffness": 300.0}


def with_law(robot: Robot, kind: CableKind, **parameters: float) -> Robot:
    """Return the robot with a muscle law, with lengths that match its initial pose."""
    lengths = DartDynamics(robot).muscle_lengths([c.initial for c in robot.coordinates])
    muscles = []
    for muscle, length in zip(robot.muscles, lengths.tolist(), strict=True):
        own = dict(parameters)
        if kind.startswith("hill"):
            own |= {"optimal_fibre_length": 0.5 * length, "tendon_slack_length": 0.5 * length}
        if kind.startswith("ligament"):
            own |= {"slack_length": 0.98 * length}
        if kind == "mckibben":
            own |= {"thread_length": 1.2 * length, "turns": 2.0}
        if kind == "series_elastic_motor":
            own |= {"rest_length": length}
        muscles.append(replace(muscle, model=CableModel(kind, tuple(own.items()))))
    return robot.with_muscles(muscles)


ROBOTS = {
    "elastic_cable": lambda: with_law(planar_2r(), "elastic_cable", stiffness=1e3, damping=5.0),
    "mckibben": lambda: with_law(planar_2r(), "mckibben"),
    "hill_degroote2016": lambda: with_law(planar_2r(), "hill_degroote2016", **HILL),
    "hill, elastic tendon": lambda: with_law(
        planar_2r(), "hill_millard2012", **HILL, elastic_tendon=1.0
    ),
    "series_elastic_motor": lambda: with_law(planar_2r(), "series_elastic_motor"),
    "ligament": lambda: with_law(planar_2r(), "ligament_blankevoort1991", **LIGAMENT),
}


def some_commands(plant: Plant) -> np.ndarray:
    """Return commands within their ranges that differ from the start commands."""
    rng = np.random.default_rng(3)
    kinds = {muscle.model.kind for muscle in plant.robot.muscles}
    scale = {"elastic_cable": 1.0, "mckibben": 1e3, "series_elastic_motor": 6.0}
    high = min(scale.get(kind, 1.0) for kind in kinds)
    if "elastic_cable" in kinds:
        return plant.commands * rng.uniform(0.97, 1.0, 4)
    return high * rng.uniform(0.1, 0.6, 4)


@every_engine
@pytest.mark.parametrize("name", ROBOTS)
def test_step_uses_the_reported_tensions(name: str) -> None:
    """Compare with qd+ = qd + h M^-1 (-L'f - C - G), with f at the beginning of the step."""
    robot, h = ROBOTS[name](), 1e-3
    plant, terms = Plant(robot, h), DartDynamics(robot)
    rng = np.random.default_rng(0)
    plant.reset(rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.5, 0.5, 2))
    for _ in range(20):
        u = some_commands(plant)
        plant.hold(u)
        q, qd, f = plant.q, plant.qd, plant.tensions
        plant.step(u)
        tau = -terms.muscle_jacobian(q).T @ f - terms.coriolis(q, qd) - terms.gravity(q)
        expected = qd + h * np.linalg.solve(terms.mass_matrix(q), tau)
        np.testing.assert_allclose(plant.qd, expected, rtol=1e-9, atol=1e-10)


@every_engine
def test_pressure_of_pneumatic_muscle_does_not_depend_on_the_motion() -> None:
    """The pressure is u + (p0 - u) exp(-t / tau) for any step."""
    robot = with_law(planar_2r(), "mckibben", pressure_time_constant=0.03)
    for plant, h, close in (
        (Plant(robot, 1e-3), 1e-3, 1e-12),
        (Plant(robot, 7e-3), 7e-3, 1e-12),
        (Plant(robot, 1e-3, integrator="rk4", engine="core"), 1e-3, 1e-7),
    ):
        p0, u = plant.muscle_states, np.array([1e3, 2e3, 3e3, 1e3])
        steps(plant, 40, u)
        expected = u + (p0 - u) * np.exp(-40 * h / 0.03)
        np.testing.assert_allclose(plant.muscle_states, expected, rtol=close)
        assert 1e-3 < np.abs(plant.q).max() < np.pi


@pytest.mark.parametrize(("engine", "integrator"), WAYS)
@pytest.mark.parametrize("name", ROBOTS)
def test_state_is_restored_bit_identically(name: str, engine: Any, integrator: Any) -> None:
    plant = Plant(ROBOTS[name](), 2e-4, integrator=integrator, energy=True, engine=engine)
    u = some_commands(plant)
    steps(plant, 20, u)
    check_repeats(plant, 20, u)


@pytest.mark.cases(7)
@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_both_integrators_compute_the_same_motion(name: str) -> None:
    """Both integrators solve the same equations of the muscle states."""
    ends = []
    for engine, integrator in WAYS:
        plant = Plant(ROBOTS[name](), 1e-4, integrator=integrator, engine=engine)
        u = some_commands(plant)
        steps(plant, 1000, u)
        ends.append(plant)
    core, rk4, dart = ends
    moved = max(np.abs(rk4.q).max(), 1e-3)
    for euler in (core, dart):
        np.testing.assert_allclose(euler.q, rk4.q, rtol=0, atol=0.02 * moved)
        np.testing.assert_allclose(euler.tensions, rk4.tensions, rtol=0.02, atol=0.05)


@every_engine
@pytest.mark.parametrize("name", [name for name in ROBOTS if name != "ligament"])
def test_muscles_start_at_rest_with_smallest_forces(name: str) -> None:
    robot = ROBOTS[name]()
    robot = robot.with_muscles([replace(muscle, f_min=12.5) for muscle in robot.muscles])
    plant = Plant(robot)
    np.testing.assert_allclose(plant.tensions, 12.5, rtol=1e-6)
    still = plant.muscle_states
    laws = plant._laws
    assert laws is not None
    laws.drive(np.zeros(2), plant.commands)
    laws.advance(plant.commands, 0.01)
    np.testing.assert_allclose(plant.muscle_states, still, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("elastic", [0.0, 1.0])
def test_nearest_reachable_tension_is_held(elastic: float) -> None:
    drive = MuscleDrive(with_law(planar_2r(), "hill_millard2012", **HILL, elastic_tendon=elastic))
    reach = drive.resting_reach(np.zeros(2))
    assert (reach.low > 0.0).all()
    assert (reach.low < reach.high).all()
    strong = drive.resting_commands(np.zeros(2), np.full(4, 1e6))
    np.testing.assert_allclose(strong, 1.0, rtol=1e-9)
    np.testing.assert_allclose(drive.resting_commands(np.zeros(2), np.zeros(4)), 0.0, atol=1e-9)


@every_engine
def test_passive_muscles_ignore_commands() -> None:
    robot = ROBOTS["ligament"]()
    plant, same = Plant(robot), Plant(robot)
    for _ in range(50):
        plant.step(np.zeros(4))
        same.step([1.0, 1e9, -5.0, 3.0])
    np.testing.assert_array_equal(plant.get_state(), same.get_state())
    assert plant.tensions.max() > 0.0


@every_engine
def test_ideal_cables_next_to_other_laws_have_the_commanded_tension() -> None:
    robot = ROBOTS["elastic_cable"]()
    first, *others = robot.muscles
    plant = Plant(robot.with_muscles([replace(first, model=CableModel()), *others]))
    u = plant.commands
    for force in (30.0, -4.0):
        u[0] = force
        plant.step(u)
        assert plant.tensions[0] == max(force, 0.0)
    assert plant.muscle_state_names == ()


@every_engine
def test_ideal_cables_with_and_without_laws_are_equal() -> None:
    """Compare the code path of the core without laws with the path with laws."""
    robot = random_robot(4, joints=4, muscles=5)
    law = CableModel("ligament_blankevoort1991", (("linear_stiffness", 0.0), ("slack_length", 1.0)))
    slack = replace(robot.muscles[0], name="slack", model=law)
    alone, among = Plant(robot), Plant(robot.with_muscles([*robot.muscles, slack]))
    f = np.random.default_rng(0).uniform(-5.0, 30.0, 5)
    for _ in range(100):
        alone.step(f)
        among.step([*f, 0.0])
    np.testing.assert_array_equal(alone.q, among.q)
    np.testing.assert_array_equal(alone.tensions, np.maximum(f, 0.0))


@every_engine
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_commands_that_are_not_finite_are_rejected(bad: float) -> None:
    plant = Plant(ROBOTS["mckibben"]())
    before = plant.get_state()
    for integrator_plant in (plant, Plant(plant.robot, integrator="rk4", engine="core")):
        with pytest.raises(InputError, match=r"cable_2.*not finite"):
            integrator_plant.step([0.0, bad, 0.0, 0.0])
    np.testing.assert_array_equal(plant.get_state(), before)
    with pytest.raises(InputError, match="finite"):
        plant.reset(commands=[0.0, bad, 0.0, 0.0])


@every_engine
def test_muscle_state_that_is_not_finite_is_rejected() -> None:
    plant = Plant(ROBOTS["mckibben"]())
    state = plant.get_state()
    state[-1] = np.nan
    with pytest.raises(InputError, match="states must be finite"):
        plant.set_state(state)


def test_explicit_rule_diverges_with_a_fast_motor() -> None:
    """With a time constant of 0.2 ms, a step of 10 ms is unstable, except with euler."""
    robot = ROBOTS["series_elastic_motor"]()
    plant = Plant(robot, 1e-2, integrator="rk4")
    with pytest.raises(SimulationError, match=r"robot .* diverged at t = .* s: .* is "):
        steps(plant, 2000, np.full(4, 3.0))
    steady = Plant(robot, 1e-2)
    steps(steady, 100, np.full(4, 0.1))
    assert np.isfinite(steady.get_state()).all()


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_elastic_cables_do_not_add_energy(damping: float) -> None:
    """The total energy never increases, and is constant without damping."""
    robot = with_law(planar_2r(), "elastic_cable", stiffness=300.0, damping=damping)
    plant = Plant(
        with_coordinates(robot, lower=-9.0, upper=9.0), 2e-4, integrator="rk4", energy=True
    )
    plant.reset([2.6, 0.3])
    u = plant.muscle_lengths - 0.02

    def stored() -> float:
        stretch = np.maximum(plant.muscle_lengths - u, 0.0)
        return float(plant.energy.kinetic + plant.energy.potential + 150.0 * stretch @ stretch)

    levels = [stored()]
    for _ in range(2000):
        plant.step(u)
        levels.append(stored())
    assert np.diff(levels).max() < 1e-7
    if damping:
        assert levels[-1] < levels[0] - 0.01
    else:
        assert levels[-1] == pytest.approx(levels[0], abs=1e-4)


@every_engine
@pytest.mark.parametrize(
    "name", ["mckibben", "hill_degroote2016", "hill, elastic tendon", "series_elastic_motor"]
)
def test_muscle_drive_commands_reach_the_desired_tensions(name: str) -> None:
    """Tensions between the ends of the reach are obtained after the time.

    Links are heavy, since the drive uses the old path velocity and the plant the new one.
    """
    robot, h = ROBOTS[name](), 1e-3
    robot = robot.with_muscles([replace(muscle, f_min=15.0) for muscle in robot.muscles])
    heavy = [replace(link, inertia=link.inertia.scaled(1e5)) for link in robot.links]
    robot = replace(robot, links=tuple(heavy), gravity=(0.0, 0.0, 0.0))
    plant, drive = Plant(robot, h), MuscleDrive(robot)
    rng = np.random.default_rng(1)
    for _ in range(30):
        drive.set_state(plant.q, plant.qd, plant.muscle_states)
        low, high = drive.reach(h)
        assert (low <= high).all()
        desired = low + rng.uniform(0.2, 0.8, 4) * (high - low)
        u = drive.commands(desired, h)
        plant.step(u)
        np.testing.assert_allclose(plant.tensions, desired, rtol=1e-5, atol=1e-3)


def test_muscle_drive_rejects_invalid_states() -> None:
    drive = MuscleDrive(ROBOTS["mckibben"]())
    with pytest.raises(InputError, match="states must have shape"):
        drive.set_state(np.zeros(2), np.zeros(2), np.zeros(3))
    with pytest.raises(InputError, match=r"pressure.cable_2.*not finite"):
        drive.set_state(np.zeros(2), np.zeros(2), [0.0, np.nan, 0.0, 0.0])
