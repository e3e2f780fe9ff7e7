"""Requests of directional derivatives by FMI 2.0 and FMI 3.0, and FMUs without them."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from support.fmu.fmu_host import require_error, running
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment, build
from cardsflow_fmu.fmu.description import FmiVersion

pytestmark = pytest.mark.native

STEP = 1e-3


def final_position(file: Path, folder: Path, version: FmiVersion, *, asks: bool) -> float:
    """Return the first position after two steps, between which derivatives may be requested."""
    with running(file, folder) as host:
        slave, references = host.slave, host.references
        q, *forces = (references[name] for name in ("q.joint_1", "f.cable_1", "f.cable_2"))
        more = [1] if version == "3.0" else []

        def ask(unknown: int, knowns: list[int], *seeds: float) -> float:
            (slope,) = slave.getDirectionalDerivative([unknown], knowns, list(seeds), *more)
            return float(slope)

        slave.doStep(0.0, STEP)
        if asks:
            one, two = (ask(q, [force], 1.0) for force in forces)
            assert ask(q, forces, 2.0, -3.0) == pytest.approx(2.0 * one - 3.0 * two)
            require_error(lambda: ask(forces[0], forces[1:], 1.0))  # an input is not an unknown
            require_error(lambda: ask(q, [q + 10**6], 1.0))
            require_error(lambda: ask(q, forces[:1], np.nan))
        slave.doStep(STEP, STEP)
        (position,) = slave.getReal([q]) if version == "2.0" else slave.getFloat64([q])
        slave.terminate()
        return float(position)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_requests_do_not_change_a_run(version: FmiVersion, tmp_path: Path) -> None:
    """Neither valid requests, which are linear, nor invalid ones."""
    file = build(Experiment.load(PLANAR_2R), tmp_path, fmi=version, arrays=False)["plant"]
    with_, without = (
        final_position(file, tmp_path / str(asks), version, asks=asks) for asks in (True, False)
    )
    assert with_ == without


@pytest.mark.slow
def test_fmus_with_a_python_model_declare_no_derivatives(tmp_path: Path) -> None:
    for file in build(Experiment.load(PLANAR_2R), tmp_path, compute="python").values():
        description = fmpy.read_model_description(str(file))
        assert not description.coSimulation.providesDirectionalDerivative
