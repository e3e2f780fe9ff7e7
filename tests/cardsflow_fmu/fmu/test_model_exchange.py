"""Plants for model exchange: closed forms, the Runge-Kutta plant, and least constraint."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.optimize import lsq_linear
from support.fmu.exchange_host import ExchangeHost, continuous_plant, exchanging
from support.fmu.native_slopes import stretched
from support.robots.loops import four_bar
from support.robots.muscle_bench import slider
from support.robots.random_robots import random_tree
from support.robots.robots import with_coordinates

from addin_sdfusion.robot import InputError, Robot, prismatic
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build
from sim_dart import CoreDynamics, Plant, compile_blob
from sim_dart.core.library import Core

native = pytest.mark.native
FMI = ("2.0", "3.0")

TIGHT = 1e-12
G = 9.81


def cvode(file: Path, stop: float, names: list[str], **options: Any) -> Any:
    """Return the result of FMPy's CVode."""
    given = {"relative_tolerance": TIGHT, "output_interval": stop / 50, **options}
    return fmpy.simulate_fmu(
        str(file), stop_time=stop, output=names, fmi_type="ModelExchange", **given
    )


def falling(upper: float = math.inf) -> Robot:
    """Return a mass of 1 kg with a motor that slides along z above a stop at 0."""
    robot = slider(("ideal", {}))
    (joint,) = robot.joints
    (slide,) = joint.coordinates
    made = replace(slide, lower=0.0, upper=upper, actuated=True)
    moved = replace(joint, motions=prismatic((0.0, 0.0, 1.0)), coordinates=(made,))
    return replace(robot, joints=(moved,))


