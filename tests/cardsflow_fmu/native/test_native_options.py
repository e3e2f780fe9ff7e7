"""Native plants with the fourth-order rule, energy balances, wrenches on links and friction."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from support.cases import few
from support.experiments import with_robot
from support.fmu.fmu_host import refused, running
from support.fmu.native_states import check_states_repeat
from support.robots.robots import EXAMPLES, with_coordinates

from addin_sdfusion.robot import InputError, SimulationError, read_robot
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.models.native_loop import NativeLoop, run_batch
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
    """The same columns, near each other relative to the largest number of a column, or to 1.

    Columns of `LAWS` have a tolerance of their own.
    """
    assert found.names == expected.names
    for k, name in enumerate(expected.names):
        scale = max(np.abs(expected.rows[:, k]).max(), 1.0)
        near = forces if name.split(".")[0] in LAWS else others
        np.testing.assert_allclose(
            found.rows[:, k], expected.rows[:, k], rtol=0, atol=near * scale, err_msg=name
        )


@pytest.mark.cases(2)
@pytest.mark.parametrize("case", few(CASES))
def test_a_closed_loop_is_the_same_on_dart(case: str) -> None:
    """To rounding."""
    euler = {"plant.integrator": "euler"}  # the one that DART has
    native, on_dart = (
        simulate(experiment_of(case, **euler, **{"plant.engine": engine}), coupling="direct")
        for engine in ("auto", "dart")
    )
    assert_rows_agree(native, on_dart, forces=1e-9, others=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["rk4", "energy", "wrenches", "all"])
def test_a_plant_gives_the_derivatives_that_it_says_it_has(case: str, tmp_path: Path) -> None:
    file = build(experiment_of(case), tmp_path, compute="c")["plant"]
    with running(file, tmp_path / "unpacked") as host:
        inputs, outputs = host.of("input"), host.of("output")
        host.slave.doStep(0.0, 1e-3)

        def ask() -> object:
            return host.slave.getDirectionalDerivative(outputs, inputs, [1.0] * len(inputs))

        if fmpy.read_model_description(str(file)).coSimulation.providesDirectionalDerivative:
            assert np.isfinite(ask()).all()
        else:
            refused(ask)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["rk4", "all", "hill rk4"])
@pytest.mark.native
def test_states_repeat_bit_for_bit(case: str, tmp_path: Path) -> None:
    """The work that was done is part of the state."""
    file = build(experiment_of(case), tmp_path, compute="c")["plant"]
    check_states_repeat(file, tmp_path / "unpacked", step=5e-3)


@pytest.mark.native
def test_a_batch_in_threads_gives_what_each_gives_alone() -> None:
    experiments = [experiment_of(case) for case in ("all", "hill rk4", "all")]
    for experiment, recording in zip(experiments, run_batch(experiments, threads=2), strict=True):
        with NativeLoop(experiment) as loop:
            np.testing.assert_array_equal(recording.rows, loop.run().rows)


def energy_lost(rule: str, step: float, folder: Path) -> float:
    """Error of the energy balance of an arm under cables and wrenches after a tenth of a second."""
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
@pytest.mark.parametrize(("rule", "order", "most"), [("euler", 1, 0.05), ("rk4", 4, 1e-7)])
def test_energy_is_what_work_has_made_of_it(
    rule: str, order: int, most: float, tmp_path: Path
) -> None:
    """To the order of the rule."""
    coarse, fine = (energy_lost(rule, h, tmp_path / str(h)) for h in (1e-3, 5e-4))
    assert fine < most
    assert coarse / fine > 0.75 * 2**order


def rough_experiment(folder: Path, **more: Any) -> Experiment:
    """The two-link arm with friction in its joints, in the plant's energy balance too."""
    arm = read_robot(EXAMPLES / "planar_2r/robot/planar_2r_bodies.xml")
    trajectories = EXAMPLES / "planar_2r/robot/planar_2r_trajectories.xml"
    changes = {"reference.file": str(trajectories), "run.duration": 0.2, "plant.energy": True}
    return with_robot("planar_2r", with_coordinates(arm, friction=0.4), folder, **changes, **more)


@pytest.mark.slow
@pytest.mark.native
def test_friction_in_joints_is_the_same(tmp_path: Path) -> None:
    """In C and on DART, which softens its impulses."""
    experiment = rough_experiment(tmp_path / "rough")
    softened = rough_experiment(tmp_path / "again", **{"plant.engine": "dart"})
    native, dart = (simulate(each, coupling="direct") for each in (experiment, softened))
    assert native.summary["engine"]["plant"] == "native"
    assert dart.summary["engine"]["plant"] == "dart"
    assert native.names == dart.names
    columns = [k for k, n in enumerate(native.names) if n.split(".")[0] in ("q", "qd", "energy")]
    np.testing.assert_allclose(native.rows[:, columns], dart.rows[:, columns], rtol=0, atol=1e-7)
    smooth = experiment_of("energy", 0.2)
    with NativeLoop(smooth) as loop:
        assert np.abs(loop.run().rows[:, columns[0]] - native.rows[:, columns[0]]).max() > 1e-5


def test_friction_and_the_fourth_order_rule_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="rk4 does not support Coulomb friction"):
        rough_experiment(tmp_path, **{"plant.integrator": "rk4"})


@pytest.mark.slow
@pytest.mark.parametrize("name", ["w.tip.fx", "w.link_1.tz"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
@pytest.mark.native
def test_a_push_that_is_no_number_is_refused_by_name(
    name: str, value: float, tmp_path: Path
) -> None:
    file = build(experiment_of("all"), tmp_path, compute="c")["plant"]
    with running(file, tmp_path / "unpacked") as host:
        refused(lambda: host.set(**{name: value}) or host.slave.doStep(0.0, 1e-3))
        assert name in host.last


@pytest.mark.native
def test_a_robot_that_diverges_says_when() -> None:
    push = {"plant.wrenches": ["link_2"], "wiring.plant": {"w.link_2.fx": 1e308}}
    experiment = experiment_of("rk4", **push)
    with NativeLoop(experiment) as loop:
        recording = loop.run()
    assert isinstance(recording.failure, SimulationError)
    assert "diverged at t = 0.001 s" in str(recording.failure)
