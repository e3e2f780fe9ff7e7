"""Native plants with Runge-Kutta, energy balances, wrenches on links and friction."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from support.cases import sample_cases
from support.experiments import with_robot
from support.fmu.fmu_host import require_error, running
from support.fmu.native_states import check_states_repeat
from support.robots.robots import EXAMPLES, with_coordinates

from addin_sdfusion.robot import InputError, SimulationError, read_robot
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import simulate

PUSH = {
    "plant.wrenches": ["link_1", "link_2"],
    "wiring.plant": {"w.link_2.fx": 0.7, "w.link_2.tz": -0.1, "w.link_1.ty": 0.2},
}
BOTH = {"plant.energy": True, "plant.integrator": "rk4"}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "rk4": ("planar_2r", {"plant.integrator": "rk4"}),
    "energy": ("planar_2r", {"plant.energy": True, "plant.substeps": 3}),
    "wrenches": ("planar_2r", PUSH),
    "all": ("planar_2r", PUSH | BOTH | {"plant.substeps": 2, "plant.step": 0.0005}),
    "arm": ("roboy_left_arm", BOTH),
    "hill": ("hill_arm", {"plant.wrenches": ["forearm"], "plant.substeps": 2}),
    "pneumatic": ("pneumatic_elbow", {"plant.energy": True}),
    "hill rk4": ("hill_arm", BOTH | {"plant.wrenches": ["forearm"]}),
}


def experiment_of(case: str, duration: float = 0.1, **more: Any) -> Experiment:
    example, settings = CASES[case]
    return Experiment.load(EXAMPLES / example, {"run.duration": duration, **settings, **more})


LAWS = ("f", "u", "slack", "tension")
"""Columns with commands and tensions of muscles with laws."""


def assert_rows_agree(found: Result, expected: Result, *, forces: float, others: float) -> None:
    """Check that columns agree relative to the maximum of a column, or to 1.

    Columns in `LAWS` have a separate tolerance.
    """
    assert found.names == expected.names
    for k, name in enumerate(expected.names):
        scale = max(np.abs(expected.rows[:, k]).max(), 1.0)
        near = forces if name.split(".")[0] in LAWS else others
        np.testing.assert_allclose(
            found.rows[:, k], expected.rows[:, k], rtol=0, atol=near * scale, err_msg=name
        )


@pytest.mark.cases(2)
@pytest.mark.parametrize("case", sample_cases(CASES))
def test_closed_loop_agrees_with_dart(case: str) -> None:
    """Up to rounding errors."""
    euler = {"plant.integrator": "euler"}  # DART supports only this one
    native, on_dart = (
        simulate(experiment_of(case, **euler, **{"plant.engine": engine}), coupling="direct")
        for engine in ("auto", "dart")
    )
    assert_rows_agree(native, on_dart, forces=1e-9, others=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["rk4", "energy", "wrenches", "all"])
def test_plant_has_the_declared_derivatives(case: str, tmp_path: Path) -> None:
    file = build(experiment_of(case), tmp_path, compute="c")["plant"]
    with running(file, tmp_path / "unpacked") as host:
        inputs, outputs = host.of("input"), host.of("output")
        host.slave.doStep(0.0, 1e-3)

        def ask() -> object:
            return host.slave.getDirectionalDerivative(outputs, inputs, [1.0] * len(inputs))

        if fmpy.read_model_description(str(file)).coSimulation.providesDirectionalDerivative:
            assert np.isfinite(ask()).all()
        else:
            require_error(ask)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["rk4", "all", "hill rk4"])
@pytest.mark.native
def test_restored_states_are_bit_identical(case: str, tmp_path: Path) -> None:
    """The work is part of the state."""
    file = build(experiment_of(case), tmp_path, compute="c")["plant"]
    check_states_repeat(file, tmp_path / "unpacked", step=5e-3)


def recorded(case: str) -> np.ndarray:
    return native_loop(experiment_of(case)).run().rows


@pytest.mark.native
def test_runs_in_threads_equal_single_runs() -> None:
    cases = ("all", "hill rk4", "all")
    with ThreadPoolExecutor(2) as pool:
        for case, rows in zip(cases, pool.map(recorded, cases), strict=True):
            np.testing.assert_array_equal(rows, recorded(case))


def energy_lost(rule: str, step: float, folder: Path) -> float:
    """Return the error of the energy balance of an arm with cables and wrenches after 0.1 s."""
    settings = {"plant.wrenches": ["link_2"], "plant.energy": True, "plant.integrator": rule}
    experiment = Experiment.load(EXAMPLES / "planar_2r", settings | {"plant.step": step})
    file = build(experiment, folder, compute="c")["plant"]
    with running(file, folder / "unpacked") as host:
        energies, works = (
            [name for name in host.references if name.startswith(prefix)]
            for prefix in ("energy.", "work.")
        )
        host.set(**{"f.cable_1": 15.0, "w.link_2.fx": 3.0})
        begin = sum(host.get(*energies))
        for k in range(50):
            host.slave.doStep(k * 2e-3, 2e-3)
        done = host.get(*works)
        assert min(abs(work) for work in done[:2]) > 0.01
        return abs(sum(host.get(*energies)) - begin - sum(done))


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "order", "max_error"), [("euler", 1, 0.05), ("rk4", 4, 1e-7)])
def test_energy_equals_work(rule: str, order: int, max_error: float, tmp_path: Path) -> None:
    """With the order of the integrator."""
    coarse, fine = (energy_lost(rule, h, tmp_path / str(h)) for h in (1e-3, 5e-4))
    assert fine < max_error
    assert coarse / fine > 0.75 * 2**order


def rough_experiment(folder: Path, **more: Any) -> Experiment:
    """Return the two-link arm with joint friction, also in the energy balance of the plant."""
    arm = read_robot(EXAMPLES / "planar_2r/robot/planar_2r_bodies.xml")
    trajectories = EXAMPLES / "planar_2r/robot/planar_2r_trajectories.xml"
    changes = {"reference.file": str(trajectories), "run.duration": 0.2, "plant.energy": True}
    return with_robot("planar_2r", with_coordinates(arm, friction=0.4), folder, **changes, **more)


@pytest.mark.slow
@pytest.mark.native
def test_joint_friction_agrees_with_dart(tmp_path: Path) -> None:
    """DART softens its impulses."""
    experiment = rough_experiment(tmp_path / "rough")
    softened = rough_experiment(tmp_path / "again", **{"plant.engine": "dart"})
    native, dart = (simulate(each, coupling="direct") for each in (experiment, softened))
    assert native.summary["engine"]["plant"] == "native"
    assert dart.summary["engine"]["plant"] == "dart"
    assert native.names == dart.names
    columns = [k for k, n in enumerate(native.names) if n.split(".")[0] in ("q", "qd", "energy")]
    np.testing.assert_allclose(native.rows[:, columns], dart.rows[:, columns], rtol=0, atol=1e-7)
    smooth = experiment_of("energy", 0.2)
    rows = native_loop(smooth).run().rows
    assert np.abs(rows[:, columns[0]] - native.rows[:, columns[0]]).max() > 1e-5


def test_friction_with_runge_kutta_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="rk4 does not support Coulomb friction"):
        rough_experiment(tmp_path, **{"plant.integrator": "rk4"})


@pytest.mark.slow
@pytest.mark.parametrize("name", ["w.tip.fx", "w.link_1.tz"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.native
def test_wrench_that_is_not_finite_is_rejected_by_name(
    name: str, value: float, tmp_path: Path
) -> None:
    file = build(experiment_of("all"), tmp_path, compute="c")["plant"]
    with running(file, tmp_path / "unpacked") as host:
        require_error(lambda: host.set(**{name: value}) or host.slave.doStep(0.0, 1e-3))
        assert name in host.last


@pytest.mark.native
def test_divergence_is_reported_with_its_time() -> None:
    push = {"plant.wrenches": ["link_2"], "wiring.plant": {"w.link_2.fx": 1e308}}
    experiment = experiment_of("rk4", **push)
    recording = native_loop(experiment).run()
    assert isinstance(recording.failure, SimulationError)
    assert "diverged at t = 0.001 s" in str(recording.failure)