def pendulums(seed: int, limit: float = math.inf, damping: float = 0.0) -> Robot:
    """Return a random tree with equal limits of all coordinates."""
    robot = random_tree(seed, damping=damping)
    joints = (
        replace(
            joint,
            coordinates=tuple(replace(c, lower=-limit, upper=limit) for c in joint.coordinates),
        )
        for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


def test_mass_falls_rests_and_is_lifted_at_the_times_of_closed_forms(
    tmp_path: Path, fmi: str
) -> None:
    """It stops without bouncing, and leaves when the force exceeds its weight."""
    file = continuous_plant(falling(), tmp_path, [1.0], [0.0], fmi=fmi, arrays=False, energy=True)
    assert not validate_fmu(str(file))
    down, up = math.sqrt(2 / G), G / 10
    force = np.array([(0.0, 0.0), (2.0, 20.0)], dtype=[("time", float), ("tau.slide", float)])
    names = ["q.slide", "qd.slide", "energy.kinetic"]
    found = cvode(file, 0.7, names, record_events=True)
    (event,) = found["time"][:-1][np.diff(found["time"]) == 0]
    assert event == pytest.approx(down, rel=0, abs=1e-9)
    late = found["time"] > event
    assert (found["q.slide"][late] == 0).all()
    assert (found["qd.slide"][late] == 0).all()
    # FMPy updates inputs between steps only, so that the motion after the event is inaccurate.
    begin, loose = {"q_start.slide": 0.0}, {"relative_tolerance": 1e-3, "record_events": True}
    found = cvode(file, 1.0, names, start_values=begin, input=force, **loose)
    (event,) = found["time"][:-1][np.diff(found["time"]) == 0]
    assert event == pytest.approx(up, rel=0, abs=1e-9)
    rests = found["time"] <= event
    assert (found["q.slide"][rests] == 0).all()
    assert (found["q.slide"][~rests][1:] > 0).all()


@pytest.mark.parametrize("seed", [3, 7])
def test_solver_agrees_with_runge_kutta_plant(tmp_path: Path, fmi: str, seed: int) -> None:
    robot = pendulums(seed, damping=0.3)
    rng = np.random.default_rng(seed)
    d = CoreDynamics(robot)
    q, qd, f = rng.uniform(-1, 1, d.n), rng.uniform(-1, 1, d.n), rng.uniform(1, 9, d.m)
    plant = Plant(robot, 2.5e-4, integrator="rk4")
    plant.reset(q, qd)
    for _ in range(800):
        plant.step(f)
    file = continuous_plant(robot, tmp_path, q, qd, fmi=fmi, arrays=False)
    names = [f"q.{c.name}" for c in robot.coordinates] + [f"qd.{c.name}" for c in robot.coordinates]
    start = {f"f.{m.name}": value for m, value in zip(robot.muscles, f, strict=True)}
    last = cvode(file, 0.2, names, start_values=start)[-1]
    expected = np.concatenate([plant.q, plant.qd])
    np.testing.assert_allclose([last[name] for name in names], expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", ["hill_arm", "pneumatic_elbow", "bicycle"])
def test_muscle_states_agree_with_runge_kutta_plant(tmp_path: Path, name: str) -> None:
    """States of muscles and closed loops, with other commands than those of the start."""
    settings = {"plant.integrator": "rk4", "plant.substeps": 10}
    experiment = Experiment.load(f"examples/{name}", settings)
    plant = PlantModel(experiment)
    names = [port.name for port in plant.ports]
    commands = [i for i, port in enumerate(plant.ports) if port.name[:2] in ("u.", "f.")]
    plant.values[commands] = 1.3 * plant.values[commands] + 0.01
    plant.initialize()
    plant.step(0.0, 0.1)
    file = build(experiment, tmp_path / "fmus", kind="me")["plant"]
    given = dict(zip((names[i] for i in commands), plant.values[commands], strict=True))
    states = [names[i] for i in plant.indices("q", "qd", "states")]
    last = cvode(file, 0.1, states, start_values=given)[-1]
    expected = plant.values[plant.indices("q", "qd", "states")]
    scale = np.maximum(np.abs(expected), 1.0)
    assert (np.abs([last[n] for n in states] - expected) <= 1e-8 * scale).all()


@native
def test_energy_and_work_balance(tmp_path: Path) -> None:
    """Work is a state, so that a solver integrates it with the motion."""
    robot = pendulums(5, damping=0.2)
    d = CoreDynamics(robot)
    rng = np.random.default_rng(5)
    q, qd = rng.uniform(-1, 1, d.n), rng.uniform(-1, 1, d.n)
    file = continuous_plant(robot, tmp_path, q, qd, energy=True)
    parts = ["energy.kinetic", "energy.potential"]
    works = ["work.muscles", "work.outside", "work.damping"]
    start = {f"f.{m.name}": 5.0 for m in robot.muscles}
    found = cvode(file, 0.2, [*parts, *works], start_values=start)
    total = sum(found[name] for name in parts) - sum(found[name] for name in works)
    scale = max(np.ptp(found[name]) for name in parts)
    assert scale > 0.1
    assert np.abs(found["work.damping"]).max() > 1e-3
    assert np.abs(total - total[0]).max() < 1e-8 * scale


@native
@pytest.mark.parametrize("seed", range(4))
def test_event_stops_and_holds_by_least_constraint(tmp_path: Path, seed: int) -> None:
    """Impulses and forces of limits satisfy Gauss's principle."""
    limit = 0.3
    robot = pendulums(seed, limit)
    rng = np.random.default_rng(seed)
    d = CoreDynamics(robot)
    q, qd = rng.uniform(-0.2, 0.2, d.n), rng.uniform(-1, 1, d.n)
    at = rng.permutation(d.n)[: max(2, d.n // 2)]
    q[at] = np.sign(qd[at]) * limit
    under, over = q == -limit, q == limit
    low, high = np.where(under, 0.0, -np.inf), np.where(over, 0.0, np.inf)
    M = d.mass_matrix(q)
    with exchanging(continuous_plant(robot, tmp_path, q, qd), tmp_path / "u") as host:
        x = host.x
        after = least_constraint(M, qd, low, high)
        np.testing.assert_allclose(x[: d.n], q, rtol=0, atol=0)
        np.testing.assert_allclose(x[d.n :], after, rtol=0, atol=1e-9 * np.abs(qd).max())
        rests = (x[d.n :] == 0) & (under | over)
        assert rests.any()
        assert not host.event()
        free = np.linalg.solve(M, -(d.coriolis(q, x[d.n :]) + d.gravity(q)))
        low, high = np.where(under & rests, 0.0, -np.inf), np.where(over & rests, 0.0, np.inf)
        expected = least_constraint(M, free, low, high)
        scale = np.abs(free).max()
        np.testing.assert_allclose(host.dx[d.n :], expected, rtol=0, atol=1e-8 * scale)
        assert (host.z >= 0).all()


def least_constraint(M: Any, free: Any, low: Any, high: Any) -> Any:
    """Return the rates within the bounds that minimise (v - free)' M (v - free)."""
    root = np.linalg.cholesky(M).T
    bounds = low, np.maximum(high, low + 1e-300)
    return lsq_linear(root, root @ free, bounds, method="bvls", tol=1e-14).x


@native
def test_derivatives_are_exact_also_in_a_hold_phase(tmp_path: Path, fmi: str) -> None:
    """Directional derivatives of state derivatives, event indicators and outputs."""
    robot, limit = pendulums(1, 0.3, damping=0.2), 0.3
    rng = np.random.default_rng(1)
    d = CoreDynamics(robot)
    q, qd = rng.uniform(-0.2, 0.2, d.n), rng.uniform(-1, 1, d.n)
    q[:2] = np.sign(qd[:2]) * limit
    file = continuous_plant(robot, tmp_path, q, qd, fmi=fmi, arrays=False, energy=True)
    with exchanging(file, tmp_path / "u") as host:
        states = [name[4:-1] for name in host.references if name.startswith("der(")]
        forces = [name for name in host.references if name.startswith("f.")]
        indicators = [name for name in host.references if name.startswith("event.")]
        outputs = [name for name in host.references if name.startswith(("l.", "energy."))]
        unknowns = [*(f"der({name})" for name in states), *indicators, *outputs]
        at = np.concatenate([host.x, np.full(len(forces), 4.0)])
        held = (host.dx[: d.n] == 0) & (np.abs(host.x[: d.n]) == limit)
        assert held.any()

        def evaluate(values: Any) -> Any:
            host.x = values[: host.nx]
            host.set(
                **dict(zip((f.replace(".", "_") for f in forces), values[host.nx :], strict=True))
            )
            return host.get(*unknowns)

        direction = rng.uniform(-1, 1, at.size)
        direction[: d.n][held] = 0
        expected = stretched(evaluate, at, direction, 1e-3)
        evaluate(at)
        references = [host.references[name] for name in unknowns]
        knowns = [host.references[name] for name in [*states, *forces]]
        found = host.model.getDirectionalDerivative(references, knowns, list(direction))
        scale = 1e-8 * np.abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=scale)
        assert (np.array(found)[: d.n][held] == 0).all()


@native
def test_loops_stay_closed_and_keep_their_energy(tmp_path: Path) -> None:
    robot = four_bar()
    d = CoreDynamics(robot)
    q = [c.initial for c in robot.coordinates]
    file = continuous_plant(robot, tmp_path, q, [0.0] * d.n, energy=True)
    names = [f"q.{c.name}" for c in robot.coordinates]
    parts = ["energy.kinetic", "energy.potential"]
    found = cvode(file, 2.0, [*names, *parts], relative_tolerance=1e-9)
    total = sum(found[name] for name in parts)
    assert np.ptp(found["energy.kinetic"]) > 0.1
    assert np.abs(total - total[0]).max() < 1e-6 * np.ptp(found["energy.kinetic"])
    core = Core(compile_blob(robot))
    gaps = []
    for row in found:
        core.move(core.handle, np.array([row[name] for name in names]).tobytes())
        core.closures(core.handle, np.zeros(d.n).tobytes())
        gaps.append(np.abs(core.array("closure_gap", 5)).max())
    assert max(gaps) < 2e-8


@native
def test_restored_state_repeats_a_hold_phase(tmp_path: Path, fmi: str) -> None:
    file = continuous_plant(falling(), tmp_path, [0.0], [-1.0], fmi=fmi, arrays=False)
    with exchanging(file, tmp_path / "u") as host:
        is_2 = host.is_2
        model = host.model
        assert host.x[1] == 0
        assert host.dx[1] == 0
        assert host.z[0] == pytest.approx(G, abs=1e-9)
        saved = model.getFMUstate() if is_2 else model.getFMUState()
        host.set(tau_slide=20.0)
        assert host.z[0] == pytest.approx(G - 20)
        assert not host.event()
        assert host.dx[1] == pytest.approx(20 - G)
        (model.setFMUstate if is_2 else model.setFMUState)(saved)
        assert host.dx[1] == 0
        assert host.z[0] == pytest.approx(G, abs=1e-9)
        host.set(tau_slide=20.0)
        assert host.dx[1] == 0, "the coordinate is held until the event"
        enter, _ = model.completedIntegratorStep()
        assert enter


@native
def test_states_beyond_all_bounds_are_discarded(tmp_path: Path) -> None:
    """A solver can use a smaller step."""
    with exchanging(continuous_plant(falling(), tmp_path, [1.0], [0.0]), tmp_path / "u") as host:
        good = host.x
        host.x = np.array([np.nan, 0.0])
        with pytest.raises(Exception, match="GetDerivatives") as caught:
            _ = host.dx
        assert caught.value.status == 2, "fmi2Discard"
        host.x = good
        assert host.dx[1] == pytest.approx(-G)


@native
def test_instances_do_not_leak(tmp_path: Path) -> None:
    """The memory of the process does not grow over 1,000 instances."""
    robot = pendulums(3, 0.3)
    rest = [0.0] * len(robot.coordinates)
    file = continuous_plant(robot, tmp_path, rest, rest)
    host = ExchangeHost(file, tmp_path / "u")

    def cycle(count: int) -> int:
        for _ in range(count):
            host.model.fmi2FreeInstance(host.model.component)
            host.start()
            host.update()
            host.model.enterContinuousTimeMode()
            host.x = host.x + 1e-3 * host.dx
        pages = Path("/proc/self/statm").read_text().split()[1]
        return int(pages)

    if "CARDSFLOW_LIBRARY_DIR" in os.environ:  # sanitizers keep freed memory
        cycle(20)
    else:
        before = cycle(200)
        assert cycle(1000) - before < 64
    host.close()


def test_command_builds_a_valid_plant(
    tmp_path: Path, fmi: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["build", "examples/hill_arm", "--kind", "me", "--fmi", fmi, "-o", str(tmp_path)]
    assert main(options) == 0
    out, err = capsys.readouterr()
    assert out.split() == [str(tmp_path / "plant.fmu")]
    assert "model exchange" in err
    assert not validate_fmu(str(tmp_path / "plant.fmu"))
    description = fmpy.read_model_description(str(tmp_path / "plant.fmu"))
    assert description.coSimulation is None
    exchange = description.modelExchange  # FMPy reads this attribute in FMI 2.0 only
    assert fmi == "3.0" or exchange.providesDirectionalDerivative


UNSUPPORTED = {
    "hill_arm": ({"plant.engine": "dart"}, 'the engine "dart"'),
    "pick_up": ({}, "worlds with contacts"),
    "planar_2r": ({"friction": 0.1}, "Coulomb friction (of joint_1"),
    "cable_robot": ({"plant.break_time": 1.0}, "breaking cables"),
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_unsupported_plants_are_rejected_by_name(tmp_path: Path, name: str) -> None:
    settings, what = UNSUPPORTED[name]
    friction = settings.pop("friction", None)
    experiment = Experiment.load(f"examples/{name}", settings)
    if friction is not None:
        robot = with_coordinates(experiment.robot, friction=friction)
        experiment = replace(experiment, robot=robot)
    with pytest.raises(InputError, match=re.escape(f"model exchange does not support {what}")):
        build(experiment, tmp_path / "fmus", kind="me")


@native
def test_other_kind_cannot_be_instantiated(tmp_path: Path, fmi: str) -> None:
    file = continuous_plant(falling(), tmp_path, [1.0], [0.0], fmi=fmi, arrays=False)
    fmpy.extract(str(file), str(tmp_path / "u"))
    description = fmpy.read_model_description(str(tmp_path / "u"))
    slave = (fmpy.fmi2.FMU2Slave if fmi == "2.0" else fmpy.fmi3.FMU3Slave)(
        guid=description.guid, unzipDirectory=str(tmp_path / "u"), modelIdentifier="plant"
    )
    with pytest.raises(Exception, match=r"[Ii]nstantiat"):
        slave.instantiate()
    slave.freeLibrary()
