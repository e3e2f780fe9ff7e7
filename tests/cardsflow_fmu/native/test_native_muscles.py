"""Native FMUs of robots whose muscles have muscle laws."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from support.fmu.fmu_host import require_error, running
from support.fmu.native_states import check_states_repeat
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.simulation.build import build

MCKIBBEN = {"kind": "mckibben", "turns": 3.0, "pressure_time_constant": 0.02}
HILL = {"max_isometric_force": 300.0, "optimal_fibre_length": 0.45, "tendon_slack_length": 0.45}
MOTOR = {"kind": "series_elastic_motor", "rest_length": 0.3}
LIGAMENT = {"kind": "ligament_blankevoort1991", "linear_stiffness": 40.0, "slack_length": 2.28}
CABLE, SPRING = {"kind": "elastic_cable", "stiffness": 2e3}, {"kind": "passive_spring", "l0": 0.4}


def cables(*models: dict[str, Any] | str) -> dict[str, Any]:
    """Return settings with a law for each cable of the two-link arm."""
    return {f"muscles.cable_{k}.model": model for k, model in enumerate(models, 1)}


MIXED = cables(
    {"kind": "hill_degroote2016"} | HILL, LIGAMENT, MCKIBBEN | {"thread_length": 1.2}, "ideal"
)
OTHERS = cables(
    {"kind": "hill_thelen2003"} | HILL,
    {"kind": "hill_millard2012"} | HILL | {"optimal_fibre_length": 1.1, "tendon_slack_length": 1.2},
    SPRING | {"K": 40.0},
    CABLE | {"damping": 5.0},
) | {"muscles.cable_3.f_min": 0.0, "muscles.cable_3.f_max": 0.0}
MOTORS = cables(MOTOR, MOTOR, "ideal", "ideal")
DRUM = {
    "kind": "winch_position",
    "drum_radius": 0.02,
    "motor_inertia": 2e-5,
    "viscous_friction": 0.01,
    "axial_stiffness": 2e4,
    "max_torque": 5.0,
    "position_gain": 20.0,
    "velocity_gain": 0.1,
}
TORQUE = {name: value for name, value in DRUM.items() if not name.endswith("_gain")}
WINCHES = cables(DRUM, DRUM, TORQUE | {"kind": "winch"}, TORQUE | {"kind": "winch"})
HEAVY = {"kind": "heavy_cable", "axial_stiffness": 5e4, "mass_per_length": 0.1}
SAGGING = cables(*[HEAVY] * 4) | {"robot.cable_set": "basic"}
AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "pneumatic": ("pneumatic_elbow", {}),
    "hill": ("hill_arm", {}),
    "mixed": ("planar_2r", MIXED),
    "others": ("planar_2r", OTHERS),
    "motors": ("planar_2r", MOTORS),
    "winches": ("planar_2r", WINCHES),
    "sagging": ("planar_2r", SAGGING),
    "around": ("planar_2r", MIXED | AROUND | {"plant.substeps": 3}),
    "horizon": ("planar_2r", MIXED | {"controller.muscle_horizon": 0.02}),
}


def experiment_of(case: str, duration: float = 0.2) -> Experiment:
    example, settings = CASES[case]
    return Experiment.load(EXAMPLES / example, {"run.duration": duration, **settings})


@pytest.mark.native
@pytest.mark.parametrize("case", CASES)
def test_every_law_runs_in_the_loop_in_c(case: str) -> None:
    recording = native_loop(experiment_of(case)).run()
    assert recording.failure is None
    assert any(name.startswith("tension.") for name in recording.names)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["plant", "controller"])
@pytest.mark.parametrize("case", ["hill", "around"])
@pytest.mark.native
def test_restored_states_are_bit_identical(case: str, model: str, tmp_path: Path) -> None:
    """Continue after restoring a state; also in another instance, from serialised bytes."""
    file = build(experiment_of(case), tmp_path, compute="c")[model]
    check_states_repeat(file, tmp_path / "unpacked", step=5e-3)


@pytest.mark.slow
@pytest.mark.native
def test_command_that_is_not_finite_is_rejected_by_name(tmp_path: Path) -> None:
    file = build(experiment_of("mixed"), tmp_path, compute="c")["plant"]
    with running(file, tmp_path / "unpacked") as host:
        require_error(lambda: host.set(**{"u.cable_3": math.nan}) or host.slave.doStep(0.0, 1e-3))
        assert "u.cable_3" in host.last


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"estimator.feedback": True}, r"estimator: muscle 'cable_1' sags"),
        ({"muscles.cable_2.friction": 0.1}, r"muscles\.cable_2: .* it cannot have friction"),
    ],
)
def test_unsupported_use_of_heavy_cables_is_rejected(more: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Experiment.load(EXAMPLES / "planar_2r", SAGGING | more)
