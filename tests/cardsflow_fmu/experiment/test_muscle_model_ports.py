"""Muscles with muscle laws in experiments, FMUs and results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from support.experiments import write_resources
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu import Experiment, Result, build
from cardsflow_fmu.cosim.signals.muscles import ENERGIES
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.results.analysis.sizing import size
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics, MuscleDrive

MCKIBBEN = {"kind": "mckibben", "turns": 3.0, "pressure_time_constant": 0.02}
HILL = {
    "kind": "hill_degroote2016",
    "max_isometric_force": 300.0,
    "optimal_fibre_length": 0.45,
    "tendon_slack_length": 0.45,
}
LIGAMENT = {"kind": "ligament_blankevoort1991", "linear_stiffness": 40.0, "slack_length": 2.28}
MIXED: dict[str, Any] = {
    "muscles.cable_1.model": HILL,
    "muscles.cable_2.model": LIGAMENT,
    "muscles.cable_3.model": MCKIBBEN | {"thread_length": 1.2},
}
"""The two-link arm with a Hill muscle, a ligament, a pneumatic muscle and an ideal cable."""

DRIVEN: dict[str, Any] = {
    f"muscles.cable_{k}.model": MCKIBBEN | {"thread_length": 1.2 if k in (1, 3) else 3.0}
    for k in (1, 2, 3, 4)
}


def arm(*settings: dict[str, Any], **more: Any) -> Experiment:
    merged: dict[str, Any] = {"run.duration": 0.1}
    for part in settings:
        merged |= part
    return Experiment.load(PLANAR_2R, merged | more)


def ports(model: Any, causality: str) -> dict[str, str]:
    return {port.name: port.unit for port in model.ports if port.causality == causality}


def test_ports_of_ideal_cables_are_unchanged() -> None:
    plant, controller = PlantModel(arm()), ControllerModel(arm())
    assert list(ports(plant, "input")) == [
        *(f"f.cable_{k}" for k in (1, 2, 3, 4)),
        *(f"w.tip.f{axis}" for axis in "xyz"),
    ]
    assert list(ports(plant, "output")) == [
        *(f"{prefix}.joint_{k}" for prefix in ("q", "qd") for k in (1, 2)),
        *(f"l.cable_{k}" for k in (1, 2, 3, 4)),
        *("y.tip.x", "y.tip.z"),
    ]
    assert not [name for name in ports(controller, "input") if name.startswith("activation")]
    assert list(ports(controller, "output"))[:5] == [
        *(f"f.cable_{k}" for k in (1, 2, 3, 4)),
        "slack.joint_1",
    ]


def test_muscles_with_laws_have_commands_tensions_and_states_with_units() -> None:
    experiment = arm(MIXED, {"plant.energy": True})
    plant, controller = PlantModel(experiment), ControllerModel(experiment)
    into, out = ports(plant, "input"), ports(plant, "output")
    assert [n for n in into if not n.startswith("w.")] == ["f.cable_4", "u.cable_1", "u.cable_3"]
    assert (into["f.cable_4"], into["u.cable_1"], into["u.cable_3"]) == ("N", "", "Pa")
    states = {"activation.cable_1": "", "pressure.cable_3": "Pa"}
    tensions = {f"tension.cable_{k}": "N" for k in (1, 2, 3)}
    assert {name: out[name] for name in (*tensions, *states)} == tensions | states
    assert {name: out[name] for name in ENERGIES} == {n: unit for n, (unit, _) in ENERGIES.items()}
    assert {n: u for n, u in ports(controller, "input").items() if n in states} == states
    given = ports(controller, "output")
    assert list(given)[:6] == [*(f"f.cable_{k}" for k in (1, 2, 3, 4)), "u.cable_1", "u.cable_3"]


def test_states_of_one_kind_are_adjacent() -> None:
    elastic = HILL | {"kind": "hill_millard2012", "elastic_tendon": 1.0}
    models = {f"muscles.cable_{k}.model": elastic for k in (1, 3)}
    names = list(ports(PlantModel(arm(models)), "output"))
    kinds = ("activation", "fibre_length")
    assert names[-4:] == [f"{kind}.cable_{k}" for kind in kinds for k in (1, 3)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plant", "controller"])
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_fmus_with_muscle_laws_are_valid(name: str, version: Any, tmp_path: Path) -> None:
    file = build(arm(MIXED, {"plant.energy": True}), tmp_path, fmi=version, compute="python")[name]
    assert validate_fmu(str(file)) == []
    described = {v.name for v in read_model_description(str(file)).modelVariables}
    assert "u.cable_3" in described or "u" in described


@pytest.fixture(scope="module")
def pneumatic() -> Result:
    return simulate(arm(DRIVEN, {"run.duration": 8.0}), coupling="direct")


@pytest.mark.slow
def test_computed_torque_controls_pneumatic_muscles(pneumatic: Result) -> None:
    summary = pneumatic.summary
    assert summary["status"] == "complete"
    assert summary["infeasible_ticks"] == 0
    assert summary["tracking"]["max"] < 5e-3
    for k in (1, 2, 3, 4):
        f, tension = pneumatic[f"f.cable_{k}"], pneumatic[f"tension.cable_{k}"]
        np.testing.assert_allclose(tension[1:], f[:-1], rtol=0.02)  # reached at the next tick


@pytest.mark.slow
def test_summary_and_figure_contain_tensions(pneumatic: Result) -> None:
    forces = pneumatic.summary["forces"]
    names = [f"tension.cable_{k}" for k in (1, 2, 3, 4)]
    assert list(forces["per_muscle"]) == names
    assert forces["max"] == pneumatic.columns(names).max()
    from cardsflow_fmu.results.report.run_figures import tracking_figure

    labels = [axes.get_ylabel() for axes in tracking_figure(pneumatic).axes]
    assert labels == ["tension [N]", "pressure [Pa]", "position [rad]"]


@pytest.mark.slow
def test_too_slow_motors_cause_infeasible_ticks() -> None:
    slow = {"muscles.cable_1.model": {**MCKIBBEN, "thread_length": 1.2, "max_pressure": 300.0}}
    result = simulate(arm(DRIVEN, slow, {"run.duration": 0.5}), coupling="direct")
    assert result.summary["infeasible_ticks"] > 100


@pytest.mark.slow
def test_forces_stay_within_reachable_limits() -> None:
    """At each tick, forces are between the tensions at minimum and maximum command."""
    experiment = arm(MIXED, {"run.duration": 0.3})
    result, drive = simulate(experiment, coupling="direct"), MuscleDrive(experiment.robot)
    states = result.columns(["activation.cable_1", "pressure.cable_3"])
    q, qd = (result.columns([f"{p}.joint_{k}" for k in (1, 2)]) for p in ("q", "qd"))
    forces = result.columns([f"f.cable_{k}" for k in (1, 2, 3, 4)])
    for k in result_rows(result):
        drive.set_state(q[k], qd[k], states[k])
        low, high = drive.reach(experiment.controller.period)
        assert (forces[k] >= np.maximum(low, 0.0) - 1e-9).all()
        assert (forces[k] <= high + 1e-9).all()
        assert forces[k][1] == pytest.approx(low[1], abs=1e-9)  # the force of a ligament is fixed


def result_rows(result: Result) -> range:
    return range(0, len(result.rows) - 1, 10)


def test_run_starts_with_muscles_that_hold_the_robot() -> None:
    result = simulate(arm(DRIVEN, {"run.duration": 0.02}), coupling="direct")
    dynamics_q = result.columns(["q.joint_1", "q.joint_2"])
    np.testing.assert_allclose(dynamics_q, dynamics_q[0] * np.ones_like(dynamics_q), atol=1e-5)
    assert np.abs(result["u.cable_1"] - result["u.cable_1"][0]).max() < 50.0


def test_experiment_with_muscle_laws_is_packed_and_read_back_unchanged(tmp_path: Path) -> None:
    settings = {
        "plant.integrator": "rk4",
        "plant.substeps": 2,
        "plant.energy": True,
        "controller.muscle_horizon": 0.004,
    }
    experiment = arm(MIXED, settings)
    again = Experiment.from_resources(write_resources(experiment, tmp_path))
    assert again.robot == experiment.robot
    assert again.plant == experiment.plant
    assert again.controller == experiment.controller
    assert experiment_data(again) == experiment_data(experiment) | {
        "robot": experiment_data(again)["robot"]
    }


def test_muscle_law_by_name_keeps_the_parameters_of_the_robot() -> None:
    hill = EXAMPLES / "hill_arm"
    robot = Experiment.load(hill).robot
    changed = Experiment.load(hill, {"muscles.biceps.model": {"max_isometric_force": 100.0}}).robot
    named = Experiment.load(hill, {"muscles.biceps.model": "hill_degroote2016"}).robot
    assert named.muscle("biceps") == robot.muscle("biceps")
    before = dict(robot.muscle("biceps").model.parameters)
    after = dict(changed.muscle("biceps").model.parameters)
    assert after == before | {"max_isometric_force": 100.0}
    ideal = Experiment.load(hill, {"muscles.biceps.model": "ideal"}).robot
    assert ideal.muscle("biceps").model.kind == "ideal"


def test_published_parameters_are_selected_by_name() -> None:
    own = {"preset": "roboy_myo_muscle", "rest_length": 0.7, "stiffness": 1e4}
    settings = {"muscles.cable_1.model": "roboy_test_bench", "muscles.cable_2.model": own}
    first, second, *_ = arm(settings).robot.muscles
    assert first.model.kind == second.model.kind == "series_elastic_motor"
    assert dict(first.model.parameters)["gear_ratio"] == 128.0
    given = dict(second.model.parameters)
    assert (given["gear_ratio"], given["rest_length"], given["stiffness"]) == (53.0, 0.7, 1e4)


def test_finding_about_a_muscle_names_it() -> None:
    """`check` validates conditions on several parameters."""
    with pytest.raises(CardsflowError, match="cable_1"):
        model = HILL | {"kind": "hill_millard2012", "active_transition": 0.1}
        arm({"muscles.cable_1.model": model})


@pytest.mark.parametrize("settings", [MIXED, DRIVEN])
def test_models_restore_their_state_bit_by_bit(settings: dict[str, Any]) -> None:
    experiment = arm(settings, {"controller.observer": 20.0, "controller.delay": 1})
    plant, controller = PlantModel(experiment), ControllerModel(experiment)

    def together(count: int) -> np.ndarray:
        rows = []
        for k in range(count):
            copy(plant, controller)
            controller.step(1e-3 * k, 1e-3)
            copy(controller, plant)
            plant.step(1e-3 * k, 1e-3)
            rows.append(np.concatenate([plant.outputs, commands_of(controller)]))
        return np.array(rows)

    for model in (plant, controller):
        model.initialize()
    together(10)
    saved = [(m.get_state(), m.values.copy()) for m in (plant, controller)]
    first = together(10)
    for model, (state, values) in zip((plant, controller), saved, strict=True):
        model.values[:] = values
        model.set_state(state)
        np.testing.assert_array_equal(
            model.outputs, values[len(model.inputs) :][: model.outputs.size]
        )
    np.testing.assert_array_equal(together(10), first)
    with pytest.raises(InputError, match="state"):
        controller.set_state(b"\0" * 8)


def copy(source: Any, target: Any) -> None:
    given = {p.name: source.values[k] for k, p in enumerate(source.ports)}
    for k, port in enumerate(target.ports):
        if port.causality == "input" and port.name in given:
            target.values[k] = given[port.name]


def commands_of(controller: ControllerModel) -> np.ndarray:
    names = [port.name for port in controller.ports]
    return np.array([controller.values[k] for k, n in enumerate(names) if n != "solve_time"])


@pytest.mark.slow
def test_energy_output_is_balanced() -> None:
    settings = {"plant.energy": True, "plant.integrator": "rk4", "run.duration": 1.0}
    result = simulate(arm(DRIVEN, settings), coupling="direct")
    work = result.columns(["work.muscles", "work.outside", "work.damping"]).sum(axis=1)
    left = result["energy.kinetic"] + result["energy.potential"] - work
    np.testing.assert_allclose(left, left[0], atol=1e-8)
    assert np.ptp(result["work.muscles"]) > 1e-4


@pytest.mark.slow
def test_passive_muscle_is_a_load_in_sizing() -> None:
    """A stiffer ligament increases the force of its antagonist by the ratio of the moment arms."""
    rows, experiments = [], []
    for stiffness in (100.0, 110.0):
        ligament = LIGAMENT | {"linear_stiffness": stiffness, "slack_length": 2.0}
        experiments.append(arm({"muscles.cable_2.model": ligament}))
        rows.append({row["name"]: row for row in size(experiments[-1])["muscles"]})
    start, zero = experiments[0].start.q, np.zeros(2)
    pulls = []
    for experiment in experiments:
        drive = MuscleDrive(experiment.robot)
        drive.set_state(start, zero, [])
        pulls.append(drive.tensions(np.zeros(4))[1])
    levers = DartDynamics(experiments[0].robot).muscle_jacobian(start)[:, 1]
    more = -levers[1] / levers[3] * (pulls[1] - pulls[0])
    assert more > 0.5
    assert rows[0]["cable_2"]["peak"] == rows[1]["cable_2"]["peak"] == 0.0
    assert rows[1]["cable_4"]["rms"] - rows[0]["cable_4"]["rms"] == pytest.approx(more, rel=0.01)
