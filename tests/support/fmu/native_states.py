"""Bitwise checks of restored states of native FMUs."""

from __future__ import annotations

from pathlib import Path

import fmpy

from .fmu_host import load


def check_states_repeat(file: Path, folder: Path, step: float) -> None:
    """Check that steps from a restored state repeat, also in another instance, with FMI 2.0."""
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
