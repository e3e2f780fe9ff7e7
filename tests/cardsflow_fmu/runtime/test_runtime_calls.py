from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from support.fmu.fmu_host import STEP, Host, load, opened, plain_run, require_error
from toy_model import PORTS, REFERENCES

pytestmark = pytest.mark.native


def test_calls_before_initialization(toy_fmu: Path) -> None:
    calls: list[Callable[[Host], object]] = [
        lambda host: host.slave.exitInitializationMode(),
        lambda host: host.slave.doStep(0.0, STEP),
        lambda host: host.slave.terminate(),
        lambda host: host.get("x"),
        lambda host: host.slave.enterInitializationMode(),
    ]
    for call in calls:
        with opened(toy_fmu) as (host,):
            require_error(lambda call=call, host=host: call(host))
            assert "out of order" in host.last
            assert len(host.messages) == 1


def test_calls_in_step_mode(toy_fmu: Path) -> None:
    calls: list[Callable[[Host], object]] = [
        lambda host: host.slave.setupExperiment(startTime=0.0),
        lambda host: host.slave.enterInitializationMode(),
        lambda host: host.slave.exitInitializationMode(),
    ]
    for call in calls:
        with opened(toy_fmu) as (host,):
            host.start()
            require_error(lambda call=call, host=host: call(host))
            assert host.last.endswith("out of order, the instance is in step mode")


def test_failed_instance_accepts_only_reset(started: Host) -> None:
    require_error(lambda: started.slave.doStep(1.0, STEP))
    for call in (
        lambda: started.slave.doStep(0.0, STEP),
        lambda: started.set(u=0.0),
        lambda: started.get("x"),
        lambda: started.slave.getBoolean([REFERENCES["is_right"]]),
        lambda: started.slave.terminate(),
        lambda: started.slave.getFMUstate(),
        lambda: started.slave.enterInitializationMode(),
    ):
        require_error(call)
    assert len(started.messages) == 1
    started.slave.reset()
    started.start()
    assert (started.drive(0, 5) == plain_run(5)).all()


@pytest.mark.parametrize(
    ("time", "step", "message"),
    [
        (0.0, 0.0, "invalid step"),
        (0.0, -STEP, "invalid step"),
        (0.0, math.nan, "invalid step"),
        (math.inf, STEP, "invalid step"),
        (STEP, STEP, "starts at 0.001 s, but the last step ended at 0 s"),
        (-1e-8, STEP, "but the last step ended at 0 s"),
    ],
)
def test_discontinuous_steps_are_rejected(
    started: Host, time: float, step: float, message: str
) -> None:
    require_error(lambda: started.slave.doStep(time, step))
    assert message in started.last


def test_steps_end_at_the_stop_time(host: Host) -> None:
    host.slave.setupExperiment(startTime=0.0, stopTime=0.3)
    host.slave.enterInitializationMode()
    host.slave.exitInitializationMode()
    host.slave.doStep(0.0, 0.1)
    host.slave.doStep(0.1, 0.1)
    host.slave.doStep(0.2, 0.1)
    require_error(lambda: host.slave.doStep(0.3, 0.1))
    assert "after the stop time 0.3 s" in host.last


@pytest.mark.parametrize(("start", "stop"), [(math.nan, 1.0), (math.inf, None), (1.0, 0.5)])
def test_impossible_times_are_rejected(host: Host, start: float, stop: float | None) -> None:
    require_error(lambda: host.slave.setupExperiment(startTime=start, stopTime=stop))
    assert "invalid time from" in host.last


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_values_that_are_not_finite_are_rejected(started: Host, value: float) -> None:
    require_error(lambda: started.set(u=value))
    assert started.last.startswith("setReal: u cannot be")


def test_setting_outputs_is_rejected(started: Host) -> None:
    require_error(lambda: started.set(x=1.0))
    assert started.last == "setReal: x is an output and cannot be set"


