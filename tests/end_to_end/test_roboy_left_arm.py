"""The left arm of Roboy draws the flower by eq. (4), from robot files to results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.cases import LONG
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.simulation.run import simulate

ROBOY_LEFT_ARM = EXAMPLES / "roboy_left_arm"
AXES = ("x", "y", "z")
ON_THE_FLOWER = {
    "start": {"seed": [1.45, 0.0, 0.0, -1.3]},
    "reference": {
        "flower": {"centre": [0.45, -0.45, 0.45], "radius": 0.15, "petals": 5, "duration": 30.0}
    },
}


def flower(settings: Mapping[str, object] | None = None) -> Result:
    """Run the 30 s flower from a start on the curve."""
    return _run(json.dumps(settings or {}))


@cache
def _run(settings: str) -> Result:
    experiment = Experiment.load(ROBOY_LEFT_ARM, ON_THE_FLOWER | json.loads(settings))
    return simulate(experiment, coupling="direct")


def errors(result: Result):
    """Return the distance of the hand from the reference, in [mm]."""
    y, y_d = (result.columns([f"{p}.hand.{axis}" for axis in AXES]) for p in ("y", "y_d"))
    return 1e3 * np.linalg.norm(y - y_d, axis=1)


def rms(values) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_flower_at_200_hz_tracks() -> None:
    result = flower()
    error, robot = errors(result), result.experiment.robot
    assert result.complete
    assert rms(error) < 0.06
    assert error.max() < 0.2
    assert result.summary["infeasible_ticks"] == 0
    assert result.summary["ticks"] == 6000
    assert result.summary["tracking"]["unit"] == "m"
    assert result.summary["tracking"]["rms"] == pytest.approx(1e-3 * rms(error), rel=1e-12)
    for c in robot.coordinates:
        q = result[f"q.{c.name}"]
        assert c.lower <= q.min() <= q.max() <= c.upper
    for muscle in robot.muscles:
        f = result[f"f.{muscle.name}"]
        assert muscle.f_min <= f.min() <= f.max() <= muscle.f_max


def test_reference_is_a_rose_around_its_centre() -> None:
    """The reference is R = A cos(5 phi) in the plane y = -0.45 m, with every petal once."""
    result = flower()
    x, y, z = (result[f"y_d.hand.{axis}"] for axis in AXES)
    np.testing.assert_allclose(y, -0.45, atol=1e-12)
    r, phi = np.hypot(x - 0.45, z - 0.45), np.arctan2(z - 0.45, x - 0.45)
    np.testing.assert_allclose(r, 0.15 * np.abs(np.cos(5 * phi)), atol=1e-9)
    np.testing.assert_allclose([x[0], z[0], x[-1], z[-1]], [0.6, 0.45, 0.6, 0.45], atol=1e-12)


@pytest.mark.slow
def test_flower_at_100_hz_with_delay_tracks() -> None:
    result = flower({"controller.period": 0.01, "controller.delay": 1})
    assert rms(errors(result)) < 0.5
    assert result.summary["infeasible_ticks"] == 0


@LONG
@pytest.mark.slow
def test_heavier_arm_tracks_with_integral_action() -> None:
    assert rms(errors(flower({"plant.mass_scale": 1.1, "controller.ki": 4000.0}))) < 0.2
    assert rms(errors(flower({"plant.mass_scale": 1.1}))) > 2.0


@LONG
@pytest.mark.slow
def test_known_load_at_the_hand_is_compensated() -> None:
    load = {"force": {"hand": [0.0, 0.0, -10.0]}, "known": True}
    assert rms(errors(flower({"disturbance": load}))) < 0.4


@pytest.mark.slow
def test_observer_compensates_an_unknown_load_at_the_hand() -> None:
    load = {"force": {"hand": [0.0, 0.0, -10.0]}}
    result = flower({"disturbance": load, "controller.observer": 30.0})
    assert rms(errors(result)) < 5.0
    assert result["w.hand.fz"][100] == -10.0


@pytest.mark.slow
def test_disturbance_acts_from_its_begin_to_its_end() -> None:
    settings = {
        "run.duration": 0.5,
        "controller.observer": 20.0,
        "controller.ki": 100.0,
        "controller.delay": 1,
        "controller.task_weights": {"hand.y": 100.0},
        "controller.priorities": {"hand.z": 2.0},
        "disturbance": {"force": {"hand": [1.0, 2.0, -3.0]}, "begin": 0.1, "end": 0.3},
        "plant.mass_scale": {"lower_arm_left": 1.05},
    }
    experiment = Experiment.load(ROBOY_LEFT_ARM, settings)
    fmu = simulate(experiment)
    assert fmu["w.hand.fz"][50] == 0.0
    assert fmu["w.hand.fz"][150] == -3.0
    assert fmu["w.hand.fz"][350] == 0.0


@pytest.mark.slow
def test_approach_moves_from_the_start_to_the_flower(tmp_path: Path) -> None:
    result = run(
        Experiment.load(ROBOY_LEFT_ARM, {"run.duration": 2.5, "run.figures": True}), tmp_path
    )
    y_d = result.columns([f"y_d.hand.{axis}" for axis in AXES])
    np.testing.assert_allclose(y_d[0], [0.5, -0.45, 0.4], atol=1e-6)
    np.testing.assert_allclose(y_d[2000], [0.6, -0.45, 0.45], atol=1e-9)
    assert errors(result).max() < 0.2
    way = y_d[:2001] - y_d[0]
    np.testing.assert_allclose(np.cross(way, way[-1]), 0.0, atol=1e-12)
    for name in ("tracking.png", "path.png", "path.svg", "results.csv", "controller.fmu"):
        assert (tmp_path / name).stat().st_size > 1000


@LONG
@pytest.mark.slow
def test_task_in_the_cost_tracks_slightly_less_accurately() -> None:
    result = flower({"controller.type": "reactive_qp"})
    assert 0.04 < rms(errors(result)) < 0.2
    assert result.summary["infeasible_ticks"] == 0


@LONG
@pytest.mark.slow
def test_30_000_ticks_of_the_flower_are_feasible() -> None:
    result = flower({"controller.period": 0.001})
    assert result.summary["ticks"] == 30_000
    assert result.summary["infeasible_ticks"] == 0
    assert rms(errors(result)) < 0.06


@LONG
@pytest.mark.slow
def test_eq_4_of_the_paper_drifts_to_the_joint_limits() -> None:
    """The form in the paper does not damp self-motion. Therefore a posture is the default."""
    literal = flower({"controller.posture": False, "controller.limit_bandwidth": False})
    q, kept = literal["q.joint_1"], flower()["q.joint_1"]
    assert (q.min(), q.max()) == pytest.approx((1.2, 1.7), abs=1e-3)
    assert 1.3 < kept.min() < kept.max() < 1.6
    assert errors(literal).max() > 1.0


@LONG
@pytest.mark.slow
def test_controller_limits_prevent_drift_to_the_joint_limits() -> None:
    result = flower({"controller.posture": False})
    assert errors(result).max() < 0.2
    q = result["q.joint_1"]
    assert 1.2 - 1e-3 < q.min() < q.max() < 1.7 + 1e-3


@LONG
@pytest.mark.slow
def test_published_xylophone_trajectory_is_tracked() -> None:
    """The trajectory of 80 s moves over keys from x = 0.25 to 0.65 m."""
    settings = {
        "reference": {"trajectory": "xylo_1", "file": "xylo_trajectories.xml"},
        "start": {"seed": [1.45, 0.0, 0.0, -1.3]},
    }
    result = simulate(Experiment.load(ROBOY_LEFT_ARM, settings), coupling="direct")
    assert result["time"][-1] == 80.0
    assert rms(errors(result)) < 0.06
    assert result.summary["infeasible_ticks"] == 0


def test_flower_out_of_reach_raises_an_error_before_the_first_step() -> None:
    wide = ON_THE_FLOWER | {"reference.flower.radius": 0.5}
    with pytest.raises(InputError, match=r"start\.q: no configuration reaches hand\.x 0\.95"):
        Experiment.load(ROBOY_LEFT_ARM, wide)


def test_controller_uses_the_given_period() -> None:
    """Observer and integral use the period from the parameter or from the step size."""
    settings = {"controller.observer": 30.0, "controller.ki": 100.0, "controller.delay": 1}
    expected = Experiment.load(ROBOY_LEFT_ARM, settings | {"controller.period": 0.01})
    other = Experiment.load(ROBOY_LEFT_ARM, settings)
    rows = []
    for experiment, period in ((expected, None), (other, 0.01), (other, None)):
        model = ControllerModel(experiment)
        names = [port.name for port in model.ports]
        if period is not None:
            model.values[names.index("period")] = period
        model.initialize()
        model.inputs[: len(experiment.start.q)] = experiment.start.q
        for k in range(5):
            model.inputs[4] = 0.01 * k
            model.step(0.01 * k, 0.01)
        rows.append(np.delete(model.outputs.copy(), names.index("solve_time") - len(model.inputs)))
    np.testing.assert_array_equal(rows[1], rows[0])
    np.testing.assert_array_equal(rows[2], rows[0])


def test_zero_period_raises_an_error() -> None:
    model = ControllerModel(Experiment.load(ROBOY_LEFT_ARM))
    model.values[[port.name for port in model.ports].index("period")] = 0.0
    with pytest.raises(InputError, match="period must be a positive time"):
        model.initialize()
