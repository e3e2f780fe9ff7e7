"""States of native FMUs that are gone back to, bit for bit."""

from __future__ import annotations

from pathlib import Path

import fmpy

from .fmu_host import load


def check_states_repeat(file: Path, folder: Path, step: float) -> None:
    """Go on, go back, go on; and in another instance from serialised bytes.

    Args:
        file: An FMU of FMI 2.0.
        folder: Where to unpack it.
        step: In [s].
    """
    fmpy.extract(str(file), str(folder))
    description = fmpy.read_model_description(str(folder))
    host = load(folder)
    slave = host.slave
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    outputs = [
        v.valueReference
        for v in description.modelVariables
        if v.causality == "output" and v.type == "Real" and v.name != "solve_time"
    ]

    def begin() -> None:
        assert host.instantiate(slave.guid, (folder / "resources").as_uri())
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()

    def go(first: int, last: int) -> list[list[float]]:
        rows = []
        for k in range(first, last):
            inputs_set = [float(v.start) + 0.02 * (k % 4) for v in inputs]
            slave.setReal([v.valueReference for v in inputs], inputs_set)
            slave.doStep(k * step, step)
            rows.append(slave.getReal(outputs))
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
    slave.setFMUstate(slave.deSerializeFMUstate(stored))
    assert go(5, 12) == expected
    assert expected[0] != expected[-1]
    slave.fmi2FreeInstance(slave.component)
