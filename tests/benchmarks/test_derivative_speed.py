"""Cost of derivatives: `pytest tests/benchmarks/test_derivative_speed.py -s`.

Compare the directional derivative of all outputs over a communication step with the step itself,
through FMI 2.0. A derivative call first evaluates the plant at the current state. Without substeps
this takes a large part of the time.
"""

from __future__ import annotations

from ctypes import c_double, c_uint
from pathlib import Path
from typing import Any

import fmpy
import pytest
from support.fmu.fmu_host import load
from support.interleaved import interleaved, record
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build

LIMITS = [(1, 7.0), (20, 4.0)]
"""Number of substeps, and largest cost of a derivative relative to a step."""
EXAMPLE_ROBOTS = ["planar_2r", "roboy_left_arm", "pneumatic_elbow", "hill_arm"]


@pytest.mark.parametrize(("substeps", "limit"), LIMITS)
@pytest.mark.parametrize("example", EXAMPLE_ROBOTS)
def test_directional_derivative_cost(
    example: str, substeps: int, limit: float, tmp_path: Path
) -> None:
    settings: dict[str, Any] = {"plant.energy": False, "plant.substeps": substeps}
    experiment = Experiment.load(EXAMPLES / example, settings)
    file = build(experiment, tmp_path / "out", compute="c")["plant"]
    fmpy.extract(str(file), str(tmp_path / "fmu"))
    step, host = experiment.run.step, load(tmp_path / "fmu")
    host.open()
    host.start()
    slave, inputs, outputs = host.slave, host.of("input"), host.of("output")
    unknowns, knowns = (c_uint * len(outputs))(*outputs), (c_uint * len(inputs))(*inputs)
    seeds, answers = (c_double * len(inputs))(*[1.0] * len(inputs)), (c_double * len(outputs))()
    time = [0.0]

    def ours() -> None:
        slave.fmi2GetDirectionalDerivative(
            slave.component, unknowns, len(outputs), knowns, len(inputs), seeds, answers
        )

    def plain() -> None:
        slave.fmi2DoStep(slave.component, time[0], step, 1)
        time[0] += step

    def empty_call() -> None:
        slave.fmi2GetReal(slave.component, unknowns, 0, answers)

    times = interleaved(
        {"step": plain, "derivative": ours, "call": empty_call}, calls=20, rounds=60
    )
    ratio = (times["derivative"] - times["call"]) / (times["step"] - times["call"])
    record(
        f"derivative, {example}, {substeps} substeps",
        step_ratio=ratio,
        step_us=(times["step"] - times["call"]) * 1e6,
        derivative_us=(times["derivative"] - times["call"]) * 1e6,
    )
    assert ratio <= limit
