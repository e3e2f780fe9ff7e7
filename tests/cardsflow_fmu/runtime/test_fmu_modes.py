"""Python FMUs in the process of the host and in a worker process."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from stubborn_model import RAISE
from support.fmu.fmu_host import (
    STEP,
    Host,
    cannot_open,
    load,
    opened,
    plain_run,
    require_error,
    unpack,
    unpacked,
)
from support.fmu.worker_host import opened_stubborn, sums
from toy_model import REFERENCES, OtherToyModel, ToyModel

pytestmark = pytest.mark.native

REPEATS = int(os.environ.get("CARDSFLOW_TEST_REPEATS", "3"))

EQUAL_NAMES = """
from pathlib import Path
from cardsflow_fmu.runtime.model import FmuModel
from cardsflow_fmu.cosim.signals.ports import Port

PORTS = (Port("y", "", "output", "discrete", "Which one"),)


class Model(FmuModel):
    def __init__(self, values=None):
        super().__init__(PORTS, values)

    @classmethod
    def from_resources(cls, folder, values=None):
        return cls(values)

    def initialize(self, t=0.0):
        self.outputs[0] = {number}

    def step(self, t, h):
        pass

    def get_state(self):
        return b""

    def set_state(self, state):
        pass
"""


@pytest.fixture(params=["in-process", "worker"])
def mode(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the process in which models run."""
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", request.param)
    return str(request.param)


@pytest.fixture
def instance(mode: str, toy_fmu: Path) -> Iterator[Host]:
    """Return a new instance of the toy."""
    with opened(toy_fmu) as (host,):
        yield host


