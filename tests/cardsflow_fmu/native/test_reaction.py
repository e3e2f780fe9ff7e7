"""Reaction to lost muscles: forces of the others, decisions, and a slower reference."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.experiments import write_resources
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.motion.look_ahead import FALL, POSE, LookAhead
from cardsflow_fmu.models.c_model import CModel
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.models.reference import ReferenceModel, make_reference
from cardsflow_fmu.results.estimation import fault_events
from cardsflow_fmu.utils.arrays import FloatArray

LEFT_ARM = EXAMPLES / "roboy_left_arm"
FAULTS = {"estimator.encoder_noise": 1e-4, "estimator.feedback": False, "faults.react": True}
CONTINUE, SLOW, HOLD, STOP = 1, 2, 3, 4
DELAY = 0.01  # of the detection, in [s]
RECOVERY = 0.3  # time of higher gains after a loss, in [s]


@cache
def arm(**settings: float) -> Experiment:
    return Experiment.load(LEFT_ARM, FAULTS | settings)


def with_table(experiment: Experiment, speed: float) -> Experiment:
    """Return the experiment with the same speed for all muscles and times."""
    speeds = {muscle.name: (speed,) for muscle in experiment.robot.muscles}
    return replace(experiment, look_ahead=LookAhead(times=(0.0,), speeds=speeds))


def values(model: CModel, group: str) -> FloatArray:
    """Return the values of a group of variables; a view."""
    where = model.indices(group)
    return model.values[where[0] : where[-1] + 1]


class Loop:
    """Reference, controller and plant, with a cable that breaks."""

    def __init__(self, experiment: Experiment) -> None:
        self.reference, self.controller = ReferenceModel(experiment), ControllerModel(experiment)
        self.plant, self.period = PlantModel(experiment), experiment.controller.period
        for model in (self.reference, self.controller, self.plant):
            model.initialize(0.0)

    def run(self, end: float, broken: int, at: float) -> dict[str, FloatArray]:
        """Return rows of q, qd, the error of the hand, and the outputs of the reaction."""
        rows: dict[str, list[FloatArray]] = {k: [] for k in ("q", "qd", "error", "reaction")}
        reference, controller, plant = self.reference, self.controller, self.plant
        forces = values(plant, "commands")
        for k in range(round(end / 1e-3)):
            t = k * 1e-3
            if k % round(self.period / 1e-3) == 0:
                for group in ("q", "qd"):
                    values(controller, group)[:] = values(plant, group)
                for group in ("reference", "reached"):
                    values(controller, group)[:] = values(reference, group)
                if t >= at + DELAY:
                    values(controller, "bounds")[broken] = 0.0
                controller.step(t, self.period)
                forces[:] = values(controller, "forces")
                values(reference, "speed")[:] = values(controller, "reaction")[0]
            if t >= at:
                forces[broken] = 0.0
            plant.step(t, 1e-3)
            reference.step(t, 1e-3)
            rows["q"].append(values(plant, "q").copy())
            rows["qd"].append(values(plant, "qd").copy())
            rows["error"].append(values(plant, "tasks") - values(reference, "reference")[:3])
            rows["reaction"].append(values(controller, "reaction").copy())
        return {name: np.array(row) for name, row in rows.items()}


def test_forces_are_those_of_a_robot_without_the_muscle() -> None:
    experiment = with_table(arm(), 1.0)
    robot, lost = experiment.robot, 2
    kept = [k for k in range(len(robot.muscles)) if k != lost]
    own = experiment.controller
    fewer = {
        name: tuple(np.array(getattr(own, name))[kept])
        for name in ("weights", "pretension", "force_rate_weights")
        if len(getattr(own, name)) == len(robot.muscles)
    }
    without = replace(
        experiment,
        robot=robot.with_muscles([robot.muscles[k] for k in kept]),
        controller=own.copy_with(**fewer),
        faults=None,
    )
    broken, smaller = ControllerModel(experiment), ControllerModel(without)
    values(broken, "bounds")[lost] = 0.0
    broken.initialize(0.0)
    smaller.initialize(0.0)
    rng, period = np.random.default_rng(0), own.period
    start = make_reference(experiment).evaluate(0.0).q
    compared = 0
    for k in range(100):
        q = np.array(experiment.start.q) + 0.02 * rng.standard_normal(len(robot.coordinates))
        for model in (broken, smaller):
            values(model, "q")[:] = q
            values(model, "reference")[: len(start)] = start
            model.step(k * period, period)
        forces, is_feasible = values(broken, "forces"), not values(smaller, "report")[2]
        assert forces[lost] == 0.0
        if is_feasible and k * period > RECOVERY:
            others = values(smaller, "forces")
            np.testing.assert_allclose(forces[kept], others, rtol=1e-9, atol=1e-9)
            compared += 1
    assert compared > 10


@pytest.mark.parametrize(
    ("speed", "decision", "final"),
    [(1.0, CONTINUE, 1.0), (0.5, SLOW, 0.5), (POSE, HOLD, 0.0), (FALL, STOP, 0.0)],
)
def test_decision_is_looked_up(speed: float, decision: int, final: float) -> None:
    loop = Loop(with_table(arm(), speed))
    rows = loop.run(1.5, broken=1, at=0.5)
    assert not rows["reaction"][:500, 1].any()
    assert rows["reaction"][-1].tolist() == [final, decision, 1.0]
    assert np.abs(rows["error"][-1]).max() < (5e-2 if decision == STOP else 1e-3)
    if decision in (HOLD, STOP):
        assert np.abs(rows["qd"][-1]).max() < 1e-2


def test_slower_reference_is_the_same_path() -> None:
    """Velocities and accelerations are the derivatives of the positions, also within the ramp."""
    reference = ReferenceModel(arm())
    reference.initialize(0.0)
    h, rows, times = 1e-3, [], []
    for k in range(1500):
        values(reference, "speed")[:] = 1.0 if k < 500 else 0.3
        reference.step(k * h, h)
        rows.append(values(reference, "reference").reshape(3, 3).copy())
        times.append(values(reference, "reached")[0])
    path = make_reference(arm()).evaluate(np.array(times)).q
    y, rate, acceleration = np.moveaxis(np.array(rows), 1, 0)
    np.testing.assert_allclose(y, path, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.gradient(y, h, axis=0)[2:-2], rate[2:-2], rtol=0, atol=1e-5)
    by_time = np.gradient(rate, h, axis=0)[2:-2]
    np.testing.assert_allclose(by_time, acceleration[2:-2], rtol=0, atol=2e-3)
    speeds = np.diff(times) / h
    assert times[499] == 0.5
    np.testing.assert_allclose(speeds[:499], 1.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(speeds[1000:], 0.3, rtol=0, atol=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_broken_cable_of_a_simulation_is_found(noise: float) -> None:
    """Its measured tension is 0, its motor holds, and the hand stays on its path."""
    settings = {"plant.break_time.motor4": 0.1, "run.duration": 0.3}
    settings["estimator.sensors.length_noise"] = noise
    data = native_loop(with_table(arm(**settings), 1.0)).run()
    columns = dict(zip(data.names, data.rows.T, strict=True))
    broken, *others = fault_events(columns)
    assert (broken["part"], broken["kind"]) == ("muscle motor4", "broken")
    assert 0.1 <= broken["time"] <= 0.13
    assert [event["decision"] for event in others] == ["continue"]
    after = columns["time"] > 0.1
    assert (columns["tension.motor4"] > 0.0)[columns["time"] < 0.1].all()
    assert not columns["tension.motor4"][after].any()
    assert np.ptp(columns["l_m.motor4"][after]) == 0.0
    for axis in "xyz":
        error = columns[f"y.hand.{axis}"] - columns[f"y_d.hand.{axis}"]
        assert np.abs(error).max() < 5e-3


def test_predicted_motion_follows_the_slower_reference() -> None:
    """The forces of mpc are those with a reference that is slower from the start."""
    mpc = {"controller.type": "mpc", "controller.nodes": 5, "controller.horizon": 0.1}
    twice = {"reference.approach": {"duration": 4.0}, "reference.flower.duration": 60.0}
    slower = Experiment.load(LEFT_ARM, mpc | twice)
    rows = np.array(make_reference(slower).evaluate(1.2)).ravel()
    forces = []
    for experiment, time in ((slower, 1.2), (arm(**mpc), 0.6)):
        model = ControllerModel(experiment)
        values(model, "q")[:] = experiment.start.q
        values(model, "reference")[:] = rows
        if experiment.reacts_to_faults:
            values(model, "reached")[:] = time
        model.initialize(0.0)
        model.step(1.2, experiment.controller.period)
        forces.append(values(model, "forces").copy())
    np.testing.assert_allclose(*forces, rtol=1e-6)


def test_state_of_the_reaction_is_saved() -> None:
    experiment = with_table(arm(), POSE)
    loop, other = Loop(experiment), Loop(experiment)
    loop.run(0.6, broken=1, at=0.5)
    for name in ("controller", "reference", "plant"):
        model: CModel = getattr(loop, name)
        copy: CModel = getattr(other, name)
        copy.values[:] = model.values
        copy.set_state(model.get_state())
    np.testing.assert_array_equal(*(run.run(0.3, 1, -1.0)["q"] for run in (loop, other)))


def test_insufficient_forces_lead_to_a_more_severe_decision() -> None:
    """Without the only cable that lifts the forearm, a wrong table is corrected."""
    rows = Loop(with_table(arm(), 1.0)).run(2.0, broken=9, at=0.1)
    decisions = rows["reaction"][:, 1]
    assert decisions[200] == CONTINUE
    assert decisions[-1] == STOP
    assert (np.diff(decisions) >= 0).all()
    limits = np.array([(c.lower, c.upper) for c in arm().robot.coordinates])
    assert (rows["q"] >= limits[:, 0] - 1e-9).all()
    assert (rows["q"] <= limits[:, 1] + 1e-9).all()
    assert np.abs(rows["qd"][-1]).max() < 1e-3


def test_fmus_contain_the_table(tmp_path: Path) -> None:
    """Models in Python decide as those in C."""
    experiment = with_table(arm(), 0.25)
    folder = write_resources(experiment, tmp_path)
    assert Experiment.from_resources(folder).look_ahead == experiment.look_ahead
    file = folder / "look_ahead.json"
    file.write_text(file.read_text().replace("motor10", "motor11"))
    with pytest.raises(InputError, match=r"speeds.motor10: must have one number for each of"):
        Experiment.from_resources(folder)
