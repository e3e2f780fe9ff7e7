"""Results are identical for all values of `compute` and `coupling`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.cases import sample_cases
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.run_modes import RUN_MODES

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate

AROUND = {"controller.ki": 500.0, "controller.observer": 20.0, "controller.delay": 1}
ORDER = ["plant", "reference", "controller"]
HELD = {"qd_d.joint_1": 0.0, "q.joint_2": "plant.q.joint_1"}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "sampled": ("planar_2r", {}),
    "contacts": ("pick_up", {}),
    "held input": ("planar_2r", {"wiring": {"controller": HELD}}),
    "gauss_seidel": ("planar_2r", {"run.scheme": "gauss_seidel", "run.order": ORDER}),
    "muscle laws": ("hill_arm", {"plant.energy": True, "plant.integrator": "rk4"}),
    "tasks": ("cable_robot", {}),
    "jacobi": ("planar_2r", {"run.scheme": "jacobi"}),
    "slow controller": (
        "planar_2r",
        {"controller.period": 0.002, "run.step": 0.0005, "plant.step": 0.00025},
    ),
    "last tick beyond the end": ("planar_2r", {"controller.period": 0.003}),
    "control loop": ("roboy_left_arm", AROUND),
    "no force": ("roboy_left_arm", {"disturbance": {"force": {"hand": [0, 0, 0]}, "known": True}}),
    "closed loops": ("bicycle", {}),
    "estimator": ("roboy_left_arm", {"estimator.exact_transition": True}),
    "another solver": ("planar_2r", {"controller.solver": "osqp"}),
}


@pytest.mark.parametrize("case", sample_cases(CASES, 5))
def test_results_do_not_depend_on_compute_and_coupling(case: str) -> None:
    """Compare the masters in C and Python, and FMUs in C and with a Python process."""
    example, settings = CASES[case]
    experiment = Experiment.load(EXAMPLES / example, {"run.duration": 0.05} | settings)
    first, *others = (simulate(experiment, **way) for way in RUN_MODES.values())
    for other in others:
        assert (other.names, other.units) == (first.names, first.units)
        np.testing.assert_array_equal(other.rows, first.rows)
        np.testing.assert_array_equal(other.solve_times[:, 0], first.solve_times[:, 0])


PLAIN = """
import sys
from cardsflow_fmu.cli.main import main
assert main(["run", {example!r}, "--set", "run.duration=0.02", "-o", {folder!r}]) == 0
print([name for name in sys.modules if name.startswith("cardsflow_fmu.hardware")])
"""


def test_run_without_hardware_does_not_import_it(tmp_path: Path) -> None:
    script = PLAIN.format(example=str(PLANAR_2R), folder=str(tmp_path / "out"))
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
