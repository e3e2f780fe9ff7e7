"""Native FMUs bit for bit: states that are gone back to, and outputs of the core."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np

from cardsflow_fmu import Experiment
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build

from .fmu_host import load, running


def check_bits(experiment: Experiment, folder: Path) -> None:
    """With commands, loads and wrenches at random: outputs of the FMU, and of the plant's model."""
    model = PlantModel(experiment)
    model.initialize()
    file = build(experiment, folder, compute="c")["plant"]
    rng, step = np.random.default_rng(3), experiment.run.step
    starts = np.array(model.inputs)
    with running(file, folder / "unpacked") as host:
        for k in range(300):
            model.inputs[:] = starts + 0.1 * rng.uniform(0, 1, starts.size)
            host.slave.setReal(host.of("input"), model.inputs.tolist())
            model.step(k * step, step)
            host.slave.doStep(k * step, step)
            np.testing.assert_array_equal(host.slave.getReal(host.of("output")), model.outputs)


def check_states_repeat(file: Path, folder: Path, step: float) -> None:
    """Go on, go back, continue; and in another instance from serialised bytes; for FMI 2.0."""
    fmpy.extract(str(file), str(folder))
    host = load(folder)
    slave = host.slave
    inputs = {
        v.name: float(v.start)
        for v in host.variables
        if v.causality == "input" and v.type == "Real"
    }
    outputs = [
        v.name
        for v in host.variables
        if v.causality == "output" and v.type == "Real" and v.name != "solve_time"
    ]

    def begin() -> None:
        assert host.instantiate(slave.guid, (folder / "resources").as_uri())
        host.start()

    def go(first: int, last: int) -> list[list[float]]:
        rows = []
        for k in range(first, last):
            host.set(**{name: start + 0.02 * (k % 4) for name, start in inputs.items()})
            slave.doStep(k * step, step)
            rows.append(host.get(*outputs))
        return rows

    begin()
    go(0, 5)
    state = slave.getFMUstate()
    stored = slave.serializeFMUstate(state)
    expected = go(5, 12)
    slave.setFMUstate(state)
    assert go(5, 12) == expected
    slave.freeFMUstate(state)
    slave.fmi2FreeInstance(slave.component)
    begin()
    host.restore(stored)
    assert go(5, 12) == expected
    assert expected[0] != expected[-1]
    slave.fmi2FreeInstance(slave.component)