def test_setting_boolean_outputs_is_rejected(started: Host) -> None:
    require_error(lambda: started.slave.setBoolean([REFERENCES["is_right"]], [True]))
    assert started.last == "setBoolean: is_right is an output and cannot be set"


def test_setting_fixed_parameters_in_step_mode_is_rejected(started: Host) -> None:
    require_error(lambda: started.set(stiffness=1.0))
    assert "stiffness is a fixed parameter" in started.last


@pytest.mark.parametrize("reference", [len(PORTS), 2**32 - 1])
def test_unknown_references_are_rejected(toy_fmu: Path, reference: int) -> None:
    for call in (
        lambda slave: slave.getReal([reference]),
        lambda slave: slave.setReal([reference], [1.0]),
        lambda slave: slave.getBoolean([reference]),
        lambda slave: slave.setBoolean([reference], [1]),
    ):
        with opened(toy_fmu) as (host,):
            host.start()
            require_error(lambda call=call, host=host: call(host.slave))
            assert f"unknown value reference {reference}; the last one is 9" in host.last


def test_other_types_are_rejected(toy_fmu: Path) -> None:
    for call, message in (
        (lambda slave: slave.getReal([1]), "locked (value reference 1) is a boolean variable"),
        (lambda slave: slave.setReal([1], [1.0]), "is a boolean variable"),
        (lambda slave: slave.getBoolean([0]), "u (value reference 0) is a real variable"),
        (lambda slave: slave.setBoolean([0], [1]), "is a real variable"),
        (lambda slave: slave.getInteger([0]), "no integer or string variables"),
        (lambda slave: slave.setInteger([0], [1]), "no integer or string variables"),
        (lambda slave: slave.getString([0]), "no integer or string variables"),
        (lambda slave: slave.setString([0], ["a"]), "no integer or string variables"),
    ):
        with opened(toy_fmu) as (host,):
            host.start()
            require_error(lambda call=call, host=host: call(host.slave))
            assert message in host.last


def test_null_pointers_without_variables(started: Host) -> None:
    slave = started.slave
    for name in ("Real", "Boolean", "Integer", "String"):
        for verb in ("Get", "Set"):
            call = getattr(slave, f"fmi2{verb}{name}")
            assert call(slave.component, None, 0, None) == fmi2.fmi2OK


def test_null_pointers_with_variables(started: Host) -> None:
    slave = started.slave
    require_error(lambda: slave.fmi2GetReal(slave.component, None, 1, None))
    assert "null pointer" in started.last


def test_null_component(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    for name in ("DoStep", "GetReal", "SetFMUstate", "Reset", "CancelStep", "GetStatus"):
        function = getattr(host.slave.dll, f"fmi2{name}")
        function.argtypes = None
        assert function(None, None, None, None, None) == fmi2.fmi2Error
    host.slave.fmi2FreeInstance(None)
    host.slave.freeLibrary()


def test_unsupported_optional_functions_report_errors(started: Host) -> None:
    slave = started.slave
    for call in (
        lambda: slave.getDirectionalDerivative([2], [0], [1.0]),
        lambda: slave.setRealInputDerivatives([0], [1], [1.0]),
        lambda: slave.getRealOutputDerivatives([2], [1]),
        lambda: slave.cancelStep(),
    ):
        before = len(started.messages)
        require_error(call)
        assert len(started.messages) == before + 1
    assert (started.drive(0, 5) == plain_run(5)).all()


def test_status_requests(started: Host) -> None:
    slave = started.slave
    started.drive(0, 2)
    assert slave.getRealStatus(fmi2.fmi2LastSuccessfulTime) == 2 * STEP
    assert slave.getBooleanStatus(fmi2.fmi2Terminated) is False
    for call in (slave.getStatus, slave.getStringStatus, slave.getIntegerStatus):
        with pytest.raises(FMICallException) as caught:
            call(fmi2.fmi2DoStepStatus)
        assert caught.value.status == fmi2.fmi2Discard
