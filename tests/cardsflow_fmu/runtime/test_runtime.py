from __future__ import annotations

import gc
import threading
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import fmi2
from support.fmu.fmu_host import STEP, Host, opened, plain_run, require_error, unpack
from toy_model import REFERENCES, OtherToyModel, ToyModel

from cardsflow_fmu.fmu.description import FmiVersion

pytestmark = pytest.mark.native

FMI = ("2.0", "3.0")


INTEGER_MAX = 2**31 - 1


def test_fmu_equals_the_plain_class(host: Host) -> None:
    host.start(stiffness=55.5, gain=0.7)
    outputs = host.drive(0, 500)
    assert (outputs == plain_run(500, stiffness=55.5, gain=0.7)).all()


def test_fmpy_simulates_the_fmu(toy_fmu: Path) -> None:
    result = fmpy.simulate_fmu(
        str(toy_fmu), stop_time=0.3, step_size=STEP, output_interval=STEP, output=["x"]
    )
    assert len(result) == 301
    assert result["x"][0] == 0.25


def test_boolean_variables(started: Host, fmi: FmiVersion) -> None:
    locked, is_right = REFERENCES["locked"], REFERENCES["is_right"]
    assert started.slave.getBoolean([is_right, locked]) == [True, False]
    started.slave.setBoolean([locked], [INTEGER_MAX if fmi == "2.0" else True])
    started.slave.doStep(0.0, STEP)
    assert started.get("x") == [0.25]
    assert started.slave.getBoolean([locked]) == [True]


def test_instances_of_one_fmu_are_independent(toy_fmu: Path) -> None:
    with opened(toy_fmu, toy_fmu) as (one, two):
        one.start(gain=1.0)
        two.start(gain=-2.0)
        rows = [(one.drive(k, k + 1)[0], two.drive(k, k + 1)[0]) for k in range(200)]
    assert (np.array(rows)[:, 0] == plain_run(200, gain=1.0)).all()
    assert (np.array(rows)[:, 1] == plain_run(200, gain=-2.0)).all()


def test_fmus_are_independent(toy_fmu: Path, tmp_path: Path, fmi: FmiVersion) -> None:
    other = unpack(tmp_path / "other", OtherToyModel, "other", 0.5, fmi)
    with opened(toy_fmu, other) as (one, two):
        one.start()
        two.start()
        rows = [(one.drive(k, k + 1)[0], two.drive(k, k + 1)[0]) for k in range(200)]
    assert (np.array(rows)[:, 0] == plain_run(200)).all()
    assert (np.array(rows)[:, 1] == plain_run(200, OtherToyModel(0.5))).all()


def test_steps_in_several_threads(toy_fmu: Path) -> None:
    rows = {}
    with opened(toy_fmu, toy_fmu) as hosts:

        def run(index: int) -> None:
            hosts[index].start()
            rows[index] = hosts[index].drive(0, 300)

        threads = [threading.Thread(target=run, args=(index,)) for index in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert (rows[0] == plain_run(300)).all()
    assert (rows[1] == rows[0]).all()


def test_initial_outputs_depend_on_set_values(host: Host) -> None:
    host.slave.setupExperiment(startTime=0.0)
    host.slave.enterInitializationMode()
    assert host.get("x", "stiffness") == [0.25, 40.0]
    host.set(stiffness=1.0)
    assert host.get("x", "stiffness") == [0.25, 1.0]
    host.slave.exitInitializationMode()
    assert (host.drive(0, 10) == plain_run(10, stiffness=1.0)).all()


def test_tunable_parameters_take_effect_immediately(started: Host) -> None:
    started.set(gain=0.0, u=1e9)
    started.slave.doStep(0.0, STEP)
    assert started.get("v") == [-STEP * 40.0 * 0.25]


def test_reset_restores_the_start(started: Host) -> None:
    started.set(gain=3.0)
    started.drive(0, 10)
    started.slave.reset()
    started.start()
    assert (started.drive(0, 50) == plain_run(50)).all()


def test_start_time(host: Host) -> None:
    host.slave.setupExperiment(startTime=-2.0)
    host.slave.enterInitializationMode()
    host.slave.exitInitializationMode()
    host.slave.doStep(-2.0, STEP)
    assert host.slave.getRealStatus(fmi2.fmi2LastSuccessfulTime) == -2.0 + STEP


def test_accumulated_time_of_a_host_is_accepted(started: Host) -> None:
    time = 0.0
    for _ in range(20000):
        started.slave.doStep(time, STEP)
        time += STEP


def test_terminated_outputs_can_be_read(started: Host) -> None:
    outputs = started.drive(0, 3)
    started.slave.terminate()
    assert (started.get("x", "v", "work") == outputs[-1]).all()
    require_error(lambda: started.set(u=1.0))


@pytest.mark.slow
def test_free_instance_frees_the_model(toy_fmu: Path) -> None:
    gc.collect()
    before = len(ToyModel.alive)
    with opened(toy_fmu) as (host,):
        host.start()
        host.drive(0, 3)
        assert len(ToyModel.alive) == before + 1
    assert len(ToyModel.alive) == before


def test_memory_outlives_the_model(toy_fmu: Path) -> None:
    before = set(ToyModel.alive)
    with opened(toy_fmu) as (host,):
        host.start()
        (model,) = set(ToyModel.alive) - before
    model.inputs[0] = 1.0
    model.step(0.0, STEP)