def test_model_runs_in_the_selected_process(mode: str, stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        assert (host.value("process") == os.getpid()) == (mode == "in-process")


@pytest.mark.slow
def test_run_equals_the_plain_class(instance: Host) -> None:
    instance.start(stiffness=55.5, gain=0.7)
    assert (instance.drive(0, 300) == plain_run(300, stiffness=55.5, gain=0.7)).all()


@pytest.mark.slow
def test_two_classes_in_one_host(mode: str, toy_fmu: Path, tmp_path: Path) -> None:
    other = unpack(tmp_path / "other", OtherToyModel, "other", 0.5)
    with opened(toy_fmu, other) as (one, two):
        one.start()
        two.start()
        assert (one.drive(0, 50) == plain_run(50)).all()
        assert (two.drive(0, 50) == plain_run(50, OtherToyModel(0.5))).all()


@pytest.mark.slow
def test_two_modules_with_the_same_name(
    mode: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hosts = []
    for number in (1, 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "equal_name.py").write_text(EQUAL_NAMES.replace("{number}", str(number)))
        with monkeypatch.context() as patch:
            patch.syspath_prepend(str(folder))
            patch.delitem(sys.modules, "equal_name", raising=False)
            import equal_name  # type: ignore[import-not-found]

            hosts.append(load(unpacked(folder / "equal", equal_name.Model, equal_name.PORTS)))
        sys.modules.pop("equal_name")
    for host in hosts:
        host.open()
        host.start()
    assert [host.slave.getReal([0]) for host in hosts] == [[1.0], [2.0]]
    for host in hosts:
        host.slave.freeInstance()


@pytest.mark.parametrize("when", ["initialize", "step"])
def test_exceptions_reach_the_log(instance: Host, when: str) -> None:
    if when == "initialize":
        instance.slave.setupExperiment(startTime=0.0)
        instance.slave.enterInitializationMode()
        instance.slave.setBoolean([REFERENCES["interrupt"]], [True])
        instance.slave.exitInitializationMode()
        instance.set(fail_at=0.0)
        require_error(lambda: instance.slave.doStep(0.0, STEP))
        assert instance.last.startswith("doStep at 0 s: KeyboardInterrupt\nTraceback")
    else:
        instance.start(fail_at=0.0)
        require_error(lambda: instance.slave.doStep(0.0, STEP))
        assert "ValueError: 100 % broken at 0.0 s: größer als #1\nTraceback" in instance.last
    assert "toy_model.py" in instance.last
    require_error(lambda: instance.get("x"))
    require_error(lambda: instance.slave.doStep(0.0, STEP))
    instance.slave.reset()
    instance.start()
    assert (instance.drive(0, 50) == plain_run(50)).all()


@pytest.mark.cases(1)
@pytest.mark.slow
def test_twenty_instances(mode: str, stubborn_fmu: Path) -> None:
    hosts = [load(stubborn_fmu, f"number {i}") for i in range(20)]
    for host in hosts:
        host.open()
        host.start()
    for k in range(5):
        for i, host in enumerate(hosts):
            host.set(u=float(i))
            host.slave.doStep(k * STEP, STEP)
    assert [host.value("sum") for host in hosts] == [5.0 * i for i in range(20)]
    for host in hosts:
        host.slave.freeInstance()


@pytest.mark.slow
def test_instances_can_be_freed_at_any_time(mode: str, stubborn_fmu: Path) -> None:
    for stage in range(5):
        host = load(stubborn_fmu)
        host.open()
        if stage >= 1:
            host.slave.setupExperiment(startTime=0.0)
            host.slave.enterInitializationMode()
        if stage >= 2:
            host.slave.exitInitializationMode()
        if stage >= 3:
            host.set(action=RAISE)
            require_error(lambda host=host: host.slave.doStep(0.0, STEP))
        if stage >= 4:
            host.slave.reset()
        host.slave.freeInstance()


@pytest.mark.slow
def test_repeated_failures_resets_and_frees(mode: str, stubborn_fmu: Path) -> None:
    """The full number of repetitions is `CARDSFLOW_TEST_REPEATS=200`."""
    for _ in range(REPEATS):
        with opened_stubborn(stubborn_fmu) as host:
            host.set(action=RAISE)
            require_error(lambda host=host: host.slave.doStep(0.0, STEP))
            require_error(lambda host=host: host.value("sum"))
            host.slave.reset()
            host.start()
            assert sums(host, 0, 3) == [0.0, 1.0, 3.0]


@pytest.mark.parametrize("size", [0, 65528, 65529, 300_000])
def test_states_of_any_size(mode: str, stubborn_fmu: Path, size: int) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        host.set(state_size=float(size))
        sums(host, 0, 5)
        state = host.slave.getFMUstate()
        first = sums(host, 5, 9)
        host.slave.setFMUstate(state)
        host.slave.freeFMUstate(state)
        assert sums(host, 5, 9) == first
        assert len(host.save()) > size


@pytest.mark.slow
def test_state_is_restored_in_the_other_mode(
    mode: str, toy_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with opened(toy_fmu) as (one,):
        one.start(stiffness=7.0)
        one.drive(0, 10)
        data = one.save()
        rest = one.drive(10, 50)
    other = "worker" if mode == "in-process" else "in-process"
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", other)
    with opened(toy_fmu) as (two,):
        two.restore(data)
        assert (two.drive(10, 50) == rest).all()
    assert (rest == plain_run(50, stiffness=7.0)[10:]).all()


def test_model_that_cannot_be_created_is_reported(mode: str, damaged: Path) -> None:
    (damaged / "resources/x_start.txt").write_text("far")
    message = cannot_open(damaged)
    assert message.startswith("ValueError: could not convert string to float: 'far'\nTraceback")


def test_unknown_mode_is_rejected(toy_fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "elsewhere")
    assert cannot_open(toy_fmu) == "CARDSFLOW_FMU_HOST must be in-process or worker, not elsewhere"


def test_toy_class_is_in_the_fmu(toy_fmu: Path) -> None:
    """Its module is in the FMU, for processes that cannot import it."""
    assert (toy_fmu / "resources/python/toy_model.py").read_bytes() == Path(
        sys.modules[ToyModel.__module__].__file__ or ""
    ).read_bytes()
