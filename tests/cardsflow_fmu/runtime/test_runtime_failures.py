from __future__ import annotations

import ctypes
from pathlib import Path

import pytest
from support.fmu.fmu_host import STEP, Host, opened, plain_run, require_error
from toy_model import REFERENCES, ToyModel

from cardsflow_fmu.runtime.in_process import HostedModel

pytestmark = pytest.mark.native

FMI = ("2.0", "3.0")


def test_exception_in_step_is_logged(host: Host) -> None:
    host.start(fail_at=4.5 * STEP)
    assert (host.drive(0, 5) == plain_run(5)).all()
    require_error(lambda: host.slave.doStep(5 * STEP, STEP))
    (message,) = host.messages
    first, second, *_ = host.last.splitlines()
    assert message.category == "logStatusError"
    assert first == "doStep at 0.005 s: ValueError: 100 % broken at 0.005 s: größer als #1"
    assert second == "Traceback (most recent call last):"
    assert "toy_model.py" in host.last
    assert "_fail_when_asked" in host.last


def test_run_after_an_exception_equals_a_new_run(host: Host) -> None:
    host.start(fail_at=0.0)
    require_error(lambda: host.slave.doStep(0.0, STEP))
    require_error(lambda: host.get("x"))
    host.slave.reset()
    host.start()
    assert (host.drive(0, 50) == plain_run(50)).all()


def test_exception_does_not_affect_other_instances(toy_fmu: Path) -> None:
    with opened(toy_fmu, toy_fmu) as (one, two):
        one.start(fail_at=0.0)
        two.start()
        require_error(lambda: one.slave.doStep(0.0, STEP))
        assert (two.drive(0, 50) == plain_run(50)).all()
        assert two.messages == []


def test_keyboard_interrupt_is_logged(host: Host) -> None:
    host.slave.setBoolean([REFERENCES["interrupt"]], [True])
    host.start(fail_at=0.0)
    require_error(lambda: host.slave.doStep(0.0, STEP))
    assert host.last.startswith("doStep at 0 s: KeyboardInterrupt\nTraceback")


def test_exception_at_the_start_is_logged(host: Host, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ToyModel, "initialize", lambda self, t: 1 / 0)
    require_error(host.start)
    assert host.last.startswith("initialization: ZeroDivisionError: division by zero")


def test_model_that_cannot_be_created_again_is_reported(
    started: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    started.set(fail_at=0.0)
    require_error(lambda: started.slave.doStep(0.0, STEP))
    with monkeypatch.context() as patch:
        patch.setattr(ToyModel, "from_resources", lambda folder, values: 1 / 0)
        require_error(started.slave.reset)
        assert started.last.startswith("reset: ZeroDivisionError")
        require_error(started.slave.reset)
    started.slave.reset()
    started.start()
    assert (started.drive(0, 50) == plain_run(50)).all()


def test_model_whose_reset_fails_is_replaced(
    started: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    started.drive(0, 3)
    monkeypatch.setattr(ToyModel, "reset", lambda self: 1 / 0)
    started.slave.reset()
    started.start()
    assert (started.drive(0, 50) == plain_run(50)).all()


def test_invalid_results_of_a_model_are_reported(
    started: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ToyModel, "get_state", lambda self: None)
    require_error(started.slave.getFMUstate)
    assert started.last.startswith("getFMUstate: TypeError")


def test_failures_outside_of_the_model_are_reported(
    toy_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(self: HostedModel) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(HostedModel, "step", interrupted)
    monkeypatch.setattr(HostedModel, "get_state", lambda self: 1)
    with opened(toy_fmu, toy_fmu) as (one, two):
        one.start()
        state = one.slave.fmi2GetFMUstate
        require_error(lambda: state(one.slave.component, ctypes.byref(ctypes.c_void_p())))
        assert one.last == "getFMUstate: the model returned neither bytes nor a string"
        two.start()
        require_error(lambda: two.slave.doStep(0.0, STEP))
        assert two.last == "doStep at 0 s: <class 'KeyboardInterrupt'>"
